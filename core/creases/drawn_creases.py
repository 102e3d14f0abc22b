"""Fits creases drawn by hand to the paper and to each other."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from ..arrays import Array
from .crease_ends import CREASE_REACH, cut_to_outline, extend_to_outline, lines_meet

# Values without a figure are choices; no measurement of them is recorded.
# Ends within this distance of each other or of another crease, in page lengths, are meant to meet.
_MEETING = 0.015
# An end within this distance of the paper's edge, in page lengths, is on it.
_ON_EDGE = 1e-9
# Creases that end at the paper's edge continue this far beyond it, in grid steps, like the grid.
_BEYOND = 5.0
# Sine of the angle below which rounding decides where two creases meet.
_PARALLEL = 1e-9


def crease_lines(drawn: Array, outline: Array, step: float) -> Array:
    """The lines along which the paper is folded.

    Creases are cut where they leave the paper, joined if they end just before or behind each other, and lengthened if
    they end just before the paper's edge. Creases that end at the edge continue beyond it.

    Parameters
    ----------
    drawn : (K, 2, 2) array
        Ends of the creases, plane coordinates in page lengths.
    outline : (L, 2) array
        The paper's edge, in the same plane.
    step : float
        Grid step.

    Returns
    -------
    (M, 2, 2) array
        They only meet at their ends, which are then identical bit for bit.
    """
    pieces = [piece for ends in drawn for piece in cut_to_outline(ends, outline)]
    if not pieces:
        return np.zeros((0, 2, 2))
    creases, joined = _joined(np.array(pieces))
    for number, ends in enumerate(creases):
        longer = extend_to_outline(ends, outline, CREASE_REACH * step)
        creases[number] = np.where(joined[number, :, None], ends, longer)
    at_edge = _distance_to_outline(creases.reshape(-1, 2), outline).reshape(-1, 2) < _ON_EDGE
    span = creases[:, 1] - creases[:, 0]
    outwards = np.stack([-span, span], axis=1) / np.linalg.norm(span, axis=1)[:, None, None]
    return _split_where_they_meet(creases + np.where(at_edge[..., None], _BEYOND * step * outwards, 0.0))


def _distance_to_outline(points: Array, outline: Array) -> Array:
    span = np.roll(outline, -1, axis=0) - outline
    offset = points[:, None] - outline
    share = (offset * span).sum(2) / np.maximum((span**2).sum(1), 1e-300)
    nearest = outline + np.clip(share, 0, 1)[..., None] * span
    distance: Array = np.linalg.norm(points[:, None] - nearest, axis=2).min(1)
    return distance


def _joined(creases: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Creases (K, 2, 2) with their ends joined as intended, and which of the ends (K, 2) meet another crease."""
    ends = creases.reshape(-1, 2)
    near = np.linalg.norm(ends[:, None] - ends, axis=2) < _MEETING
    _, place = connected_components(sparse.csr_array(near), directed=False)
    joined = np.bincount(place)[place] > 1
    ends = np.stack([np.bincount(place, weights=ends[:, axis]) for axis in (0, 1)], axis=1)[place]
    ends /= np.bincount(place)[place][:, None]
    result = ends.reshape(-1, 2, 2)
    for number in range(place.max() + 1):
        members = np.flatnonzero(place == number)
        for other, (first, last) in enumerate(result):
            foot, inside = _foot(ends[members[0]], first, last)
            if other not in members // 2 and inside and np.linalg.norm(foot - ends[members[0]]) < _MEETING:
                ends[members] = foot
                joined[members] = True
                break
    whole = np.linalg.norm(result[:, 1] - result[:, 0], axis=1) > 0
    return result[whole], joined.reshape(-1, 2)[whole]


def _foot(point: Array, first: Array, last: Array) -> tuple[Array, bool]:
    """Foot of the perpendicular from a point to a line, and whether it lies between its ends."""
    span = last - first
    share = float((point - first) @ span / (span @ span))
    return first + share * span, 0 < share < 1


def _split_where_they_meet(creases: Array) -> Array:
    """Pieces (M, 2, 2) of creases (K, 2, 2) between the places where two or more of them meet."""
    places = [[*ends] for ends in creases]
    for one, other in combinations(range(len(creases)), 2):
        meeting = _meeting(creases[one], creases[other])
        if meeting is None:
            continue
        known = [place for crease in (one, other) for place in places[crease]]
        distance = np.linalg.norm(np.array(known) - meeting, axis=1)
        place = known[int(distance.argmin())] if distance.min() < _MEETING else meeting
        for crease in (one, other):
            if not any((place == here).all() for here in places[crease]):
                places[crease].append(place)
    pieces = []
    for (first, last), stops in zip(creases, places, strict=True):
        onward = np.array(stops) @ (last - first)
        pieces += [[stops[a], stops[b]] for a, b in pairwise(np.argsort(onward))]
    return np.array(pieces)


def _meeting(one: Array, other: Array) -> Array | None:
    """Where two creases cross or one ends on the other; None if they do not."""
    shares = lines_meet(one, other, _PARALLEL)
    if shares is None:
        return None
    for share, ends in zip(shares, (one, other), strict=True):
        slack = _MEETING / float(np.linalg.norm(ends[1] - ends[0]))
        if not -slack <= share <= 1 + slack:
            return None
    meeting: Array = one[0] + shares[0] * (one[1] - one[0])
    return meeting
