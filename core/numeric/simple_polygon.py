"""Checks that a polygon given by hand bounds one area."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array

# Cross products below this share of the squared size of the polygon are rounding.
_ROUNDING = 1e-12


def is_simple(polygon: Array) -> bool:
    """Whether a closed polygon neither crosses nor touches itself.

    Parameters
    ----------
    polygon : (K, 2) array
        At least three corners, the first not repeated. Corners within a straight side are allowed, two corners in one
        place are not.
    """
    starts, ends = polygon, np.roll(polygon, -1, axis=0)
    count = len(polygon)
    rounding = _ROUNDING * float(np.ptp(polygon, axis=0).max()) ** 2
    for edge in range(count):
        start, along = starts[edge], ends[edge] - starts[edge]
        other = np.ones(count, bool)
        other[[edge, (edge + 1) % count]] = False
        offset = _cross(along, starts - start)
        place = (starts - start) @ along
        on_edge = (np.abs(offset) <= rounding) & (place >= 0) & (place <= along @ along)
        if (on_edge & other).any():
            return False
        apart = offset * np.roll(offset, -1) < 0
        sides = ends - starts
        crossed = _cross(sides, start - starts) * _cross(sides, ends[edge] - starts) < 0
        other[edge - 1] = False
        if (apart & crossed & other).any():
            return False
    return True


def _cross(first: Array, second: Array) -> NDArray[np.float64]:
    product: NDArray[np.float64] = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
    return product
