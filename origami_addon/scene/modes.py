"""In and out of Edit Mode, in which a mesh's own arrays are out of reach."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy


def set_mode(edited: bpy.types.Object, mode: str) -> None:
    """Put an object into a mode, whichever object is active."""
    if edited.mode != mode:
        with bpy.context.temp_override(active_object=edited, object=edited):
            bpy.ops.object.mode_set(mode=mode)


@contextmanager
def in_object_mode(edited: bpy.types.Object) -> Iterator[None]:
    """Run the block in Object Mode, and go back to the mode that the object was in."""
    before = edited.mode
    set_mode(edited, "OBJECT")
    try:
        yield
    finally:
        set_mode(edited, before)
