"""CIELAB, in which archives state the lightness, the colour and the noise of a page."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# Linear sRGB to X, Y and Z (IEC 61966-2-1), divided by those of its white, D65.
_TO_XYZ = (
    np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    / np.array([[0.9505], [1.0], [1.0890]])
)  # fmt: skip
_CUBE = (6 / 29) ** 3  # above it, a cube root; below it, a line with the root's slope there


def cielab(linear: NDArray[np.floating]) -> NDArray[np.floating]:
    """Linear sRGB (..., 3), 0 to 1, as L*, a* and b* (..., 3) under its white, D65.

    Examples
    --------
    >>> cielab(np.array([[1.0, 1, 1], [0.18, 0.18, 0.18], [1, 0, 0]])).round(1) + 0.0
    array([[100. ,   0. ,   0. ],
           [ 49.5,   0. ,   0. ],
           [ 53.2,  80.1,  67.2]])
    """
    share = linear @ _TO_XYZ.T.astype(linear.dtype)
    x, y, z = np.moveaxis(np.where(share > _CUBE, np.cbrt(share), share / (3 * (6 / 29) ** 2) + 4 / 29), -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)
