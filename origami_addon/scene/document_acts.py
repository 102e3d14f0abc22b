"""What happens to a document as a whole: another title, and a copy beside it."""

from __future__ import annotations

from collections.abc import Iterable

import bpy

from .document import Document
from .document_copies import has_step, part_copies
from .free_ground import stand_beside_others
from .roles import PAGE_FRAME, SHEET


def retitle(document: Document, title: str) -> None:
    """Give a document another title; its objects and their data, as far as they are named after it, follow.

    The name with which everything is marked stays: running jobs, and folders with results, know the document by it.
    """
    before = document.title
    if not title or title == before:
        return
    document.collection.name = title
    _follow(_made(document), before, document.title)


def duplicate_document(document: Document) -> Document:
    """A copy of a document in the same scene, to its right, with its own data; the user's objects are not copied.

    The caller pushes an undo step.
    """
    first = document.collection
    copied = first.copy()
    for child in list(copied.children):
        copied.children.unlink(child)
    for each in list(copied.objects):
        copied.objects.unlink(each)
    twins = {each: each.copy() for each in first.all_objects if document.made(each)}
    for twin in twins.values():
        copied.objects.link(twin)
    scene = document.scene or bpy.context.scene
    scene.collection.children.link(copied)
    bpy.context.view_layer.update()
    for layer in scene.view_layers:
        for each, twin in twins.items():
            if layer.objects.get(each.name) == each and layer.objects.get(twin.name) == twin:
                twin.hide_set(each.hide_get(view_layer=layer), view_layer=layer)
                twin.select_set(False, view_layer=layer)
    part_copies()
    has_step()
    copy = Document(copied)
    for each, twin in twins.items():
        twin.name = each.name.replace(document.title, copy.title, 1)
        if twin.data is not None and copy.made(twin.data):
            twin.data.name = twin.name
    stand_beside_others(copy, (SHEET, PAGE_FRAME))
    return copy


def _made(document: Document) -> Iterable[bpy.types.ID]:
    for each in document.collection.all_objects:
        if document.made(each):
            yield each
            if each.data is not None and document.made(each.data):
                yield each.data


def _follow(made: Iterable[bpy.types.ID], before: str, after: str) -> None:
    for each in made:
        if each.name.startswith(f"{before} "):
            each.name = after + each.name[len(before) :]
