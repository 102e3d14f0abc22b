"""The creases in the panel's list and the overlay, read from the scene after each change and then cached."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy

from ..scene.document import Document
from ..scene.edits import changes
from ..scene.modes import in_edit_mode
from ..scene.ridge_group import Creases, fold_angles, read_creases
from ..scene.roles import SHEET
from .stage_text import crease_text


@dataclass(frozen=True)
class ListedCrease:
    """A crease with which the sheet was built, as the panel shows it.

    Attributes
    ----------
    number : int
        From 0, as for `origami.drop_crease`.
    text : str
    there : bool
        Whether it is still in the sheet's vertex group.
    """

    number: int
    text: str
    there: bool


_key: tuple[Any, ...] = ()
_creases = Creases({}, ())


def creases_of(document: Document, sheet_object: bpy.types.Object) -> Creases | None:
    """The creases in a document's sheet now; None if they cannot be read: in Edit Mode, or if it is not a mesh."""
    global _key, _creases
    if sheet_object.type != "MESH" or in_edit_mode(sheet_object):
        return None
    key = document.name, changes(SHEET), document.collection.origami.surface.figures, sheet_object.session_uid
    if key != _key:
        _creases = read_creases(sheet_object)
        _key = key
    return _creases


def listed_creases(document: Document) -> list[ListedCrease]:
    """Each crease with which the document's sheet was built, including those erased since then."""
    sheet_object = document.object(SHEET)
    if sheet_object is None:
        return []
    now, angles = creases_of(document, sheet_object), fold_angles(sheet_object)
    erased = set() if now is None else angles.keys() - now.known.keys()
    return [
        ListedCrease(number, "erased" if number in erased else crease_text(angle), number not in erased)
        for number, angle in angles.items()
    ]


def forget() -> None:
    """Read the creases again next time."""
    global _key
    _key = ()
