"""Writes the paper's edge and the creases in the reference photo: to look at, to edit, and to pass to the next run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.camera import Camera
from ...core.numeric.control_points import control_points
from ...core.numeric.image import Image, shrink
from ...core.numeric.line_drawing import draw_line
from ...core.numeric.simple_polygon import is_simple, without_loops
from ...core.sheet import Sheet
from ..files.atomic import replacing
from ..files.image_files import to_eight_bits, write_jpeg

_DIGITS = 2  # of a pixel
# Largest distance in pixels of the written outline from the edge, which is known to a few tenths. Of the 2123 corners
# found in a letter folded twice it leaves 28 (twice as much: 19), few enough to edit by hand.
_TOLERANCE = 0.25
_LONG_SIDE = 1600  # of the picture, pixels, about
_SCREEN_DPI = 96
# Shares of the picture's long side. The dark rim makes a line visible on paper and on a table of any colour.
_WIDTH, _RIM = 0.0014, 0.0012
_OUTLINE_COLOR, _CREASE_COLOR, _RIM_COLOR = (255.0, 90.0, 0.0), (0.0, 220.0, 255.0), (20.0, 20.0, 20.0)


def crease_ends(sheet: Sheet, reference: Camera) -> Array:
    """The ends (K, 2, 2) of the sheet's creases in the reference photo, pixels as stored."""
    ends = np.array([sheet.vertices[ridge[[0, -1]]] for ridge in sheet.ridges]).reshape(-1, 3)
    return reference.project(ends).reshape(-1, 2, 2)


def write_outline(path: Path, reference: str, polygon: Array) -> None:
    """Write the paper's edge (K, 2) for ``--outline``, with as few corners as it needs.

    Raises
    ------
    StepFailed
        If it could not be written (as for all functions here).
    """
    _write(path, reference, "outline", _corners(polygon))


def _corners(polygon: Array) -> Array:
    """The few corners that define the edge, rounded for writing; they must not make the outline touch itself."""
    corners = polygon[control_points(polygon, _TOLERANCE)].round(_DIGITS)
    while len(corners) > 2 and not is_simple(corners):
        corners = without_loops(corners).round(_DIGITS)
    return corners


def write_creases(path: Path, reference: str, ends: Array) -> None:
    """Write the ends (K, 2, 2) of the creases for ``--creases``."""
    _write(path, reference, "creases", ends.reshape(-1, 4))


def _write(path: Path, reference: str, what: str, rows: Array) -> None:
    lines = [json.dumps([round(float(value), _DIGITS) for value in row]) for row in rows]
    listed = "[" + ",".join(f"\n  {line}" for line in lines) + "\n]" if lines else "[]"
    with replacing(path) as unfinished:
        name = json.dumps(reference, ensure_ascii=False)
        unfinished.write_text(f'{{"reference": {name}, "{what}": {listed}}}\n', encoding="utf-8")


def write_outline_picture(path: Path, photo: Image, polygon: Array, creases: Array, profile: bytes | None) -> None:
    """Write the reference photo as stored, reduced, with the paper's edge in orange and the creases in blue.

    Parameters
    ----------
    path : Path
    photo : (h, w, 3) array
    polygon : (K, 2) array
    creases : (N, 2, 2) array
        Both in pixels of the photo.
    profile : bytes or None
        Colour profile of the photo.
    """
    factor = max(1, round(max(photo.shape[:2]) / _LONG_SIDE))
    picture = shrink(to_eight_bits(photo), factor)
    width, rim = (max(1.0, share * max(picture.shape[:2])) for share in (_WIDTH, _RIM))
    edge: list[tuple[Array, Any]] = [(np.concatenate([polygon, polygon[:1]]), _OUTLINE_COLOR)]
    lines = edge + [(ends, _CREASE_COLOR) for ends in creases]
    for line, _ in lines:
        draw_line(picture, line / factor, _RIM_COLOR, width + 2 * rim)
    for line, color in lines:
        draw_line(picture, line / factor, color, width)
    write_jpeg(path, np.rint(picture).astype(np.uint8), _SCREEN_DPI, profile)
