"""Four straight sides, each moved to where the step of colour along it is evenest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..numeric.image import sample_bilinear
from .edge_strips import even_steps

# The values below are choices; no measurement of them is recorded.
# Where a side is sampled, in parts of its length; the corners belong to the sides next to it.
ALONG = np.linspace(0.04, 0.96, 48)
# Cells from the side at which the colours of both its sides are taken, and the step of colour that counts half.
BESIDE = 2.0
CLEAR_STEP = 1.5
# Cells that each end of a side may move inwards and outwards, the distance between two tries, and the rounds. Corners
# may move this many times as far, or the sides that were found are those of something else.
_REACH, _STEP = 10.0, 1.0
_ROUNDS = 2
_FARTHEST_CORNER = 4
# Evenness that moving both ends of a side as far as possible costs: of equal lines the nearest is taken.
_MOVING = 0.02
# Sides with a smaller sine of the angle between them have no reliable crossing.
_LEAST_ANGLE = 0.2


def polished_quadrilateral(color: NDArray[np.float32], corners: Array) -> Array:
    """The quadrilateral near a given one whose sides follow edges best.

    Parameters
    ----------
    color : (h, w, 3) float32 array
        The map.
    corners : (4, 2) array
        Map positions, clockwise.

    Returns
    -------
    (4, 2) array
        The given corners if the sides that are found do not meet.
    """
    for _ in range(_ROUNDS):
        lines = [_best_side(color, corners[k], corners[(k + 1) % 4]) for k in range(4)]
        met = [_meeting(lines[k - 1], lines[k]) for k in range(4)]
        if any(corner is None for corner in met):
            return corners
        moved = np.array(met)
        if np.abs(moved - corners).max() > _FARTHEST_CORNER * _REACH:
            return corners
        corners = moved
    return corners


def outwards(start: Array, end: Array) -> Array:
    """Unit vectors (..., 2) across sides from ``start`` to ``end`` (..., 2) of a clockwise polygon, to its outside."""
    along = (end - start) / np.maximum(np.linalg.norm(end - start, axis=-1, keepdims=True), 1e-9)
    return np.stack([along[..., 1], -along[..., 0]], axis=-1)


def _best_side(color: NDArray[np.float32], start: Array, end: Array) -> tuple[Array, Array]:
    """Two points of the line near a side along which the colour's step is evenest."""
    across = outwards(start, end)
    shifts = np.arange(-_REACH - BESIDE, _REACH + BESIDE + 0.5 * _STEP, _STEP)
    at = start + ALONG[:, None, None] * (end - start) + shifts[None, :, None] * across
    profile = sample_bilinear(color, at).astype(np.float64)
    beside = round(BESIDE / _STEP)
    step = even_steps(profile[:, 2 * beside :] - profile[:, : -2 * beside], CLEAR_STEP)
    tries = step.shape[1]
    first, last = (index.ravel() for index in np.indices((tries, tries)))
    column = np.round(first[:, None] * (1 - ALONG) + last[:, None] * ALONG).astype(np.int64)
    even = np.linalg.norm(step[np.arange(len(ALONG)), column].mean(axis=1), axis=1)
    middle = (tries - 1) / 2
    even -= _MOVING * (np.abs(first - middle) + np.abs(last - middle)) / tries
    best = int(even.argmax())
    return tuple(corner + (index[best] - middle) * _STEP * across for corner, index in ((start, first), (end, last)))  # type: ignore[return-value]


def _meeting(first: tuple[Array, Array], second: tuple[Array, Array]) -> Array | None:
    """Where two lines, each through two points, cross; None where they are nearly parallel."""
    (p, q), (r, s) = first, second
    u, v = q - p, s - r
    turn = u[0] * v[1] - u[1] * v[0]
    if abs(turn) < _LEAST_ANGLE * np.linalg.norm(u) * np.linalg.norm(v):
        return None
    gap = r - p
    return np.asarray(p + (gap[0] * v[1] - gap[1] * v[0]) / turn * u)
