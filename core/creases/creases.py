"""Measures the creases of a sheet: their lengths, and how far and to which side the paper is folded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from scipy.spatial import cKDTree

from ..arrays import Array
from ..numeric.triangles import areas
from ..sheet import Sheet

# The paper's slope on either side is measured at these distances from the crease, beyond the rounding by the surface's
# smoothness, and extended to the crease as a line. Shares of the square root of the sheet's area.
_BESIDE = (0.018, 0.08)
# With fewer triangles on one side of a crease, its fold angle is unknown. A choice.
_FEWEST_TRIANGLES = 8
# Degrees of the polynomials along a crease: of its course, the normal of the paper, and its slope about the crease.
_COURSE, _NORMAL, _SLOPE = 3, 2, 3


@dataclass(frozen=True)
class CreaseFigures:
    """The measurements of one crease.

    Attributes
    ----------
    length : float
        In the unit of the sheet's vertices.
    fold_angle : float
        Degrees by which the paper deviates from flat, between -180 and 180: positive for a valley, negative for a
        mountain as seen from the printed side. NaN if the sheet has no paper on one side of the crease.
    """

    length: float
    fold_angle: float


def crease_figures(sheet: Sheet) -> tuple[CreaseFigures, ...]:
    """Length and fold angle of each of the sheet's ridges."""
    unit = float(np.sqrt(areas(sheet.vertices, sheet.triangles).sum()))
    corners = sheet.vertices[sheet.triangles]
    centres = corners.mean(axis=1)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lines = [sheet.vertices[run] for run in sheet.ridges]
    return tuple(CreaseFigures(_length(line), _fold_angle(line, centres, normals, unit)) for line in lines)


def _length(line: Array) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def _fold_angle(line: Array, centres: Array, normals: Array, unit: float) -> float:
    """Angle at a line between the triangles on its left and on its right, of these centres and doubled area vectors.

    The slope about the crease is modelled as a smooth function of the place along it: half of the fold on either side,
    plus a share of the distance from it on each side that may change along it. Paper may be bent across a line that is
    not a ruling, and then both sides are bent alike.
    """
    if _length(line) == 0:
        return float("nan")
    reach = _BESIDE[1] * unit + float(np.linalg.norm(np.diff(line, axis=0), axis=1).max())
    near = np.isfinite(cKDTree(line).query(centres, distance_upper_bound=reach)[0])
    centres, normals = centres[near], normals[near]
    foot, place = _nearest_on(line, centres)
    offset = centres - foot
    distance = np.linalg.norm(offset, axis=1) / unit
    beside = (np.abs(place) < 1) & (distance > _BESIDE[0]) & (distance < _BESIDE[1])
    if not beside.any():
        return float("nan")
    normals, offset, distance, place = normals[beside], offset[beside], distance[beside], place[beside]
    weight = np.sqrt(np.linalg.norm(normals, axis=1))
    along = _tangent(line, place)
    up = _across(_smooth(normals / (weight**2)[:, None], place, weight), along)
    to_left = np.cross(up, along)
    left = (offset * to_left).sum(axis=1) > 0
    if min(left.sum(), (~left).sum()) < _FEWEST_TRIANGLES:
        return float("nan")
    slope = np.arctan2(-(normals * to_left).sum(axis=1), (normals * up).sum(axis=1))
    bending = [share * distance * side for side in (left, ~left) for share in (np.ones_like(place), place)]
    rows = np.column_stack([np.where(left, 0.5, -0.5), legendre.legvander(place, _SLOPE), *bending])
    solution = np.linalg.lstsq(rows * weight[:, None], slope * weight, rcond=None)[0]
    return float(np.degrees(solution[0]))


def _nearest_on(line: Array, points: Array) -> tuple[Array, Array]:
    """The nearest place on a polyline of short pieces (K, 3) for each point (N, 3), and its position along it.

    The polyline goes from -1 to 1; positions continue beyond its ends.
    """
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    start = np.concatenate([[0.0], np.cumsum(lengths)])
    last = len(lengths) - 1
    nearest = cKDTree(line).query(points)[1]
    foot, place, distance = np.zeros_like(points), np.zeros(len(points)), np.full(len(points), np.inf)
    for piece in (np.clip(nearest - 1, 0, last), np.clip(nearest, 0, last)):
        length = np.maximum(lengths[piece], 1e-300)
        direction = (line[piece + 1] - line[piece]) / length[:, None]
        along = ((points - line[piece]) * direction).sum(axis=1)
        here = line[piece] + np.clip(along, 0, length)[:, None] * direction
        apart = np.linalg.norm(points - here, axis=1)
        nearer = apart < distance
        beyond = np.clip(along, np.where(piece == 0, -np.inf, 0), np.where(piece == last, np.inf, length))
        foot[nearer], distance[nearer], place[nearer] = here[nearer], apart[nearer], (start[piece] + beyond)[nearer]
    return foot, 2 * place / start[-1] - 1


def _tangent(line: Array, place: Array) -> Array:
    """Unit vectors (N, 3) along a run of vertices at places along it."""
    course = legendre.legfit(_nearest_on(line, line)[1], line, min(_COURSE, len(line) - 1))
    tangent: Array = legendre.legval(place, legendre.legder(course)).T
    return tangent / np.linalg.norm(tangent, axis=1)[:, None]


def _smooth(values: Array, place: Array, weight: Array) -> Array:
    """Values (N, 3) as a polynomial of the place."""
    basis = legendre.legvander(place, _NORMAL)
    coefficients = np.linalg.lstsq(basis * weight[:, None], values * weight[:, None], rcond=None)[0]
    smoothed: Array = basis @ coefficients
    return smoothed


def _across(vectors: Array, along: Array) -> Array:
    """The parts of vectors (N, 3) at right angles to unit vectors, with length one."""
    part = vectors - (vectors * along).sum(axis=1)[:, None] * along
    unit: Array = part / np.linalg.norm(part, axis=1)[:, None]
    return unit
