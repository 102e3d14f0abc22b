"""The crease pattern of a flattened sheet: the paper's edge and its straight creases, and how far each is folded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..numeric.polygon import signed_area, simplified
from ..numeric.triangles import signed_areas
from ..sheet import FlatMap, Sheet
from .crease_graph import BORDER, JOIN, CreasePattern, arrange
from .creases import crease_figures
from .planar_graph import cross

# Values without a figure are choices; no measurement of them is recorded.
# A side of the paper that strays less than this share of the page's longer side is straight.
_STRAIGHT = 0.01
# Paper that covers this much of the page's rectangle counts as that rectangle; the rest may be a badly found edge.
_WHOLE = 0.95
# Degrees; a crease that is folded less counts as open.
_OPEN = 2.0


def crease_pattern(sheet: Sheet, flat: FlatMap) -> CreasePattern:
    """The crease pattern of a sheet, its lines numbered as the sheet's ridges."""
    creases = [straight_line(flat.uv[ridge]) if len(ridge) > 1 else np.zeros((2, 2)) for ridge in sheet.ridges]
    return arrange(paper_outline(sheet, flat), creases)


def fold_angles(pattern: CreasePattern, sheet: Sheet, flat: FlatMap) -> Array:
    """The fold angle of the sheet along each edge of its crease pattern.

    Returns
    -------
    (E,) array
        Degrees from -180 to 180, positive for a valley as seen from the printed side. 0 for the paper's edge, joins and
        open creases, NaN if it could not be measured.
    """
    whole = np.array([figures.fold_angle for figures in crease_figures(sheet)])
    on_crease = np.flatnonzero(pattern.line >= 0)
    runs = []
    for edge in on_crease:
        ridge = sheet.ridges[pattern.line[edge]]
        start, end = pattern.vertices[pattern.edges[edge]]
        share = (flat.uv[ridge] - start) @ (end - start) / ((end - start) @ (end - start))
        runs.append(ridge[(share > 0) & (share < 1)])
    pieces = np.array([figures.fold_angle for figures in crease_figures(replace(sheet, ridges=tuple(runs)))])
    angles = np.zeros(len(pattern.edges))
    angles[on_crease] = np.where(np.isnan(pieces), whole[pattern.line[on_crease]], pieces)
    return np.where(np.abs(angles) < _OPEN, 0.0, angles)


def assignments(pattern: CreasePattern, angles: Array) -> list[str]:
    """The kind of each edge, as letters of the FOLD format.

    Returns
    -------
    list of str
        ``B`` the paper's edge, ``J`` a join, ``M`` a mountain, ``V`` a valley, ``F`` an open crease, ``U`` a crease
        whose angle could not be measured.
    """
    of_line = {BORDER: "B", JOIN: "J"}
    of_angle = np.select([angles < 0, angles > 0, angles == 0], ["M", "V", "F"], "U")
    return [of_line.get(line, letter) for line, letter in zip(pattern.line.tolist(), of_angle.tolist(), strict=True)]


def in_space(sheet: Sheet, flat: FlatMap, points: Array) -> Array:
    """Points (N, 2) of the page on the sheet, (N, 3) in its frame; also a little beyond its edge."""
    triangles = sheet.triangles[signed_areas(flat.uv, sheet.triangles) != 0]
    corners = flat.uv[triangles]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    offset = points[:, None] - corners[:, 0]
    one, other = cross(offset, second) / cross(first, second), cross(first, offset) / cross(first, second)
    weights = np.stack([1 - one - other, one, other], axis=2)
    nearest = weights.min(axis=2).argmax(axis=1)
    weights = weights[np.arange(len(points)), nearest]
    return np.asarray((weights[..., None] * sheet.vertices[triangles[nearest]]).sum(axis=1))


def paper_outline(sheet: Sheet, flat: FlatMap) -> Array:
    """Corners (K, 2) of the paper's edge on the page: the page's own if the paper fills it."""
    edge = flat.uv[sheet.boundary]
    if abs(signed_area(edge)) > _WHOLE * flat.width * flat.height:
        return np.array([[0.0, 0.0], [flat.width, 0.0], [flat.width, flat.height], [0.0, flat.height]])
    return simplified(edge, _STRAIGHT * max(flat.width, flat.height))


def straight_line(points: Array) -> Array:
    """Both ends (2, 2) of the line fitted to points (K, 2), which follow it in order."""
    middle = points.mean(axis=0)
    direction = np.linalg.svd(points - middle)[2][0]
    return middle + ((points[[0, -1]] - middle) @ direction)[:, None] * direction
