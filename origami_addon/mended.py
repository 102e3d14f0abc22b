"""Notes which objects of a document the user changes, so that panels need not read meshes to know."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .document import Document, document_of
from .show import OUTLINE, PAGE_FRAME, POINTS, SHEET

_PART = {POINTS: "points", OUTLINE: "outline", SHEET: "vertices", PAGE_FRAME: "frame"}
_changed: dict[str, set[str]] = {}
_by_us = False
_changes = Counter[str]()


def mended(document: Document) -> frozenset[str]:
    """Which parts of the document have been changed by hand in this session since it was computed, as far as seen."""
    return frozenset(_changed.get(document.name, ()))


def changes(*roles: str) -> int:
    """How often objects of these roles have changed, by whoever: what was read at the same number still holds."""
    return sum(_changes[role] for role in roles)


def forget(document: Document, *parts: str) -> None:
    """Note that what was changed by hand has been taken in, or is gone."""
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


@bpy.app.handlers.persistent
def _note(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    for update in depsgraph.updates:
        if not isinstance(update.id, bpy.types.Object) or "origami_role" not in update.id:
            continue
        role = str(update.id["origami_role"])
        _changes[role] += 1
        if update.is_updated_geometry and not _by_us:
            document = document_of(update.id)
            part = _PART.get(role)
            if document is not None and part is not None:
                _changed.setdefault(document.name, set()).add(part)


@bpy.app.handlers.persistent
def _forget_all(*_: object) -> None:
    _changed.clear()


def register() -> None:
    """Begin to watch."""
    bpy.app.handlers.depsgraph_update_post.append(_note)
    bpy.app.handlers.load_pre.append(_forget_all)


def unregister() -> None:
    """Watch no longer."""
    bpy.app.handlers.depsgraph_update_post.remove(_note)
    bpy.app.handlers.load_pre.remove(_forget_all)
    _forget_all()
