"""Ends of straight creases: at the paper's edge, if they come near it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ..arrays import Array
from ..numeric.polygon import inside_polygon

# Values without a figure are choices; no measurement of them is recorded.
# Creases within this distance of the paper's edge end at it, in grid steps.
CREASE_REACH = 4.0
# A detected crease meets another that lies within this distance further on its own line, in grid steps. Where creases
# meet, the first surface is rounded, so they seem to end 1.5 to 3 steps short. With that gap, the page of a rendered
# sheet with crossing folds is .043 % of its height off; without it, .011 %.
CROSSING_REACH = 5.0
# Pieces of a crease, and gaps in it, that are shorter than this share of the page length come from a ragged outline.
SHORTEST_CREASE = 0.01
# Sine of the angle below which two creases are parallel, 15 degrees: where they would meet is no matter of a few steps.
_PARALLEL = 0.26


def extend_to_outline(ends: Array, outline: Array, reach: float) -> Array:
    """Lengthen a crease to the paper's edge if one of its ends is nearer to it than ``reach``.

    The Hessian is only known where all neighbours are, so every detected crease seems to end short of the edge; drawn
    ones do, too.

    Parameters
    ----------
    ends : (2, 2) array
        Plane coordinates.
    outline : (K, 2) array
        The paper's edge, in the same plane.
    reach : float
        Page lengths.

    Returns
    -------
    (2, 2) array
    """
    first, last = ends
    direction = (last - first) / np.linalg.norm(last - first)
    return np.array([_hit(first, -direction, outline, reach), _hit(last, direction, outline, reach)])


def extend_to_each_other(lines: Sequence[Array], reach: float) -> list[Array]:
    """Lengthen creases to others that they would meet less than ``reach`` further on.

    Parameters
    ----------
    lines : sequence of (2, 2) arrays
        Plane coordinates.
    reach : float
        Page lengths.

    Returns
    -------
    list of (2, 2) arrays

    Examples
    --------
    >>> across, down = np.array([[0.0, 0.5], [1.0, 0.5]]), np.array([[0.4, 0.0], [0.4, 0.47]])
    >>> extend_to_each_other([across, down], reach=0.05)[1]
    array([[0.4, 0. ],
           [0.4, 0.5]])
    """
    longer = []
    for number, ends in enumerate(lines):
        slack, span = _slack(ends, reach), ends[1] - ends[0]
        meetings = [
            shares[0]
            for other in (*lines[:number], *lines[number + 1 :])
            if (shares := lines_meet(ends, other, _PARALLEL)) is not None
            and -_slack(other, reach) <= shares[1] <= 1 + _slack(other, reach)
        ]
        start = max((share for share in meetings if -slack <= share < 0), default=0.0)
        stop = min((share for share in meetings if 1 < share <= 1 + slack), default=1.0)
        longer.append(np.array([ends[0] + start * span, ends[1] + (stop - 1) * span]))
    return longer


def _slack(ends: Array, reach: float) -> float:
    """A length in parts of a crease's own."""
    return reach / float(np.linalg.norm(ends[1] - ends[0]))


def lines_meet(one: Array, other: Array, parallel: float) -> tuple[float, float] | None:
    """Where the lines of two creases (2, 2) meet, in parts of each from its first end.

    None if the sine of the angle between them is below ``parallel``.
    """
    first, second = one[1] - one[0], other[1] - other[0]
    determinant = float(first[0] * second[1] - first[1] * second[0])
    if abs(determinant) < parallel * float(np.linalg.norm(first) * np.linalg.norm(second)):
        return None
    offset = other[0] - one[0]
    on_first = float(offset[0] * second[1] - offset[1] * second[0]) / determinant
    return on_first, float(offset[0] * first[1] - offset[1] * first[0]) / determinant


def _hit(origin: Array, direction: Array, outline: Array, reach: float) -> Array:
    """First crossing of a ray with the outline within reach, or the origin."""
    distance = _crossings(origin, direction, outline)
    hits = distance[(distance > 0) & (distance < reach)]
    return origin + direction * hits.min() if len(hits) else origin


def _crossings(origin: Array, direction: Array, outline: Array) -> Array:
    """Where a line crosses a closed polygon, as multiples of ``direction`` from the origin."""
    start, side = outline, np.roll(outline, -1, axis=0) - outline
    determinant = direction[0] * side[:, 1] - direction[1] * side[:, 0]
    safe = np.where(np.abs(determinant) < 1e-15, np.inf, determinant)
    offset = start - origin
    distance = (offset[:, 0] * side[:, 1] - offset[:, 1] * side[:, 0]) / safe
    along = (offset[:, 0] * direction[1] - offset[:, 1] * direction[0]) / safe
    crossings: Array = distance[(along >= 0) & (along <= 1) & np.isfinite(safe)]
    return crossings


def off_the_paper(creases: Iterable[Array], outline: Array) -> list[int]:
    """Which of some straight creases (2, 2) have no part inside the paper's edge (K, 2), in the same plane."""
    return [number for number, ends in enumerate(creases) if not cut_to_outline(ends, outline)]


def cut_to_outline(ends: Array, outline: Array) -> list[Array]:
    """The pieces (2, 2) of a straight crease (2, 2) that lie on the paper, in order; in page lengths."""
    first, span = ends[0], ends[1] - ends[0]
    crossings = _crossings(first, span, outline)
    stops = np.unique([0.0, 1.0, *crossings[(crossings > 0) & (crossings < 1)]])
    inside = inside_polygon(first + ((stops[1:] + stops[:-1]) / 2)[:, None] * span, outline)
    shortest = SHORTEST_CREASE / float(np.linalg.norm(span))
    pieces: list[list[float]] = []
    for start, stop in zip(stops[:-1][inside], stops[1:][inside], strict=True):
        if pieces and start - pieces[-1][1] < shortest:
            pieces[-1][1] = stop
        else:
            pieces.append([start, stop])
    return [first + np.array(piece)[:, None] * span for piece in pieces if piece[1] - piece[0] >= shortest]
