"""A crease is drawn between two clicks, with whatever a user may do in between."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d

from . import interruptions
from .hands import Waits
from .user import User

_OPERATOR = "ORIGAMI_OT_draw_crease"
_BUTTON = "bpy.ops.origami.draw_crease"
_ENDS = (0.1, 0.15), (0.9, 0.17)  # on the page, across and up, between its lower edge and its first fold
_PAUSE_SECONDS = 0.4


def scene(user: User) -> Waits:
    """Cancelled at each moment, interrupted between the clicks, with another file, and finished."""
    path = user.folder / "before_drawing.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    yield from _given_up(user, path)
    yield from _pressed_twice(user, path)
    yield from _job_meanwhile(user, path)
    yield from _changed_meanwhile(user, path)
    yield from _gone_meanwhile(user, path)
    yield from _another_file(user, path)
    yield from _finished(user, path)


def _open(user: User, path: Path) -> Waits:
    """The finished document, with the sheet in the view and the step open."""
    yield from user.hands.open(path)
    yield from user.hands.show_tab("Origami")
    with user.hands.at():
        bpy.ops.view3d.view_axis(type="TOP")
        bpy.ops.view3d.view_all()
    yield 1.0
    user.hands.forget_places()
    yield from user.hands.toggle("surface")


def _click_on_page(user: User, place: tuple[float, float]) -> Waits:
    """Click on the sheet where it shows this place of the page."""
    sheet = user.document().object("sheet")
    uv = np.zeros(2 * len(sheet.data.loops), np.float32)
    sheet.data.uv_layers["page"].uv.foreach_get("vector", uv)
    nearest = np.linalg.norm(uv.reshape(-1, 2) - place, axis=1).argmin()
    vertex = sheet.data.vertices[sheet.data.loops[int(nearest)].vertex_index]
    view = user.hands.region("WINDOW")
    shown = location_3d_to_region_2d(view, user.hands.area().spaces.active.region_3d, sheet.matrix_world @ vertex.co)
    yield from user.hands.click(view.x + shown.x, view.y + shown.y)
    yield _PAUSE_SECONDS


def _begin(user: User, clicks: int) -> Waits:
    yield from user.hands.press(_BUTTON)
    user.check("the button waits for clicks", user.modal()[-1:] == [_OPERATOR], user.modal())
    for place in _ENDS[:clicks]:
        yield from _click_on_page(user, place)


def _given_up(user: User, path: Path) -> Waits:
    yield from _open(user, path)
    before = user.state_digest()
    for key in ("ESC", "RIGHTMOUSE"):
        for clicks in (0, 1):
            yield from _begin(user, clicks)
            yield from user.hands.over()
            yield from user.hands.key(key)
            yield _PAUSE_SECONDS
            user.check(f"{key} after {clicks} clicks puts the knife down", user.modal() == [], user.modal())
    yield from user.hands.key("ESC")
    yield from _begin(user, 2)
    user.check("after two clicks the sheet is rebuilt", user.running() is not None)
    user.check("by another operator", user.modal() == ["ORIGAMI_OT_add_crease"], user.modal())
    yield from user.hands.over()
    yield from user.hands.key("ESC")
    yield 2.0
    user.check("ESC ends it", user.running() is None and user.modal() == [], user.modal())
    user.check("and all is as before", user.state_digest() == before)


def _pressed_twice(user: User, path: Path) -> Waits:
    yield from _open(user, path)
    yield from _begin(user, 1)
    yield from user.hands.press(_BUTTON)
    yield from user.hands.over()
    yield _PAUSE_SECONDS
    user.check("pressed twice, one knife is there", user.modal() == [_OPERATOR], user.modal())
    yield from _click_on_page(user, _ENDS[0])
    user.check("which starts again", user.running() is None)
    yield from user.hands.key("ESC")
    yield _PAUSE_SECONDS
    user.check("and is put down by one ESC", user.modal() == [], user.modal())


def _job_meanwhile(user: User, path: Path) -> Waits:
    yield from _open(user, path)
    yield from _begin(user, 1)
    yield from interruptions.a_run(user, "knife")


def _hide(user: User) -> None:
    user.document().object("sheet").hide_set(True)


def _edit(user: User) -> None:
    bpy.context.view_layer.objects.active = user.document().object("sheet")
    bpy.ops.object.mode_set(mode="EDIT")


def _delete_sheet(user: User) -> None:
    bpy.data.objects.remove(user.document().object("sheet"))


_CHANGES: dict[str, Callable[[User], None]] = {
    "the sheet is hidden": _hide,
    "the sheet is edited": _edit,
    "another document is chosen": User.choose_another_document,
    "the sheet is deleted": _delete_sheet,
    "the document is deleted": User.delete_document,
    "what was computed is taken back": User.forget_all_but_the_model,
}


def _changed_meanwhile(user: User, path: Path) -> Waits:
    for what, change in _CHANGES.items():
        yield from _open(user, path)
        yield from _begin(user, 1)
        with user.hands.at():
            change(user)
            bpy.ops.ed.undo_push(message=what)
        yield _PAUSE_SECONDS
        yield from user.hands.over()
        yield from user.hands.key("LEFTMOUSE")
        yield _PAUSE_SECONDS
        user.check(f"{what} between the clicks: the knife is put down", user.modal() == [], user.modal())
        user.check("  and nothing runs", user.running() is None)
        yield from user.hands.key("Z", "ctrl")
        yield 1.0
        yield from user.hands.key("ESC")


def _gone_meanwhile(user: User, path: Path) -> Waits:
    yield from _open(user, path)
    yield from _begin(user, 1)
    user.hands.window.workspace = bpy.data.workspaces["UV Editing"]
    yield 2.0
    yield from user.hands.over(area="IMAGE_EDITOR")
    yield from user.hands.key("LEFTMOUSE")
    yield _PAUSE_SECONDS
    user.check("in another workspace the knife is still there", user.modal() == [_OPERATOR], user.modal())
    yield from user.hands.key("ESC")
    yield _PAUSE_SECONDS
    user.check("until ESC", user.modal() == [], user.modal())
    user.hands.window.workspace = bpy.data.workspaces["Layout"]
    yield 1.0
    user.hands.picture("knife_put_down_elsewhere")
    yield from _begin(user, 1)
    yield from user.hands.over()
    for _ in range(3):
        yield from user.hands.key("Z", "ctrl")
        yield 1.0
    yield from user.hands.key("ESC")
    yield _PAUSE_SECONDS
    user.check("Undo between the clicks does no harm", user.modal() == [], user.modal())


def _another_file(user: User, path: Path) -> Waits:
    for clicks in (1, 2):
        for way in interruptions.OTHER_FILES:
            yield from _open(user, path)
            yield from _begin(user, clicks)
            yield from interruptions.another_file(user, path, way, f"after {clicks} clicks")
            yield from interruptions.clicks_afterwards(user)


def _finished(user: User, path: Path) -> Waits:
    yield from _open(user, path)
    before = user.state_digest()
    there = len(user.module("scene.ridge_group").fold_angles(user.document().object("sheet")))
    yield from _begin(user, 2)
    yield from user.wait_for_end()
    creases = json.loads(user.group().creases or "[]")
    user.check("the drawn crease is one more", len(creases) == there + 1, creases)
    user.check("and all stages are done", len(user.done()) == 6 and user.state_digest() != before, user.done())
    user.check("nothing is left in Blender's hands", user.modal() == [], user.modal())
    user.hands.picture("drawn")
