"""Peaks between samples."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

# A curvature below this comes from rounding errors.
_FLAT = 1e-9

Real = TypeVar("Real", bound=np.floating)


def peak_offset(before: NDArray[Real], here: NDArray[Real], after: NDArray[Real]) -> NDArray[Real]:
    """The peak of the parabola through three samples, in steps from the middle one; 0 if there is none.

    Parameters
    ----------
    before, here, after : (...) arrays
        Values at steps -1, 0 and 1.

    Examples
    --------
    >>> at = np.array([-1.0, 0.0, 1.0])
    >>> before, here, after = 5 - (at - 0.3) ** 2
    >>> round(float(peak_offset(before, here, after)), 6)
    0.3
    """
    bend = before - 2 * here + after
    peaked = bend < -_FLAT
    return np.asarray(np.where(peaked, 0.5 * (before - after) / np.where(peaked, bend, 1), 0))
