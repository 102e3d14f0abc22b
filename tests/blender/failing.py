"""A run fails: the panel says why, with the earlier warnings, until another run starts."""

from __future__ import annotations

import shutil

import bpy
import numpy as np

from .hands import Waits
from .user import User

_BUTTON = "bpy.ops.origami.rectify"
_NO_SUCH_SHEET = 9


def scene(user: User) -> Waits:
    """One photo is there twice, and the requested sheet is not in view."""
    folder = user.folder / "twice"
    shutil.copytree(user.folder / "two_sheets", folder)
    shutil.copy(folder / "0.png", folder / "copy.png")
    yield from user.hands.open(None)
    user.hands.forget_places()
    with user.hands.at():
        user.module("scene.document").new_document("another", bpy.context.scene)
        bpy.ops.origami.add_photos(directory=f"{folder}/", new=True)
        user.group().settings.sheet = _NO_SUCH_SHEET
        bpy.ops.ed.undo_push(message="Document Photos")
    yield from user.hands.show_tab("Origami")
    before = yield from _rows(user)
    yield from user.hands.press(_BUTTON)
    yield from user.wait_for_end()
    failure = user.module("jobs.running").failure()
    user.check("the run fails at its second stage", failure is not None and user.done() == ["place"], failure)
    user.check("the first one's warning is reported", any("same as" in warning for warning in failure.warnings))
    yield from user.hands.key("ESC")  # Blender's own report covers the tab
    yield from user.hands.sidebar_picture("failed_panel")
    after = yield from _rows(user)
    user.check("the panel says why", after > before, f"{before} to {after} rows of pixels")
    bpy.context.scene.origami.document = bpy.data.collections["another"]
    user.hands.area().tag_redraw()  # which a click in the list would do
    shown = yield from _rows(user)
    user.check("  but not of another document", shown <= before, f"{user.document().title}, {shown} rows")
    bpy.context.scene.origami.document = bpy.data.collections["twice"]
    yield 0.5
    yield from user.hands.press(_BUTTON)
    yield 0.3
    user.check("another run begins", user.running() is not None)
    user.check("  and forgets it", user.module("jobs.running").failure() is None)
    yield from user.hands.over()
    yield from user.hands.key("ESC")
    yield 2.0
    user.check("  which ESC ends without a failure", user.module("jobs.running").failure() is None)
    user.check("  and the panel is as before", (yield from _rows(user)) == before)


def _rows(user: User) -> Waits:
    """How far down the sidebar is filled, in pixels."""
    yield from user.hands.over()
    yield 1.0
    left, top, width, height = user.hands.box(user.hands.region("UI"))
    shown = user.hands.pixels((left, top, width - 30, height)).astype(int)
    filled = np.nonzero((np.abs(shown - shown[-4, 4]) > 6).any(axis=(1, 2)))[0]
    return int(filled[filled < height - 3].max(initial=0))
