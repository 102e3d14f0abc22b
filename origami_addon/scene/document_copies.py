"""Documents that Blender has copied with their marks: each gets a unique name and its own data.

Duplicating a collection, appending one from another file, and a full copy of a scene make such copies; if they kept the
same name, work on one of them would change the other.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy

from .document import Document, documents, free_name, same_part
from .edits import look_at_all
from .sheet_materials import PICTURE

Replace = Callable[[bpy.types.ID], bpy.types.ID]

_has_no_step = False  # whether data were made here since the last undo step: without one, Undo would crash Blender
_left_by_undo: frozenset[int] = frozenset()  # copies as Undo has brought them back: the user may undo them too


def part_copies() -> None:
    """Make documents of the same name independent of each other; the first one stays as it is."""
    global _has_no_step
    first: dict[str, Document] = {}
    for document in _by_age():
        if first.setdefault(document.name, document) is not document:
            _part(document, first[document.name])
            look_at_all()
            _has_no_step = True


def has_step() -> None:
    """Note that the caller pushes an undo step, which holds the parted copies too."""
    global _has_no_step
    _has_no_step = False


def _copies() -> frozenset[int]:
    """The documents whose name an older one has."""
    names: set[str] = set()
    found = set()
    for document in _by_age():
        if document.name in names:
            found.add(document.collection.session_uid)
        names.add(document.name)
    return frozenset(found)


def _by_age() -> list[Document]:
    return sorted(documents(), key=lambda document: document.collection.session_uid)


def _part(copy: Document, first: Document) -> None:
    theirs = set(first.collection.all_objects)
    mine = [each for each in copy.collection.all_objects if copy.made(each) and each not in theirs]
    shared: set[bpy.types.ID] = set()

    def note(used: bpy.types.ID) -> bpy.types.ID:
        shared.add(used)
        return used

    for each in theirs:
        _replace_used(first, each, note)
    old = first.name
    copy.rename(free_name(old))
    own: dict[bpy.types.ID, bpy.types.ID] = {}

    def owned(used: bpy.types.ID) -> bpy.types.ID:
        if used.library is None and first.made(used) and used not in own:
            own[used] = used.copy() if used in shared else used
            copy.own(own[used])
            if PICTURE in used:
                own[used][PICTURE] = copy.name + str(used[PICTURE]).removeprefix(old)
        return own.get(used, used)

    for each in mine:
        copy.own(each)
        _replace_used(copy, each, owned)
        if each.parent in theirs:
            each.parent = next((part for part in mine if same_part(part, each.parent)), None)


def _replace_used(document: Document, user: bpy.types.Object, by: Replace) -> None:
    """Replace the data, materials and pictures made for an object of the document; the user's own stay."""
    if user.data is not None:
        _replace(user, "data", by)
    for slot in user.material_slots:
        if slot.material is None:
            continue
        _replace(slot, "material", by)
        if document.made(slot.material) and slot.material.node_tree is not None:
            for node in slot.material.node_tree.nodes:
                if getattr(node, "image", None) is not None:
                    _replace(node, "image", by)
    if user.type == "CAMERA" and document.made(user.data):
        for background in user.data.background_images:
            if background.image is not None:
                _replace(background, "image", by)


def _replace(holder: bpy.types.bpy_struct, attribute: str, by: Replace) -> None:
    used = getattr(holder, attribute)
    if (replaced := by(used)) != used:
        setattr(holder, attribute, replaced)


def part_copies_soon() -> None:
    """Schedule `part_copies` if there are copies, from places where Blender forbids creating data."""
    if _copies() <= _left_by_undo:
        return
    # Blender forbids creating data while a window draws or renders.
    if bpy.app.background:
        part_copies()
    elif not bpy.app.timers.is_registered(part_copies):
        bpy.app.timers.register(part_copies)


@bpy.app.handlers.persistent
def _after_update(*_: object) -> None:
    part_copies_soon()


@bpy.app.handlers.persistent
def _after_load(*_: object) -> None:
    global _left_by_undo
    part_copies()
    has_step()
    _left_by_undo = frozenset()


@bpy.app.handlers.persistent
def _before_undo(*_: object) -> None:
    if _has_no_step:
        has_step()
        bpy.ops.ed.undo_push(message="Separate Documents")


@bpy.app.handlers.persistent
def _after_undo(*_: object) -> None:
    global _left_by_undo
    _left_by_undo = _copies()


_HANDLERS = (
    (bpy.app.handlers.depsgraph_update_post, _after_update),
    (bpy.app.handlers.load_post, _after_load),
    (bpy.app.handlers.undo_pre, _before_undo),
    (bpy.app.handlers.redo_pre, _before_undo),
    (bpy.app.handlers.undo_post, _after_undo),
    (bpy.app.handlers.redo_post, _after_undo),
)


def register() -> None:
    """Start to look for copies."""
    for handlers, each in _HANDLERS:
        handlers.append(each)


def unregister() -> None:
    """Stop looking for copies."""
    for handlers, each in _HANDLERS:
        handlers.remove(each)
    if bpy.app.timers.is_registered(part_copies):
        bpy.app.timers.unregister(part_copies)
