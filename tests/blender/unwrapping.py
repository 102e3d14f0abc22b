"""A mesh without photos is unwrapped from Blender's own menu."""

from __future__ import annotations

import bpy
import numpy as np

from .hands import Waits
from .user import User

_ROWS, _FEW_ROWS = 60, 20
_TURN = 1.5  # radians


def scene(user: User) -> Waits:
    """A bent sheet: the entry, the question, the result; a smaller one at once, again with another method, undone."""
    yield from _asked(user)
    yield from _at_once(user)


def _at_once(user: User) -> Waits:
    """What takes no time has Blender's redo panel, in Object Mode and in Edit Mode."""
    hands = user.hands
    bent = _bent_sheet(_FEW_ROWS)
    bpy.context.scene.collection.objects.link(bent)
    yield from hands.over()
    yield from hands.key("A", "alt")
    bpy.context.view_layer.objects.active = bent
    bent.select_set(True)
    bpy.ops.ed.undo_push(message="Small Sheet")
    for mode in ("OBJECT", "EDIT"):
        name = bpy.context.view_layer.objects.active.name
        with hands.at():
            bpy.ops.object.mode_set("INVOKE_DEFAULT", True, mode=mode)
            bpy.ops.mesh.select_all("INVOKE_DEFAULT", True, action="SELECT") if mode == "EDIT" else None
            done = bpy.ops.origami.unwrap_developable("INVOKE_DEFAULT", True)
        yield 1.0
        user.check(f"a small mesh is unwrapped at once, in {mode}", done == {"FINISHED"}, done)
        last = bpy.context.window_manager.operators[-1]
        user.check("  with a redo panel", last.bl_idname == "ORIGAMI_OT_unwrap_developable", last.bl_idname)
        user.check("  in the mode as before", bpy.context.mode == ("EDIT_MESH" if mode == "EDIT" else mode))
        yield from hands.over()
        yield from hands.key("F9")
        yield 1.0
        hands.picture(f"unwrap_redo_{mode.lower()}")
        yield from hands.key("ESC")
        yield from hands.key("Z", "ctrl")
        yield 1.0
        there = bpy.data.objects[name].data.uv_layers
        user.check("  Ctrl-Z takes it back", mode == "EDIT" or not there, len(there))
    with hands.at():
        bpy.ops.object.mode_set(mode="OBJECT")


def _asked(user: User) -> Waits:
    hands = user.hands
    bent = _bent_sheet(_ROWS)
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


def _bent_sheet(rows: int) -> bpy.types.Object:
    """A part of a cylinder with radius 1, as high as it is wide."""
    turn, height = (each.ravel() for each in np.meshgrid(np.linspace(0, _TURN, rows), np.linspace(0, 1, rows)))
    corner = (np.arange(rows - 1)[:, None] * rows + np.arange(rows - 1)).ravel()
    faces = corner[:, None] + (0, 1, rows + 1, rows)
    mesh = bpy.data.meshes.new("bent sheet")
    mesh.from_pydata(np.column_stack([np.cos(turn), np.sin(turn), height]).tolist(), [], faces.tolist())
    return bpy.data.objects.new("bent sheet", mesh)
