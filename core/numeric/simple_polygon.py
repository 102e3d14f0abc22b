"""Polygons that bound one area: neither cross nor touch themselves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from .polygon import perimeter

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
    return _first_meeting(polygon) is None


def without_loops(polygon: Array) -> Array:
    """A closed polygon cut off where it meets itself, so that it is simple: the shorter part goes.

    Parameters
    ----------
    polygon : (K, 2) array
        The first corner is not repeated.

    Returns
    -------
    (L, 2) array
        The polygon itself if it is simple; fewer than three corners if it bounds no area.

    Examples
    --------
    >>> without_loops(np.array([[0, 0], [9, 0], [9, 9], [4, 9], [5, 10], [5, 8], [0, 9]], float))
    array([[5., 9.],
           [5., 8.],
           [0., 9.],
           [0., 0.],
           [9., 0.],
           [9., 9.]])
    """
    while len(polygon) > 2 and (meeting := _first_meeting(polygon)) is not None:
        one, other = sorted(meeting)
        place = _meeting_place(polygon, one, other)
        inner, outer = polygon[one + 1 : other + 1], np.concatenate([polygon[other + 1 :], polygon[: one + 1]])
        kept = max((np.vstack([place, part]) for part in (inner, outer)), key=perimeter)
        polygon = kept[np.any(kept != np.roll(kept, 1, axis=0), axis=1)]
    return polygon


def _rounding_of(polygon: Array) -> float:
    return _ROUNDING * float(np.ptp(polygon, axis=0).max()) ** 2


def _meeting_place(polygon: Array, one: int, other: int) -> Array:
    """Where two edges of a polygon meet (2,): at a corner of one that lies on the other, or where they cross."""
    count = len(polygon)
    rounding = _rounding_of(polygon)
    for edge, corner in ((one, other), (one, other + 1), (other, one), (other, one + 1)):
        point, start, end = polygon[corner % count], polygon[edge], polygon[(edge + 1) % count]
        shared = corner % count in (edge, (edge + 1) % count)
        if not shared and _on_edge(point, start, end, rounding):
            return np.asarray(point)
    start, side = polygon[one], polygon[(one + 1) % count] - polygon[one]
    other_start, other_side = polygon[other], polygon[(other + 1) % count] - polygon[other]
    return np.asarray(start + side * _cross(other_start - start, other_side) / _cross(side, other_side))


def _first_meeting(polygon: Array) -> tuple[int, int] | None:
    """Two edges, by their first corners, that meet elsewhere than at a corner between them; None if there are none."""
    starts, ends = polygon, np.roll(polygon, -1, axis=0)
    count = len(polygon)
    rounding = _rounding_of(polygon)
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
        pairs = order[one], order[one + 1 + behind]
        met = np.flatnonzero(_meet(starts, ends, *pairs, rounding))
        if len(met):
            return int(pairs[0][met[0]]), int(pairs[1][met[0]])
    return None


def _meet(
    starts: Array, ends: Array, one: NDArray[np.int64], other: NDArray[np.int64], rounding: float
) -> NDArray[np.bool_]:
    """Which of these pairs of edges (N,) meet elsewhere than at the corner between them."""
    count = len(starts)
    start, end, other_start, other_end = starts[one], ends[one], starts[other], ends[other]
    before, after = (one + 1) % count == other, (other + 1) % count == one
    touch = (_on_edge(other_start, start, end, rounding) & ~before) | (
        _on_edge(start, other_start, other_end, rounding) & ~after
    )
    side, other_side = end - start, other_end - other_start
    apart = _cross(side, other_start - start) * _cross(side, other_end - start) < 0
    crossed = _cross(other_side, start - other_start) * _cross(other_side, end - other_start) < 0
    return np.asarray(touch | (apart & crossed & ~before & ~after))


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
