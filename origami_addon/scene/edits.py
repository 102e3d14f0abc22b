"""Tracks which parts of a document were edited by hand: positions, UV map, creases, outline, each separately.

An object that still agrees with the document's arrays counts as not edited, however it was touched. Panels ask often,
so the parts are noted when Blender reports a change; before computing, `edited_parts` compares directly.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import bpy
import numpy as np

from ...core.arrays import Array, Indices
from ...core.errors import OrigamiError
from ...core.sheet import FlatMap
from ..stages import Part
from ..state import Found, LaidOut, Placed, State, Surfaced
from .document import Document, document_of, documents
from .modes import in_edit_mode
from .outline_curve import object_to_outline
from .page_object import corners_moved
from .points_mesh import points_left
from .ridge_group import read_ridges
from .roles import OUTLINE, PAGE_FRAME, POINTS, SHEET
from .shape_keys import unfolded_share
from .sheet_mesh import is_unchanged, page_uv, read_flat

_PARTS: dict[str, tuple[Part, ...]] = {
    POINTS: ("points",),
    OUTLINE: ("outline",),
    SHEET: ("vertices", "creases", "page"),
    PAGE_FRAME: ("frame",),
}
# The parts that each mode can edit; other modes only change a sheet's picture and colours.
_EDITED_IN: dict[str, Part] = {"SCULPT": "vertices", "WEIGHT_PAINT": "creases"}
_edits: dict[str, set[Part]] = {}
_opened: dict[int, float] = {}  # of each sheet's object: how far open it was shown last
_own = False
_changes = Counter[str]()


def edits(document: Document) -> frozenset[Part]:
    """The parts of the document noted as edited by hand since it was computed."""
    return frozenset(_edits.get(document.name, ()))


def changes(*roles: str) -> int:
    """How often objects with these roles have changed for any reason: values read at the same count are valid."""
    return sum(_changes[role] for role in roles)


def forget(document: Document, *parts: Part) -> None:
    """Note that an edit has been taken over, or is gone."""
    _edits.get(document.name, set()).difference_update(parts)


def edited_parts(document: Document, state: State) -> set[Part]:
    """The parts that differ from the document's arrays; objects in Edit Mode cannot be read."""
    found: set[Part] = set()
    for role in _PARTS:
        shown = document.object(role)
        if shown is not None and not in_edit_mode(shown):
            found |= _edited(shown, role, state, document.frame)
    return found


def _edited(shown: bpy.types.Object, role: str, state: State, frame: Array) -> set[Part]:
    if role == SHEET:
        return _edited_of_sheet(shown, state, frame)
    try:
        if role == POINTS and isinstance(state, Placed):
            edited = not points_left(shown, state.model).all()
        elif role == OUTLINE and isinstance(state, Found):
            polygon = state.region.outline.polygon
            edited = object_to_outline(shown, polygon, state.reference) is not polygon
        else:
            edited = role == PAGE_FRAME and isinstance(state, LaidOut) and corners_moved(shown, state.flat)
    except OrigamiError:  # the code that reads the object reports what is wrong with it
        edited = True
    return set(_PARTS[role]) if edited else set()


def _edited_of_sheet(sheet_object: bpy.types.Object, state: State, frame: Array) -> set[Part]:
    if not isinstance(state, Surfaced):
        return set()
    if sheet_object.type != "MESH":
        return {"vertices"}
    edited: set[Part] = set()
    flat = read_flat(sheet_object)
    if not is_unchanged(sheet_object, state.sheet, frame):
        edited.add("vertices")
    elif not _same_ridges(read_ridges(sheet_object, None if flat is None else flat.uv), state.sheet.ridges):
        edited.add("creases")
    if flat is not None and isinstance(state, LaidOut) and not _same_flat(flat, state.flat):
        edited.add("page")
    return edited


def _same_ridges(read: Sequence[Indices], computed: Sequence[Indices]) -> bool:
    return len(read) == len(computed) and all(map(np.array_equal, read, computed))


def _same_flat(read: FlatMap, computed: FlatMap) -> bool:
    if read.uv.shape != computed.uv.shape or (read.width, read.height) != (computed.width, computed.height):
        return False
    return bool(np.abs(page_uv(read) - page_uv(computed)).max() <= 4 * np.finfo(np.float32).eps)


@contextmanager
def own_changes() -> Iterator[None]:
    """Changes within this block are not the user's."""
    global _own
    _own = True
    try:
        yield
        bpy.context.view_layer.update()
    finally:
        _own = False


@bpy.app.handlers.persistent
def _note(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    for update in depsgraph.updates:
        if not isinstance(update.id, bpy.types.Object) or "origami_role" not in update.id:
            continue
        changed = update.id.original
        role = str(changed["origami_role"])
        _changes[role] += 1
        # Blender reports objects in Edit Mode again when the user leaves the mode.
        edited = update.is_updated_geometry and role in _PARTS and not _own and not in_edit_mode(changed)
        if edited and not (role == SHEET and _has_opened(changed)):
            _look_at(changed, role)


def _has_opened(sheet_object: bpy.types.Object) -> bool:
    """Whether the slider that unfolds a sheet has moved: nothing else has changed then, and it moves with the mouse."""
    share = unfolded_share(sheet_object) if sheet_object.type == "MESH" else 0.0
    before = _opened.get(sheet_object.session_uid, 0.0)
    _opened[sheet_object.session_uid] = share
    return share != before


def _look_at(changed: bpy.types.Object, role: str) -> None:
    """Note the edited parts of an object; selecting, or entering Edit Mode, does not count as an edit."""
    document = document_of(changed)
    if document is None or document.object(role) != changed:  # a copy that the user has made of it
        return
    known = _edits.setdefault(document.name, set())
    if changed.mode == "OBJECT":
        known.difference_update(_PARTS[role])
        known |= _edited(changed, role, document.state, document.frame)
    elif role == SHEET and changed.mode in _EDITED_IN:
        known.add(_EDITED_IN[changed.mode])


@bpy.app.handlers.persistent
def _forget_all(*_: object) -> None:
    _edits.clear()
    _opened.clear()


@bpy.app.handlers.persistent
def look_at_all(*_: object) -> None:
    """Note the edited parts of every document."""
    for document in documents():
        _edits[document.name] = edited_parts(document, document.state)


def register() -> None:
    """Start to watch."""
    bpy.app.handlers.depsgraph_update_post.append(_note)
    bpy.app.handlers.load_pre.append(_forget_all)
    bpy.app.handlers.load_post.append(look_at_all)


def unregister() -> None:
    """Stop watching."""
    bpy.app.handlers.depsgraph_update_post.remove(_note)
    bpy.app.handlers.load_pre.remove(_forget_all)
    bpy.app.handlers.load_post.remove(look_at_all)
    _forget_all()
