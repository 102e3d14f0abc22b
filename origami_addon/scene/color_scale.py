"""One colour scale for all values where smaller is better."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

WORST_PIXELS = 2.0  # of a point's reprojection error
WORST_STRETCH = 0.02  # of a triangle, relative
WORST_BOUND = 0.003  # of a place's error, page heights: a millimetre of A4, which straight rules show

_GOOD, _MIDDLE, _BAD = np.array([[0.1, 0.3, 1.0], [1.0, 1.0, 1.0], [1.0, 0.1, 0.05]])


def colors(values: NDArray[np.floating], worst: float) -> NDArray[np.float32]:
    """RGBA (N, 4) for values (N,): from blue at 0 over white to red at ``worst`` and beyond."""
    share = np.clip(np.nan_to_num(values, nan=worst) / worst, 0, 1)[:, None]
    low = _GOOD + (_MIDDLE - _GOOD) * 2 * share
    high = _MIDDLE + (_BAD - _MIDDLE) * (2 * share - 1)
    return np.column_stack([np.where(share < 0.5, low, high), np.ones(len(share))]).astype(np.float32)
