"""Which document the user works on: that of the active object, or the one chosen last.

Everything that shows or changes a document asks here, and whatever chooses one does it here: choosing a document also
leaves an object of another one, which would otherwise still be the one that the user is at.
"""

from __future__ import annotations

import bpy

from .document import Document, document_of
from .roles import CAMERA, ORIGIN, OUTLINE, PAGE_FRAME, SHEET

# The parts that become active when their document is chosen, the best one first.
_MAIN = (SHEET, PAGE_FRAME, OUTLINE, CAMERA, ORIGIN)


def active_document(context: bpy.types.Context) -> Document | None:
    """The document in the panels: that of the active object, or the one chosen last."""
    chosen = document_of(context.scene.origami.document)
    return document_of(context.active_object) or chosen


def choose(context: bpy.types.Context, document: Document) -> None:
    """Make a document the one that the user is at, in Object Mode if they were at another one's object.

    Of a document that the view layer shows, an object is then active, so that what the user sees selected belongs to
    the document in the panels; of another one, none is.
    """
    context.scene.origami.document = document.collection
    active = context.active_object
    other = document_of(active)
    if other is None or other.name == document.name:
        return
    layer = context.view_layer
    if active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    there = [each for role in _MAIN for each in document.objects(role)]
    found = next((each for each in there if layer.objects.get(each.name) == each and each.visible_get()), None)
    for each in layer.objects:
        each.select_set(each == found)
    layer.objects.active = found


def place_of(context: bpy.types.Context) -> int:
    """The place of the active document's collection in ``bpy.data.collections``; -1 without one."""
    document = active_document(context)
    collections = bpy.data.collections
    return -1 if document is None else next(n for n, each in enumerate(collections) if each == document.collection)


def choose_place(context: bpy.types.Context, place: int) -> None:
    """Choose the document whose collection is at a place in ``bpy.data.collections``."""
    if 0 <= place < len(bpy.data.collections):
        document = document_of(bpy.data.collections[place])
        if document is not None:
            choose(context, document)
