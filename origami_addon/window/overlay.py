"""Draws over the 3D view: the creases, the chosen one with its number, and the sparse points coloured by their error.

The coordinates are read from the scene after each change and cached between redraws.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

from ..scene.chosen import active_document
from ..scene.color_scale import WORST_PIXELS, colors
from ..scene.document import Document
from ..scene.edits import changes
from ..scene.mesh_values import in_world, read_values
from ..scene.modes import in_edit_mode
from ..scene.page_object import places_on_page
from ..scene.points_mesh import POINT_ERROR
from ..scene.ridge_group import Creases, fold_angles
from ..scene.roles import PAGE, POINTS, SHEET
from ..scene.shape_keys import shown_positions, unfolded_share
from ..scene.sheet_mesh import read_flat
from . import crease_list
from .pixel_shapes import draw_text

_POINT_SIZE = 4.0  # pixels
_CREASE_WIDTH, _CHOSEN_WIDTH = 4.0, 9.0  # pixels
_NUMBER_SIZE, _NUMBER_ABOVE = 18.0, 8.0  # pixels of an unscaled interface
_MOUNTAIN, _VALLEY, _UNKNOWN = (1.0, 0.2, 0.15, 1.0), (0.2, 0.45, 1.0, 1.0), (1.0, 0.75, 0.1, 1.0)
_CHOSEN = (0.1, 0.85, 0.3, 1.0)  # paper is white

_NO_POINTS = np.zeros((0, 3), np.float32), np.zeros((0, 4), np.float32)


@dataclass
class _Drawn:
    """Coordinates and colours of one document, and the state of the scene from which they were read."""

    key: tuple[Any, ...] = ()
    creases: list[tuple[np.ndarray, tuple[float, ...]]] = field(default_factory=list)
    numbered: dict[int, list[np.ndarray]] = field(default_factory=dict)  # on the sheet, and on the flat page
    points: np.ndarray = field(default_factory=lambda: _NO_POINTS[0])
    colors: np.ndarray = field(default_factory=lambda: _NO_POINTS[1])


_drawn = _Drawn()
_handlers: list[Any] = []


def _draw() -> None:
    shown = bpy.context.scene.origami
    document = active_document(bpy.context)
    if document is None or not (shown.show_creases or shown.show_errors or document.collection.origami.crease >= 0):
        return
    import gpu

    _refresh(document)
    gpu.state.blend_set("ALPHA")
    try:
        if shown.show_errors and len(_drawn.points):
            _draw_points()
        _draw_lines([(line, _CHOSEN) for line in _chosen(document)], _CHOSEN_WIDTH)
        if shown.show_creases:
            _draw_lines(_drawn.creases, _CREASE_WIDTH)
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


def _draw_number() -> None:
    """The number of the chosen crease, at the middle of it."""
    document = active_document(bpy.context)
    if document is None or document.collection.origami.crease < 0:
        return
    _refresh(document)
    scale = bpy.context.preferences.system.ui_scale
    for line in _chosen(document):
        middle = Vector(line[len(line) // 2].tolist())
        place = location_3d_to_region_2d(bpy.context.region, bpy.context.region_data, middle)
        if place is not None:  # not behind the eye
            text = str(document.collection.origami.crease + 1)
            draw_text(place + Vector((0, scale * _NUMBER_ABOVE)), text, scale * _NUMBER_SIZE, _CHOSEN)


def _chosen(document: Document) -> list[np.ndarray]:
    return _drawn.numbered.get(document.collection.origami.crease, [])


def _draw_lines(lines: Sequence[tuple[np.ndarray, tuple[float, ...]]], width: float) -> None:
    import gpu
    from gpu_extras.batch import batch_for_shader

    gpu.state.depth_test_set("NONE")
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width)
    for line, color in lines:
        shader.uniform_float("color", color)
        batch_for_shader(shader, "LINE_STRIP", {"pos": line}).draw(shader)


def _refresh(document: Document) -> None:
    sheet, points, page = document.object(SHEET), document.object(POINTS), document.object(PAGE)
    figures = document.collection.origami.surface.figures
    objects = [each and each.session_uid for each in (sheet, points, page)]
    key = (document.name, changes(SHEET, POINTS, PAGE), figures, *objects, sheet and unfolded_share(sheet))
    if key == _drawn.key:
        return
    _drawn.key = key
    _drawn.creases, _drawn.numbered = [], {}
    if sheet is not None and (creases := crease_list.creases_of(document, sheet)) is not None:
        _read_lines(creases, sheet, page)
    _drawn.points, _drawn.colors = _NO_POINTS if points is None else _points(points)


def _read_lines(creases: Creases, sheet: bpy.types.Object, page: bpy.types.Object | None) -> None:
    """The creases, each in the colour of its fold, which is not known yet for painted ones."""
    positions, angles = _drawable(in_world(sheet, shown_positions(sheet))), fold_angles(sheet)
    known = [(positions[ridge], _fold_color(angles.get(number))) for number, ridge in creases.known.items()]
    _drawn.creases = [*known, *((positions[ridge], _UNKNOWN) for ridge in creases.painted)]
    on_page = None if page is None or (flat := read_flat(sheet)) is None else places_on_page(page, flat)
    for number, ridge in creases.known.items():
        _drawn.numbered[number] = [positions[ridge]]
        if on_page is not None and page is not None:
            _drawn.numbered[number].append(_drawable(in_world(page, on_page[ridge].astype(float))))


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
    if not bpy.app.background:
        for draw, stage in ((_draw, "POST_VIEW"), (_draw_number, "POST_PIXEL")):
            _handlers.append(bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", stage))


def unregister() -> None:
    """Stop drawing."""
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
    _drawn.key = ()
    crease_list.forget()
