"""Draws over the 3D view: the creases, and the sparse points coloured by their error.

The coordinates are read from the scene after each change and cached between redraws.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ..scene.chosen import active_document
from ..scene.color_scale import WORST_PIXELS, colors
from ..scene.document import Document
from ..scene.edits import changes
from ..scene.mesh_values import in_world, read_values
from ..scene.modes import in_edit_mode
from ..scene.points_mesh import POINT_ERROR
from ..scene.ridge_group import fold_angles
from ..scene.shape_keys import shown_positions, unfolded_share
from ..scene.show import POINTS, SHEET
from . import crease_list

_POINT_SIZE = 4.0  # pixels
_CREASE_WIDTH = 4.0  # pixels
_MOUNTAIN, _VALLEY, _UNKNOWN = (1.0, 0.2, 0.15, 1.0), (0.2, 0.45, 1.0, 1.0), (1.0, 0.75, 0.1, 1.0)

_NO_POINTS = np.zeros((0, 3), np.float32), np.zeros((0, 4), np.float32)


@dataclass
class _Drawn:
    """Coordinates and colours of one document, and the state of the scene from which they were read."""

    key: tuple[Any, ...] = ()
    creases: list[tuple[np.ndarray, tuple[float, ...]]] = field(default_factory=list)
    points: np.ndarray = field(default_factory=lambda: _NO_POINTS[0])
    colors: np.ndarray = field(default_factory=lambda: _NO_POINTS[1])


_drawn = _Drawn()
_handler: Any = None


def _draw() -> None:
    shown = bpy.context.scene.origami
    document = active_document(bpy.context)
    if document is None or not (shown.show_creases or shown.show_errors):
        return
    import gpu

    _refresh(document)
    gpu.state.blend_set("ALPHA")
    try:
        if shown.show_errors and len(_drawn.points):
            _draw_points()
        if shown.show_creases:
            _draw_creases()
    finally:
        gpu.state.point_size_set(1.0)
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")


def _draw_points() -> None:
    import gpu
    from gpu_extras.batch import batch_for_shader

    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.point_size_set(_POINT_SIZE)
    shader = gpu.shader.from_builtin("FLAT_COLOR")
    batch_for_shader(shader, "POINTS", {"pos": _drawn.points, "color": _drawn.colors}).draw(shader)


def _draw_creases() -> None:
    import gpu
    from gpu_extras.batch import batch_for_shader

    gpu.state.depth_test_set("NONE")
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", _CREASE_WIDTH)
    for line, color in _drawn.creases:
        shader.uniform_float("color", color)
        batch_for_shader(shader, "LINE_STRIP", {"pos": line}).draw(shader)


def _refresh(document: Document) -> None:
    sheet, points = document.object(SHEET), document.object(POINTS)
    figures = document.collection.origami.surface.figures
    objects = sheet and sheet.session_uid, points and points.session_uid
    key = (document.name, changes(SHEET, POINTS), figures, *objects, sheet and unfolded_share(sheet))
    if key == _drawn.key:
        return
    _drawn.key = key
    _drawn.creases = [] if sheet is None else _lines(document, sheet)
    _drawn.points, _drawn.colors = _NO_POINTS if points is None else _points(points)


def _lines(document: Document, sheet: bpy.types.Object) -> list[tuple[np.ndarray, tuple[float, ...]]]:
    """The creases, each in the colour of its fold, which is not known yet for painted ones."""
    creases = crease_list.creases_of(document, sheet)
    if creases is None:
        return []
    positions, angles = _drawable(in_world(sheet, shown_positions(sheet))), fold_angles(sheet)
    known = [(positions[ridge], _fold_color(angles.get(number))) for number, ridge in creases.known.items()]
    return [*known, *((positions[ridge], _UNKNOWN) for ridge in creases.painted)]


def _points(shown: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """The sparse points and their colours; none if their errors cannot be read, as in Edit Mode, or are deleted."""
    error = shown.data.attributes.get(POINT_ERROR) if shown.type == "MESH" else None
    if in_edit_mode(shown) or error is None:
        return _NO_POINTS
    positions = _drawable(in_world(shown, read_values(shown.data.vertices, "co", 3, np.float32)))
    return positions, colors(read_values(error.data, "value", 1, np.float32), WORST_PIXELS)


def _fold_color(angle: float | None) -> tuple[float, ...]:
    return _UNKNOWN if angle is None else _VALLEY if angle > 0 else _MOUNTAIN


def _drawable(positions: np.ndarray) -> np.ndarray:
    """Coordinates as the graphics card takes them."""
    return positions.astype(np.float32)


def register() -> None:
    """Start drawing, if there is a window."""
    global _handler
    if not bpy.app.background:
        _handler = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister() -> None:
    """Stop drawing."""
    global _handler
    if _handler is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handler, "WINDOW")
        _handler = None
    _drawn.key = ()
    crease_list.forget()
