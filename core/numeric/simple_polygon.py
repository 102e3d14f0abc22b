"""Checks that a polygon given by hand bounds one area."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array

# Cross products below this share of the squared size of the polygon are rounding.
_ROUNDING = 1e-12
_PAIRS_AT_A_TIME = 1 << 18


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
    # Only edges side by side along the longer way can meet: of many corners, few of them are compared.
    axis = int(np.ptp(polygon, axis=0).argmax())
    first, last = np.minimum(starts, ends)[:, axis], np.maximum(starts, ends)[:, axis]
    order = np.argsort(first, kind="stable")
    compared = np.searchsorted(first[order], last[order], side="right") - np.arange(count) - 1
    batch = np.cumsum(compared) // _PAIRS_AT_A_TIME
    for places in np.split(np.arange(count), np.flatnonzero(np.diff(batch)) + 1):
        many = compared[places]
        behind = np.arange(many.sum()) - np.repeat(np.cumsum(many) - many, many)
        one = np.repeat(places, many)
        if _meet(starts, ends, order[one], order[one + 1 + behind], rounding):
            return False
    return True


def _meet(starts: Array, ends: Array, one: NDArray[np.int64], other: NDArray[np.int64], rounding: float) -> bool:
    """Whether any of these pairs of edges (N,) meet elsewhere than at the corner between them."""
    count = len(starts)
    start, end, other_start, other_end = starts[one], ends[one], starts[other], ends[other]
    before, after = (one + 1) % count == other, (other + 1) % count == one
    if (_on_edge(other_start, start, end, rounding) & ~before).any():
        return True
    if (_on_edge(start, other_start, other_end, rounding) & ~after).any():
        return True
    side, other_side = end - start, other_end - other_start
    apart = _cross(side, other_start - start) * _cross(side, other_end - start) < 0
    crossed = _cross(other_side, start - other_start) * _cross(other_side, end - other_start) < 0
    return bool((apart & crossed & ~before & ~after).any())


def _on_edge(point: Array, start: Array, end: Array, rounding: float) -> NDArray[np.bool_]:
    """Whether points (..., 2) lie on edges, their ends included."""
    along, to_point = end - start, point - start
    place = (along * to_point).sum(-1)
    near = np.abs(_cross(along, to_point)) <= rounding
    inside: NDArray[np.bool_] = near & (place >= 0) & (place <= (along**2).sum(-1))
    return inside


def _cross(first: Array, second: Array) -> NDArray[np.float64]:
    product: NDArray[np.float64] = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
    return product
