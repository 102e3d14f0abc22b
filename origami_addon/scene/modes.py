"""Switches in and out of Edit Mode, in which a mesh's own arrays cannot be read.

In Edit Mode, and in other modes with their own undo, Blender's undo steps only hold the edited data: going back to one
resets everything else to its state before the mode was entered.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import bpy

_OBJECT = "OBJECT"


def in_edit_mode(shown: bpy.types.Object) -> bool:
    """Whether an object's data are in Edit Mode, through the object itself or another one with the same data."""
    return bool(shown.mode == "EDIT" or getattr(shown.data, "is_editmode", False))


def set_mode(edited: bpy.types.Object, mode: str) -> None:
    """Put an object into a mode, whichever object is active; Object Mode also means that its data are not edited."""
    if mode == _OBJECT and edited.mode != "EDIT" and in_edit_mode(edited):
        for each in [other for other in bpy.data.objects if other.data == edited.data and other.mode == "EDIT"]:
            set_mode(each, mode)
    if edited.mode == mode:
        return
    where: dict[str, Any] = {}
    if bpy.context.scene not in edited.users_scene and edited.users_scene:
        scene = edited.users_scene[0]
        where = {"scene": scene, "view_layer": scene.view_layers[0]}
    with bpy.context.temp_override(**where, active_object=edited, object=edited):
        bpy.ops.object.mode_set(mode=mode)


@contextmanager
def in_object_mode(edited: bpy.types.Object) -> Iterator[None]:
    """Run the block in Object Mode, and go back to the mode that the object was in."""
    before = edited.mode
    set_mode(edited, _OBJECT)
    try:
        yield
    finally:
        set_mode(edited, before)


@dataclass(frozen=True)
class UsersMode:
    """The user's mode, if it is not Object Mode.

    Attributes
    ----------
    active : str
        Name of the active object, whose mode it is.
    mode : str
    """

    active: str
    mode: str


def users_mode(context: bpy.types.Context) -> UsersMode | None:
    """The mode that the user is in; None in Object Mode."""
    active = context.active_object
    return None if active is None or active.mode == _OBJECT else UsersMode(active.name, active.mode)


def return_to(context: bpy.types.Context, mode: UsersMode | None) -> None:
    """Return the user to a mode that was left, with an undo step, unless they have switched modes since."""
    active = context.active_object
    if mode is not None and active is not None and (active.name, active.mode) == (mode.active, _OBJECT):
        bpy.ops.object.mode_set(mode=mode.mode)
        bpy.ops.ed.undo_push(message=_step_name(mode))


def push_undo(context: bpy.types.Context, message: str) -> None:
    """Push an undo step for the whole file, whatever mode the user is in."""
    mode = users_mode(context)
    if mode is not None:
        bpy.ops.object.mode_set(mode=_OBJECT)
    with context.temp_override(area=None, region=None):  # an image editor in Paint mode has its own undo, too
        bpy.ops.ed.undo_push(message=message)
    return_to(context, mode)


@contextmanager
def whole_step(context: bpy.types.Context, message: str) -> Iterator[None]:
    """Make what the block changes one undo step of the whole file; the user leaves their mode.

    For operators without Blender's own undo, which in Edit Mode only covers the edited data.
    """
    if users_mode(context) is not None:
        bpy.ops.object.mode_set(mode=_OBJECT)
        _push(f"Before {message}")
    yield
    _push(message)


def _push(message: str) -> None:
    if not bpy.app.background:
        bpy.ops.ed.undo_push(message=message)


def _step_name(mode: UsersMode) -> str:
    return mode.mode.replace("_", " ").title() + (" Mode" if mode.mode == "EDIT" else "")
