"""Quadrilaterals about a region whose sides lie on other edges, parallel to its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..numeric.image import sample_bilinear
from .edge_strips import even_steps
from .sides_search import ALONG, BESIDE, CLEAR_STEP, outwards

# None of these was tuned: they were chosen on a white sheet on a white table, and left so.
# The part of a side that may be covered, or have no step.
_COVERED = 0.25
# How far a side is moved inwards and outwards, in parts of the quadrilateral's depth, and what must be left of that.
_INWARD, _OUTWARD = 0.6, 1.0
_LEAST_DEPTH = 0.25
# Cells between two edges, and the evenness, of 1.5 at most, below which a line is none.
_APART = 5
_LEAST_EVEN = 0.12
# The faintest side decides between quadrilaterals; the mean of all four counts this much.
_OF_MEAN = 0.3
# For each side this many of the evenest edges are tried, and this many of the nearest ones outwards.
_EVENEST, _NEAREST = 4, 2


def quadrilaterals_on_parallel_edges(color: NDArray[np.float32], corners: Array, most: int) -> Array:
    """Quadrilaterals with each side in its place or moved to another edge, the likeliest first.

    The sheet's edge is beside a region that ends at print, and inside a board on which the sheet lies.

    Parameters
    ----------
    color : (h, w, 3) float32 array
        The map.
    corners : (4, 2) array
        Map positions, clockwise.
    most : int
        The largest number of quadrilaterals.

    Returns
    -------
    (M, 4, 2) array
    """
    turned = [np.roll(corners, -side, axis=0) for side in range(4)]
    top, right, bottom, left = moves = [_moves(color, each) for each in turned]
    # of each side for all its places and those of the sides before and after it
    even = [
        _moved_evenness(color, turned[side], moves[side], moves[side - 1], moves[(side + 1) % 4]) for side in range(4)
    ]
    first, second, third, fourth = np.indices([len(each) for each in moves]).reshape(4, -1)
    sides = np.stack(
        [
            even[0][first, fourth, second],
            even[1][second, first, third],
            even[2][third, second, fourth],
            even[3][fourth, third, first],
        ]
    )
    score = sides.min(axis=0) + _OF_MEAN * sides.mean(axis=0)
    x0, x1, y0, y1 = left[fourth], 1 - right[second], top[first], 1 - bottom[third]
    score[(x1 - x0 < _LEAST_DEPTH) | (y1 - y0 < _LEAST_DEPTH)] = 0
    best = np.argsort(-score, kind="stable")[:most]
    best = best[score[best] > 0]
    x, y = np.stack([x0, x1, x1, x0], axis=1), np.stack([y0, y0, y1, y1], axis=1)
    return _place(corners, x[best], y[best])


def _moves(color: NDArray[np.float32], corners: Array) -> Array:
    """Where the first side may lie, in parts of the depth towards the opposite one: 0 and the edges parallel to it."""
    depth = 0.5 * float(np.linalg.norm(corners[3] - corners[0]) + np.linalg.norm(corners[2] - corners[1]))
    place = np.linspace(-_OUTWARD, _INWARD, max(int((_INWARD + _OUTWARD) * depth), 2))
    start, end = _place(corners, np.zeros(len(place)), place), _place(corners, np.ones(len(place)), place)
    even = evenness(color, start, end)
    middle = 0.5 * (start + end)
    even[((middle < BESIDE) | (middle > np.array(color.shape[1::-1]) - BESIDE)).any(axis=1)] = 0
    is_edge = (even == ndimage.maximum_filter1d(even, 2 * _APART + 1)) & (even > _LEAST_EVEN)
    edges = np.flatnonzero(is_edge & (np.abs(place) * depth > _APART))
    evenest = edges[np.argsort(-even[edges], kind="stable")[:_EVENEST]]
    nearest = edges[place[edges] < 0][-_NEAREST:]
    return np.concatenate([[0.0], place[np.union1d(evenest, nearest)]])


def _moved_evenness(color: NDArray[np.float32], corners: Array, moves: Array, before: Array, after: Array) -> Array:
    """Evenness (K, B, A) of the first side at each of its places between those of the sides beside it."""
    place, first, last = np.meshgrid(moves, before, 1 - after, indexing="ij")
    return evenness(color, _place(corners, first, place), _place(corners, last, place))


def evenness(color: NDArray[np.float32], start: Array, end: Array) -> Array:
    """How far the step of colour across lines (..., 2) points the same way all along them, 0 to 1.5.

    Print has higher steps than the edge of the paper, but with gaps, so the smallest steps count as well as the mean.
    """
    across = outwards(start, end)[..., None, :]
    at = start[..., None, :] + ALONG[:, None] * (end - start)[..., None, :]
    outside, inside = (sample_bilinear(color, at + side * BESIDE * across) for side in (1, -1))
    step = even_steps((outside - inside).astype(np.float64), CLEAR_STEP)
    mean = step.mean(axis=-2)
    length = np.linalg.norm(mean, axis=-1)
    same_way = (step * (mean / np.maximum(length, 1e-9)[..., None])[..., None, :]).sum(axis=-1)
    return np.asarray(0.5 * length + np.maximum(np.quantile(same_way, _COVERED, axis=-1), 0))


def _place(corners: Array, x: Array, y: Array) -> Array:
    """Positions (..., 2) within a quadrilateral: its first corner is (0, 0), the second (1, 0), the third (1, 1)."""
    shares = np.stack([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y], axis=-1)
    return shares @ corners
