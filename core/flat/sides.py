"""The four sides of a page, found on the folded sheet from the turning of its edge within the surface."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..arrays import Array, Indices
from ..numeric.triangles import local_coordinates
from ..sheet import Sheet

# Values without a figure are choices; no measurement of them is recorded.
# The edge's turning is summed over this share of its length, which bridges the rounding of a noisy corner.
_WINDOW = 0.02
# A corner turns at least this much.
_CORNER_TURN = np.radians(55.0)


def corners(sheet: Sheet) -> Indices:
    """Indices in `sheet.boundary` of the paper's corners, in order; a whole page has four.

    A flat page turns by 90 degrees at its corners and nowhere else. The turning of an edge within the surface (its
    geodesic curvature) does not change when the sheet is folded, so the corners can be found before it is flat.
    """
    turn = edge_turning(sheet)
    points = sheet.vertices[sheet.boundary]
    step = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    place = np.cumsum(step) - step
    length = step.sum()
    apart = (place[:, None] - place[None, :] + length / 2) % length - length / 2
    window = np.maximum(1 - np.abs(apart) / (_WINDOW * length), 0)
    turned = (np.abs(apart) < _WINDOW * length / 2) @ turn
    centred = window @ turn
    found: list[int] = []
    for index in np.argsort(-centred):
        if turned[index] < _CORNER_TURN or len(found) == 4:
            continue
        if all(abs(apart[index, other]) > 2 * _WINDOW * length for other in found):
            found.append(int(index))
    return np.sort(np.array(found, dtype=np.int64))


def edge_turning(sheet: Sheet) -> Array:
    """Turning angle of the edge within the surface at each vertex of `sheet.boundary`: pi minus the inner angle."""
    local = local_coordinates(sheet.vertices, sheet.triangles)
    one, other = np.roll(local, -1, axis=1) - local, np.roll(local, 1, axis=1) - local
    cosine = (one * other).sum(2) / np.linalg.norm(one, axis=2) / np.linalg.norm(other, axis=2)
    angle = np.arccos(np.clip(cosine, -1, 1))
    total = np.bincount(sheet.triangles.ravel(), weights=angle.ravel(), minlength=len(sheet.vertices))
    return np.pi - total[sheet.boundary]


def sides(sheet: Sheet) -> list[Indices]:
    """Vertices along each side from corner to corner; none if the page does not show four corners."""
    place = corners(sheet)
    if len(place) != 4:
        return []
    closed = np.concatenate([sheet.boundary, sheet.boundary])
    ends = np.append(place, place[0] + len(sheet.boundary))
    return [closed[start : stop + 1] for start, stop in pairwise(ends)]
