"""How long the creases of a sheet are, and how far and to which side the paper is folded along them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .camera import Array
from .sheet import Indices, Sheet
from .triangles import areas

# The paper's slope on either side is told at these distances from the crease, where the surface's smoothness rounds it
# no more, and extended to the crease as a line. Shares of the square root of the sheet's area.
_BESIDE = (0.018, 0.08)
_FEWEST_TRIANGLES = 3


@dataclass(frozen=True)
class CreaseFigures:
    """What was measured of one crease.

    Attributes
    ----------
    length : float
        In the unit of the sheet's vertices.
    fold_angle : float
        Degrees by which the paper deviates from flat, between -180 and 180: positive for a valley, negative for a
        mountain as seen from the printed side. NaN where the sheet has no paper on one side of the crease.
    """

    length: float
    fold_angle: float


def crease_figures(sheet: Sheet) -> tuple[CreaseFigures, ...]:
    """Length and fold angle of each of the sheet's ridges."""
    unit = float(np.sqrt(areas(sheet.vertices, sheet.triangles).sum()))
    return tuple(CreaseFigures(_length(sheet.vertices[run]), _fold_angle(sheet, run, unit)) for run in sheet.ridges)


def _length(line: Array) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def _fold_angle(sheet: Sheet, run: Indices, unit: float) -> float:
    """Angle at the straight line through a run of vertices between the paper on its left and on its right."""
    line = sheet.vertices[run]
    if len(line) < 2:
        return float("nan")
    middle = line.mean(axis=0)
    along = np.linalg.svd(line - middle)[2][0]
    low, high = np.sort((line[[0, -1]] - middle) @ along)
    corners = sheet.vertices[sheet.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    offset = corners.mean(axis=1) - middle
    place = offset @ along
    across = offset - place[:, None] * along
    distance = np.linalg.norm(across, axis=1) / unit
    beside = (place > low) & (place < high) & (distance < _BESIDE[1])
    if not beside.any():
        return float("nan")
    up = normals[beside].sum(axis=0)
    up -= (up @ along) * along
    up /= np.linalg.norm(up)
    to_left = np.cross(up, along)
    slope = np.arctan2(-(normals @ to_left), normals @ up)
    beside &= distance > _BESIDE[0]
    at_crease = []
    for side in (beside & (across @ to_left > 0), beside & (across @ to_left < 0)):
        if side.sum() < _FEWEST_TRIANGLES:
            return float("nan")
        weight = np.sqrt(np.linalg.norm(normals[side], axis=1))
        design = np.column_stack([np.ones(side.sum()), distance[side]])
        at_crease.append(np.linalg.lstsq(design * weight[:, None], slope[side] * weight, rcond=None)[0][0])
    return float(np.degrees(at_crease[0] - at_crease[1]))
