"""What may happen while a tool, which its button has put into the user's hand, waits for clicks in the view."""

from __future__ import annotations

from pathlib import Path

import bpy

from .hands import Waits
from .user import User

OTHER_FILES = ("opened", "new")  # ways to another file: the one that is open once more, or a new one


def a_run(user: User, tool: str) -> Waits:
    """A run takes the tool away, and ESC ends the run."""
    user.group().settings.surface.smoothness = 1.5
    with user.hands.at():
        bpy.ops.origami.rectify("INVOKE_DEFAULT")
    yield 1.0
    user.check(f"a run takes the {tool} away", user.modal() == ["ORIGAMI_OT_rectify"], user.modal())
    yield from user.hands.over()
    yield from user.hands.key("ESC")
    yield 2.0
    user.check("  and ends by ESC", user.running() is None and user.modal() == [], user.modal())


def another_file(user: User, path: Path, way: str, when: str) -> Waits:
    """Another file, by one of `OTHER_FILES`, takes the tool away, and nothing of it runs."""
    yield from user.hands.open(path if way == "opened" else None)
    user.check(f"a file {way} {when} ends it", user.modal() == [] and user.running() is None, user.modal())


def clicks_afterwards(user: User) -> Waits:
    """Events that the tool would have taken."""
    yield from user.hands.over()
    yield from user.hands.let_go()
    yield from user.hands.key("LEFTMOUSE")
    yield from user.hands.key("ESC")
