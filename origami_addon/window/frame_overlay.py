"""Draws the handles of a frame that is dragged, its edge, and how far each side is from where the page ends now."""

from __future__ import annotations

from typing import Any

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

from ...core.errors import StepFailed
from ..operators.drag_frame import dragged, handle_places, side_texts
from .pixel_shapes import DARK, draw_line, draw_square, draw_text

_CORNERS, _TOP = 4, 0
_EDGE_WIDTH = 2.0
_HALF, _HALF_AT_MOUSE = 5.0, 7.0  # of a handle's square, pixels of an unscaled interface
_TEXT_SIZE, _TEXT_ABOVE, _TEXT_BELOW = 13.0, 12.0, -32.0
_COLOR, _AT_MOUSE = (1.0, 0.6, 0.1, 1.0), (1.0, 1.0, 1.0, 1.0)
_handler: Any = None


def _draw() -> None:
    shown = dragged()
    if shown is None:
        return
    frame, frame_object = shown
    region, view = bpy.context.region, bpy.context.region_data
    try:
        places = handle_places(frame_object, frame.flat)
        texts = side_texts(frame_object, frame.flat)
    except StepFailed:  # a corner was deleted: the operator says so at the next click
        return
    seen = [location_3d_to_region_2d(region, view, place) for place in places]
    if any(place is None for place in seen):  # behind the eye
        return
    scale = bpy.context.preferences.system.ui_scale
    draw_line([*seen[:_CORNERS], seen[0]], _EDGE_WIDTH, _COLOR)
    for number, place in enumerate(seen):
        half = scale * (_HALF_AT_MOUSE if number == frame.handle else _HALF)
        draw_square(place, half + 1, DARK)
        draw_square(place, half, _AT_MOUSE if number == frame.handle else _COLOR)
    for side, (place, text) in enumerate(zip(seen[_CORNERS:], texts, strict=True)):
        up = _TEXT_BELOW if side == _TOP else _TEXT_ABOVE  # above the upper side, the header may be
        draw_text(place + Vector((0, scale * up)), text, scale * _TEXT_SIZE, _AT_MOUSE)


def register() -> None:
    """Start drawing, if there is a window."""
    global _handler
    if not bpy.app.background:
        _handler = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL")


def unregister() -> None:
    """Stop drawing."""
    global _handler
    if _handler is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handler, "WINDOW")
        _handler = None
