"""The page's frame is dragged by its handles, with whatever a user may do in between."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d

from . import interruptions
from .hands import Waits
from .user import STAGES, User

_OPERATOR, _BUTTON = "ORIGAMI_OT_edit_page_frame", "bpy.ops.origami.edit_page_frame"
_CORNER, _RIGHT = 0, 5  # handles: the upper left corner, the right side
_PULL = -60  # pixels of the screen
_STEPS = 6
_PAUSE_SECONDS = 0.4


def scene(user: User) -> Waits:
    """Cancelled at each moment, interrupted, with another file, and finished."""
    path = user.folder / "before_framing.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    yield from _given_up(user, path)
    yield from _undone(user, path)
    yield from _pressed_twice(user, path)
    yield from _job_meanwhile(user, path)
    for what, change in _CHANGES.items():
        yield from _changed_meanwhile(user, path, what, change)
    yield from _another_file(user, path)
    yield from _finished(user, path)


def _open(user: User, path: Path) -> Waits:
    yield from user.hands.open(path)
    yield from user.hands.show_tab("Origami")
    yield 1.0
    user.hands.forget_places()
    yield from user.hands.toggle("page")


def _begin(user: User) -> Waits:
    yield from user.hands.press(_BUTTON)
    yield _PAUSE_SECONDS
    user.check("the button shows handles", user.modal()[-1:] == [_OPERATOR], user.modal())


def _place(user: User, handle: int) -> tuple[float, float]:
    """Where a handle is on the screen."""
    drag_frame, view = user.module("operators.drag_frame"), user.hands.region("WINDOW")
    shown, frame_object = drag_frame.dragged()
    place = drag_frame.handle_places(frame_object, shown.flat)[handle]
    seen = location_3d_to_region_2d(view, user.hands.area().spaces.active.region_3d, place)
    return view.x + seen.x, view.y + seen.y


def _corners(user: User) -> np.ndarray:
    frame = user.document().object("page frame")
    return np.array([vertex.co[:2] for vertex in frame.data.vertices])


def _take(user: User, handle: int, across: float, up: float) -> Waits:
    """Drag a handle by pixels of the screen, and hold it there."""
    x, y = _place(user, handle)
    yield from user.hands.take(x, y)
    for step in range(1, _STEPS + 1):
        yield from user.hands.move(x + across * step / _STEPS, y + up * step / _STEPS)
    yield _PAUSE_SECONDS


def _drag(user: User, handle: int, across: float, up: float = 0.0) -> Waits:
    yield from _take(user, handle, across, up)
    yield from user.hands.let_go()
    yield _PAUSE_SECONDS


def _given_up(user: User, path: Path) -> Waits:
    """ESC or the right button, with a handle in the hand and without."""
    yield from _open(user, path)
    before, digest = _corners(user), user.state_digest()
    for key in ("ESC", "RIGHTMOUSE"):
        yield from _begin(user)
        view = user.hands.area().spaces.active.region_3d
        user.check("the page is seen from straight above", view.view_perspective == "ORTHO")
        yield from _drag(user, _RIGHT, _PULL)
        once = _corners(user)
        user.check("a side follows the mouse", once[1, 0] < before[1, 0] and once[1, 0] == once[2, 0], once)
        user.check("  and nothing else moves", np.array_equal(once[[0, 3]], before[[0, 3]]))
        user.check("  which is noted", "frame" in user.module("scene.edits").edits(user.document()))
        yield from _take(user, _CORNER, 30, -40)
        user.check("a corner follows the mouse while it is held", not np.array_equal(_corners(user), once))
        user.hands.picture(f"frame_dragged_{key.lower()}")
        yield from user.hands.key(key)
        yield _PAUSE_SECONDS
        user.check(f"{key} puts a corner that is held back", np.array_equal(_corners(user), once), _corners(user))
        user.check("  and the handles stay", user.modal() == [_OPERATOR], user.modal())
        yield from user.hands.let_go()
        yield from user.hands.over()
        yield from user.hands.key(key)
        yield _PAUSE_SECONDS
        user.check(f"{key} then ends it", user.modal() == [], user.modal())
        user.check("  and all is as before", np.array_equal(_corners(user), before))
        user.check("  nothing counts as edited", not user.module("scene.edits").edits(user.document()))
        yield from user.hands.key("ESC")
    user.check("the document is as before", user.state_digest() == digest)
    user.hands.picture("frame_put_back")


def _undone(user: User, path: Path) -> Waits:
    """Ctrl-Z takes back one drag after the other; more of it takes back what was before, and does no harm."""
    yield from _open(user, path)
    before = _corners(user)
    yield from _begin(user)
    yield from _drag(user, _RIGHT, _PULL)
    once = _corners(user)
    yield from _drag(user, _CORNER, 40, -40)
    yield from user.hands.over()
    yield from user.hands.key("Z", "ctrl")
    yield 1.0
    user.check("Ctrl-Z takes back one drag", np.allclose(_corners(user), once), _corners(user))
    user.check("  and the handles stay", user.modal() == [_OPERATOR], user.modal())
    yield from user.hands.key("Z", "ctrl")
    yield 1.0
    user.check("  again the one before", np.allclose(_corners(user), before), _corners(user))
    yield from _drag(user, _RIGHT, _PULL)
    user.check("  and dragging goes on", not np.allclose(_corners(user), before))
    for _ in range(4):
        yield from user.hands.key("Z", "ctrl")
        yield 1.0
    yield from user.hands.key("LEFTMOUSE")
    yield from user.hands.key("ESC")
    yield _PAUSE_SECONDS
    user.check("Undo again and again does no harm", user.modal() == [], user.modal())


def _pressed_twice(user: User, path: Path) -> Waits:
    yield from _open(user, path)
    yield from _begin(user)
    yield from _begin(user)
    yield from user.hands.over()
    yield _PAUSE_SECONDS
    user.check("pressed twice, it is there once", user.modal() == [_OPERATOR], user.modal())
    yield from user.hands.key("RET")
    yield _PAUSE_SECONDS
    user.check("Enter without a drag cuts nothing", user.modal() == [] and user.running() is None, user.modal())
    user.check("  and the page is up to date", user.done() == list(STAGES), user.done())


def _job_meanwhile(user: User, path: Path) -> Waits:
    yield from _open(user, path)
    yield from _begin(user)
    yield from interruptions.a_run(user, "handles")


def _hide(user: User) -> None:
    user.document().object("page frame").hide_set(True)


def _edit(user: User) -> None:
    bpy.context.view_layer.objects.active = user.document().object("page frame")
    bpy.ops.object.mode_set(mode="EDIT")


def _delete_frame(user: User) -> None:
    bpy.data.objects.remove(user.document().object("page frame"))


def _delete_corner(user: User) -> None:
    user.document().object("page frame").data.clear_geometry()


def _delete_all(user: User) -> None:
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()


_CHANGES: dict[str, Callable[[User], None]] = {
    "the frame is hidden": _hide,
    "the frame is edited": _edit,
    "the frame is deleted": _delete_frame,
    "the frame's corners are deleted": _delete_corner,
    "all objects are deleted": _delete_all,
    "the document is deleted": User.delete_document,
    "what was computed is taken back": User.forget_all_but_the_model,
}


def _changed_meanwhile(user: User, path: Path, what: str, change: Callable[[User], None]) -> Waits:
    """Between two drags, and with a handle in the hand."""
    for held in (False, True):
        yield from _open(user, path)
        yield from _begin(user)
        yield from _take(user, _CORNER, 30, -30)
        x, y = user.hands.mouse
        if not held:
            yield from user.hands.let_go()
        with user.hands.at():
            change(user)
            bpy.ops.ed.undo_push(message=what)
        yield _PAUSE_SECONDS
        yield from user.hands.move(x + 5, y)
        if held:
            yield from user.hands.let_go()
        yield from user.hands.click(x, y)
        yield from user.hands.key("RET")
        yield _PAUSE_SECONDS
        when = "with a handle in the hand" if held else "between two drags"
        user.check(f"{what} {when}: the handles are gone", user.modal() == [], user.modal())
        user.check("  and nothing runs", user.running() is None)
        yield from user.hands.over()
        yield from user.hands.key("Z", "ctrl")
        yield 1.0
        yield from user.hands.key("ESC")


def _another_file(user: User, path: Path) -> Waits:
    for held in (False, True):
        for way in interruptions.OTHER_FILES:
            yield from _open(user, path)
            yield from _begin(user)
            yield from _take(user, _RIGHT, _PULL, 0)
            if not held:
                yield from user.hands.let_go()
            yield from interruptions.another_file(user, path, way, f"with a handle {'held' if held else 'moved'}")
            user.check("  and no handle is shown", user.module("operators.drag_frame").dragged() is None)
            yield from interruptions.clicks_afterwards(user)


def _finished(user: User, path: Path) -> Waits:
    yield from _open(user, path)
    flat = user.document().state.flat
    yield from _begin(user)
    yield from _take(user, _RIGHT, _PULL, 0)
    area = user.hands.area()
    user.hands.picture("page_frame", user.hands.box(area), percent=75)
    yield from user.hands.let_go()
    corners = _corners(user)
    share = (corners[1, 0] - corners[0, 0]) / (flat.width / (1000 if flat.unit == "mm" else flat.height))
    yield from user.hands.over()
    yield from user.hands.key("RET")
    yield 1.0
    user.check("Enter cuts the page", user.modal() == ["ORIGAMI_OT_apply_page_frame"], user.modal())
    yield from user.wait_for_end()
    cut = user.document().state.flat
    user.check("  where its side was dragged", abs(cut.width / flat.width - share) < 0.002, [cut.width, flat.width])
    user.check("  and all is done", user.done() == list(STAGES) and user.modal() == [], user.done())
    user.hands.picture("frame_cut")
    yield from user.hands.over()
    for _ in range(3):
        yield from user.hands.key("Z", "ctrl")
        yield 1.0
    user.check("Ctrl-Z takes it back", abs(user.document().state.flat.width - flat.width) < 1e-9)
    yield from user.hands.toggle("page")
