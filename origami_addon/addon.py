"""What is registered with Blender, in order; taken back the other way round."""

from __future__ import annotations

import bpy

from . import operators
from .jobs import running
from .scene import document_copies, edits, properties
from .window import manual, menus, overlay, panels

CLASSES = (*operators.CLASSES, *panels.CLASSES)


def register() -> None:
    """Make properties, operators, panels, menus and the manual known to Blender."""
    properties.register()
    for each in CLASSES:
        bpy.utils.register_class(each)
    menus.register()
    manual.register()
    edits.register()
    document_copies.register()
    overlay.register()
    bpy.app.handlers.load_pre.append(_end_job)


def unregister() -> None:
    """The counterpart of `register`; a job that runs is ended."""
    running.end()
    bpy.app.handlers.load_pre.remove(_end_job)
    overlay.unregister()
    document_copies.unregister()
    edits.unregister()
    manual.unregister()
    menus.unregister()
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
    properties.unregister()


@bpy.app.handlers.persistent
def _end_job(*_: object) -> None:
    """What a job finds, or fails for, belongs to the file that it was started in."""
    running.end()
    running.set_failure(None)
