"""The layout of islands in UV space: turned to the axes, upright, side by side."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..flat.distortion import fit_affine
from ..numeric.polygon import perimeter, resample
from ..numeric.triangles import signed_areas
from ..sheet import Sheet

# Values without a figure are choices; no measurement of them is recorded.
# The outline is divided into this many pieces, which bridges the raggedness of a mesh's edge.
_PIECES = 60
# Pieces within this angle are on one straight side or on one perpendicular to it.
_STRAIGHT = np.radians(3.0)
# Shares of the outline below this are not a straight side: on a circle every direction has 7 %.
_LEAST_STRAIGHT = 0.2
# A surface that rises less along the z axis counts as lying flat; its y axis then points up.
_LEAST_RISE = 0.3
# Row widths to try, relative to the side of a square of the total area.
_ROW_WIDTHS = np.linspace(1, 2, 11)


def turn_to_axes(sheet: Sheet, flat: Array) -> Array:
    """Turn a flat map to align its straight sides, or otherwise its longer extent, with the axes.

    Of the four orientations, the one with the z axis of space up is chosen, or with the y axis if the sheet lies flat.

    Parameters
    ----------
    sheet : Sheet
        With an outer boundary.
    flat : (V, 2) array
        u right, v up.

    Returns
    -------
    (V, 2) array
    """
    turned = flat @ _rotation(-_side_angle(sheet, flat)).T
    slopes = fit_affine(turned, sheet.vertices)[:, :2]
    up = slopes[2] if np.hypot(*slopes[2]) > _LEAST_RISE else slopes[1]
    quarters = round((np.pi / 2 - np.arctan2(up[1], up[0])) / (np.pi / 2)) % 4
    for _ in range(quarters):
        turned = np.stack([-turned[:, 1], turned[:, 0]], axis=1)
    return turned


def _rotation(angle: float) -> Array:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def _side_angle(sheet: Sheet, flat: Array) -> float:
    """The angle, up to quarter turns, of the straight sides or otherwise of the longer extent."""
    edge = flat[sheet.boundary]
    points = resample(edge, perimeter(edge) / _PIECES)
    piece = np.roll(points, -1, axis=0) - points
    length, angle = np.linalg.norm(piece, axis=1), np.arctan2(piece[:, 1], piece[:, 0])
    apart = (angle[None, :] - angle[:, None] + np.pi / 4) % (np.pi / 2) - np.pi / 4
    votes = (np.abs(apart) <= _STRAIGHT) * length
    best = int(np.argmax(votes.sum(1)))
    if votes[best].sum() >= _LEAST_STRAIGHT * length.sum():
        order = np.argsort(apart[best])
        half = np.searchsorted(np.cumsum(votes[best][order]), votes[best].sum() / 2)
        return float(angle[best] + apart[best][order[half]])
    area = np.abs(signed_areas(flat, sheet.triangles))
    centre = flat[sheet.triangles].mean(1)
    offset = centre - area @ centre / area.sum()
    longest = np.linalg.eigh((offset * area[:, None]).T @ offset)[1][:, 1]
    return float(np.arctan2(longest[1], longest[0]))


def pack(extents: Array, gap: float) -> Array:
    """Place boxes in rows, the tallest first, in a small area that is about as wide as it is high.

    Parameters
    ----------
    extents : (I, 2) array
        Width and height of each box.
    gap : float
        Free space between any two.

    Returns
    -------
    (I, 2) array
        Lower left corner of each box, none below zero.
    """
    boxes = extents + gap
    ideal = np.sqrt(boxes.prod(1).sum())
    widths = [max(share * ideal, boxes[:, 0].max()) for share in _ROW_WIDTHS]
    return min((_rows(boxes, width) for width in widths), key=lambda corner: (corner + extents).max())


def _rows(boxes: Array, width: float) -> Array:
    """Lower left corners (I, 2) of boxes (I, 2) in rows no wider than ``width``, the tallest first."""
    corner = np.zeros_like(boxes)
    across, bottom, height = 0.0, 0.0, 0.0
    for index in np.argsort(-boxes[:, 1], kind="stable"):
        if across > 0 and across + boxes[index, 0] > width * (1 + 1e-9):
            across, bottom, height = 0.0, bottom + height, 0.0
        corner[index] = across, bottom
        across += boxes[index, 0]
        height = max(height, boxes[index, 1])
    return corner
