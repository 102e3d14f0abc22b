"""A mesh without photos is unwrapped from Blender's own menu."""

from __future__ import annotations

import bpy
import numpy as np

from .hands import Waits
from .user import User

_ROWS = 60
_TURN = 1.5  # radians


def scene(user: User) -> Waits:
    """A bent sheet: the entry, the question, the result."""
    hands = user.hands
    bent = _bent_sheet()
    bpy.context.scene.collection.objects.link(bent)
    yield from hands.over()
    yield from hands.key("A", "alt")
    bpy.context.view_layer.objects.active = bent
    bent.select_set(True)
    with hands.at():
        bpy.ops.ed.undo_push(message="Bent Sheet")
        bpy.ops.origami.unwrap_developable("INVOKE_DEFAULT")
    yield 1.0
    yield from hands.press_blue("unwrap_dialog")
    yield 0.3
    user.check("it unwraps while the window goes on", user.running() is not None)
    yield from user.wait_for_end()
    uv = np.zeros(2 * len(bent.data.loops), np.float32)
    layer = bent.data.uv_layers.active
    user.check("there is a UV map", layer is not None)
    layer.uv.foreach_get("vector", uv)
    extent = np.ptp(uv.reshape(-1, 2), axis=0)
    user.check("as long as the bow", abs(max(extent) / min(extent) - _TURN) < 0.01, extent)


def _bent_sheet() -> bpy.types.Object:
    """A part of a cylinder with radius 1, as high as it is wide."""
    turn, height = (each.ravel() for each in np.meshgrid(np.linspace(0, _TURN, _ROWS), np.linspace(0, 1, _ROWS)))
    corner = (np.arange(_ROWS - 1)[:, None] * _ROWS + np.arange(_ROWS - 1)).ravel()
    faces = corner[:, None] + (0, 1, _ROWS + 1, _ROWS)
    mesh = bpy.data.meshes.new("bent sheet")
    mesh.from_pydata(np.column_stack([np.cos(turn), np.sin(turn), height]).tolist(), [], faces.tolist())
    return bpy.data.objects.new("bent sheet", mesh)
