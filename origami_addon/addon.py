"""Everything that is registered with Blender, in order; it is unregistered in reverse."""

from __future__ import annotations

import bpy

from . import operators
from .jobs import running
from .jobs.queue import queue
from .operators import arriving, show_as
from .operators import queue as queue_operators
from .scene import document_copies, edits, properties
from .window import frame_overlay, manual, menus, overlay, panels, photo_list

CLASSES = (*operators.CLASSES, *panels.CLASSES)


def register() -> None:
    """Register properties, operators, panels, menus and the manual with Blender."""
    properties.register()
    for each in CLASSES:
        bpy.utils.register_class(each)
    menus.register()
    manual.register()
    edits.register()
    document_copies.register()
    overlay.register()
    frame_overlay.register()
    photo_list.register()
    arriving.register()
    bpy.app.handlers.load_pre.append(_end_job)


def unregister() -> None:
    """Undo `register`; a running job is ended."""
    queue_operators.unregister()
    running.end()
    running.forget_failures()
    bpy.app.handlers.load_pre.remove(_end_job)
    arriving.unregister()
    photo_list.unregister()
    frame_overlay.unregister()
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
    """End the running job: its results, its failure and noted views belong to the file in which it was started."""
    running.end()
    running.forget_failures()
    queue.clear()
    show_as.forget_views()
