"""One Undo takes back one stage; a saved file continues where it was left."""

from __future__ import annotations

import bpy

from .hands import Waits
from .user import STAGES, User


def scene(user: User) -> Waits:
    """Run again from the ridges, undo, redo, save, open, run one more stage."""
    hands = user.hands
    user.group().settings.surface.smoothness = 2.0
    hands.forget_places()
    yield from hands.press("bpy.ops.origami.rectify")
    yield 0.5
    yield from user.wait_for_end()
    user.check("all is done", user.done() == list(STAGES), user.done())
    whole = user.state_digest()
    yield from hands.over()
    for left in range(len(STAGES) - 1, 2, -1):
        yield from hands.key("Z", "ctrl")
        yield 1.0
        user.check(f"Ctrl-Z leaves {left} stages", user.done() == list(STAGES[:left]), user.done())
    for _ in range(3):
        yield from hands.key("Z", "ctrl", "shift")
        yield 1.0
    user.check("undo and redo are no edits", not user.module("scene.edits").edits(user.document()))
    user.check("Ctrl-Shift-Z brings them back", user.state_digest() == whole, user.done())
    yield from hands.key("Z", "ctrl")
    yield 1.0
    left, path = user.state_digest(), user.folder / "saved.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    user.check("the file is saved", path.exists(), f"{path.stat().st_size / 1e6:.1f} MB")
    yield from hands.open(path)
    user.check("opened, it is as it was saved", user.state_digest() == left, user.done())
    hands.forget_places()
    yield from hands.show_tab("Origami")
    yield from hands.press("bpy.ops.origami.rectify")
    yield 0.5
    yield from user.wait_for_end()
    user.check("and goes on from there", user.done() == list(STAGES), user.done())
    yield from hands.sidebar_picture("reopened_panel")
