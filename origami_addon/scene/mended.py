"""Notes which objects of a document the user changes, so that panels need not read meshes to know."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .document import Document, document_of, documents
from .fingerprint import has_fingerprint, is_as_made, remember
from .show import OUTLINE, PAGE_FRAME, POINTS, SHEET

_PART = {POINTS: "points", OUTLINE: "outline", SHEET: "vertices", PAGE_FRAME: "frame"}
_changed: dict[str, set[str]] = {}
_by_us = False
_made: set[str] = set()  # names of the objects that are being changed by us
_changes = Counter[str]()


def mended(document: Document) -> frozenset[str]:
    """Which parts of the document have been changed by hand since it was computed, as far as seen."""
    return frozenset(_changed.get(document.name, ()))


def changes(*roles: str) -> int:
    """How often objects of these roles have changed, by whoever: what was read at the same number still holds."""
    return sum(_changes[role] for role in roles)


def forget(document: Document, *parts: str) -> None:
    """Note that what was changed by hand has been taken in, or is gone."""
    if _by_us:  # Blender tells nothing of what it does not show, as another scene
        roles = (role for role, part in _PART.items() if part in parts)
        _made.update(each.name for each in map(document.object, roles) if each is not None)
    _changed.get(document.name, set()).difference_update(parts)


@contextmanager
def by_us() -> Iterator[None]:
    """What changes meanwhile is no user's change."""
    global _by_us
    _by_us = True
    try:
        yield
        bpy.context.view_layer.update()
    finally:
        _by_us = False
        for name in _made:
            made = bpy.data.objects.get(name)
            if made is not None and made.mode == "OBJECT":
                remember(made)
        _made.clear()


@bpy.app.handlers.persistent
def _note(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    for update in depsgraph.updates:
        if not isinstance(update.id, bpy.types.Object) or "origami_role" not in update.id:
            continue
        changed = update.id.original
        role = str(changed["origami_role"])
        _changes[role] += 1
        if not update.is_updated_geometry or role not in _PART:
            continue
        if _by_us:
            _made.add(changed.name)
        elif changed.mode != "EDIT":  # Blender tells of it again when the mode is left
            _look_at(changed, role)


def _look_at(changed: bpy.types.Object, role: str) -> None:
    """Note whether an object is as it was made; selecting, or a look into Edit Mode, is no change."""
    document = document_of(changed)
    if document is None:
        return
    parts = _changed.setdefault(document.name, set())
    if changed.mode == "OBJECT" and is_as_made(changed):
        parts.discard(_PART[role])
    else:
        parts.add(_PART[role])


@bpy.app.handlers.persistent
def _forget_all(*_: object) -> None:
    _changed.clear()


@bpy.app.handlers.persistent
def look_at_all(*_: object) -> None:
    """Note for every object whether it is as it was made."""
    for document in documents():
        for role in _PART:
            shown = document.object(role)
            if shown is not None and has_fingerprint(shown):
                _look_at(shown, role)


def register() -> None:
    """Begin to watch."""
    bpy.app.handlers.depsgraph_update_post.append(_note)
    bpy.app.handlers.load_pre.append(_forget_all)
    bpy.app.handlers.load_post.append(look_at_all)


def unregister() -> None:
    """Watch no longer."""
    bpy.app.handlers.depsgraph_update_post.remove(_note)
    bpy.app.handlers.load_pre.remove(_forget_all)
    bpy.app.handlers.load_post.remove(look_at_all)
    _forget_all()
