"""A crease chosen in the list is marked with its number, on the sheet and on the page."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from .hands import Waits
from .user import User

_DRAWN_SECONDS = 2.0
_CHANGED = 0.0005  # share of the view's pixels that a marked crease changes, at least


def scene(user: User) -> Waits:
    """Chosen, another one, none; undone; its crease dropped; its sheet and its document deleted; another file."""
    path = user.folder / "before_numbering.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    yield from _open(user, path)
    count = len(user.module("window.crease_list").listed_creases(user.document()))
    user.check("there are two creases", count >= 2, count)
    for way in ("PAGE", "SHEET"):
        yield from _chosen_in(user, way)
    yield from _undone(user)
    yield from _dropped(user)
    for what, change in (("sheet", _delete_sheet), ("document", User.delete_document)):
        yield from _open(user, path)
        yield from _choose(user, 0)
        with user.hands.at():
            change(user)
            bpy.ops.ed.undo_push(message="Delete")
        yield _DRAWN_SECONDS
        yield from user.hands.over()
        yield from user.hands.key("Z", "ctrl")
        yield 1.0
        user.check(f"with the {what} back it is chosen again", user.group().crease == 0, user.group().crease)
    yield from _choose(user, 0)
    yield from _open(user, path)
    user.check("another file has a choice of its own", user.group().crease == -1, user.group().crease)
    yield from user.hands.toggle("surface")


def _open(user: User, path: Path) -> Waits:
    yield from user.hands.open(path)
    yield from user.hands.show_tab("Origami")
    yield 1.0
    user.hands.forget_places()
    yield from user.hands.toggle("surface")


def _choose(user: User, index: int) -> Waits:
    yield from user.hands.press(f"choose_crease(index={index})")
    yield from user.hands.over()
    yield _DRAWN_SECONDS


def _view(user: User) -> np.ndarray:
    return user.hands.pixels(user.hands.box(user.hands.region("WINDOW"))).astype(int)


def _chosen_in(user: User, way: str) -> Waits:
    """What is marked is seen, whichever way the document is shown."""
    with user.hands.at():
        bpy.ops.origami.show_as(way=way)
    yield from user.hands.over()
    yield _DRAWN_SECONDS
    before = _view(user)
    yield from _choose(user, 1)
    user.check(f"the second one is chosen, seen as {way.lower()}", user.group().crease == 1, user.group().crease)
    user.hands.picture(f"crease_chosen_{way.lower()}")
    share = float((np.abs(_view(user) - before).max(axis=2) > 60).mean())
    user.check("  and marked in the view", share > _CHANGED, share)
    user.check("  it is no edit", not user.module("scene.edits").edits(user.document()))
    yield from _choose(user, 0)
    user.check("  another one takes its place", user.group().crease == 0, user.group().crease)
    yield from _choose(user, 0)
    user.check("  pressed again, none is", user.group().crease == -1, user.group().crease)
    share = float((np.abs(_view(user) - before).max(axis=2) > 60).mean())
    user.check("  and nothing is marked", share < _CHANGED / 10, share)


def _undone(user: User) -> Waits:
    yield from _choose(user, 1)
    yield from user.hands.key("Z", "ctrl")
    yield 1.0
    user.check("Ctrl-Z takes the choice back", user.group().crease == -1, user.group().crease)


def _dropped(user: User) -> Waits:
    yield from _choose(user, 1)
    with user.hands.at():
        bpy.ops.origami.drop_crease("INVOKE_DEFAULT", index=1)
    yield from user.wait_for_end()
    user.check("once its crease is dropped, none is chosen", user.group().crease == -1, user.group().crease)


def _delete_sheet(user: User) -> None:
    bpy.data.objects.remove(user.document().object("sheet"))
