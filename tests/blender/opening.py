"""Files are opened one after the other, with each step of the tab open or just closed."""

from __future__ import annotations

import bpy

from .hands import Waits
from .user import STAGES, User


def scene(user: User) -> Waits:
    """Blender lives on, and the document is there."""
    hands, path = user.hands, user.folder / "before_opening.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    for step in hands.steps:
        for clicks in (1, 2):
            yield from hands.open(path)
            hands.forget_places()
            yield from hands.show_tab("Origami")
            for _ in range(clicks):
                yield from hands.toggle(step)
        user.check(f"opened after {step}, all is done", user.done() == list(STAGES), user.done())
    yield from hands.open(path)
    hands.forget_places()
