"""Controls a polygon of many points by few points that a user can move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array


def control_points(polygon: Array, tolerance: float) -> NDArray[np.int64]:
    """Indices of the points that define a closed polygon to within ``tolerance`` (Douglas and Peucker 1973).

    Parameters
    ----------
    polygon : (K, 2) array
        The first point is not repeated.
    tolerance : float
        In the polygon's unit.

    Returns
    -------
    (C,) int array
        Ascending; at least three if three points of the polygon span an area.
    """
    first = int(np.argmax(np.linalg.norm(polygon - polygon.mean(0), axis=1)))
    turned = np.roll(polygon, -first, axis=0)
    closed = np.vstack([turned, turned[:1]])
    opposite = int(np.argmax(np.linalg.norm(turned - turned[0], axis=1)))
    kept = {0, opposite}
    # At least one more on either side: without it a slim polygon would be a line.
    spans = [(0, opposite, 0.0), (opposite, len(polygon), tolerance)]
    while spans:
        start, end, limit = spans.pop()
        if end - start < 2:
            continue
        away = _distance_from_chord(closed[start : end + 1])
        worst = int(np.argmax(away))
        if away[worst] > limit:
            middle = start + worst
            kept.add(middle)
            spans += [(start, middle, tolerance), (middle, end, tolerance)]
    return np.sort((np.array(sorted(kept)) + first) % len(polygon))


def with_moved_controls(polygon: Array, controls: NDArray[np.int64], moved: Array, same: float) -> Array:
    """The polygon after its control points were moved or deleted, or others were added.

    Between two unmoved neighbours it is unchanged; everywhere else it is straight.

    Parameters
    ----------
    polygon : (K, 2) array
    controls : (C,) int array
        As from `control_points`.
    moved : (M, 2) array
        The control points now, in their order.
    same : float
        Points no farther apart than this count as unmoved.

    Returns
    -------
    (L, 2) array
    """
    apart = np.linalg.norm(moved[:, None] - polygon[controls][None], axis=2)
    nearest = np.argmin(apart, axis=1)
    was = np.where(apart[np.arange(len(moved)), nearest] <= same, nearest, -1)
    pieces = []
    for number, point in enumerate(moved):
        here, there = was[number], was[(number + 1) % len(moved)]
        if here >= 0 and there == (here + 1) % len(controls):
            start, end = int(controls[here]), int(controls[there])
            span = np.arange(start, end if end > start else end + len(polygon)) % len(polygon)
            pieces.append(polygon[span])
        else:
            pieces.append((polygon[controls[here]] if here >= 0 else point)[None])
    return np.vstack(pieces)


def _distance_from_chord(run: Array) -> Array:
    """Distance of each point of a run (K, 2) from the segment between its ends."""
    span = run[-1] - run[0]
    offset = run - run[0]
    length = max(float(span @ span), 1e-300)
    along = np.clip(offset @ span / length, 0, 1)
    return np.linalg.norm(offset - along[:, None] * span, axis=1)
