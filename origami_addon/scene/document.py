"""One document in a Blender file: a collection, its state, and its objects.

The collection keeps the arrays of the document's nouns as they were computed, in double precision; the user sees and
edits the objects. If an object differs from the arrays, the object counts (`read_back.py`).
"""

from __future__ import annotations

import hashlib
from functools import lru_cache

import bpy
import numpy as np

from ...core.arrays import Array
from ...core.errors import StepFailed
from ..state import Kind, State, from_bytes, reached, state_arrays, state_from_arrays, to_bytes
from .roles import ORIGIN

_MARK = "origami_document"  # of the collection and of everything made for it: the document's name
_ROLE = "origami_role"  # of an object: its role in its document
_STATE = "origami_state"  # of the collection: the arrays of its nouns
_UNPACKED = 2  # states that stay unpacked in memory, some megabytes each: that of the panels' document, and another
_FRAME = "origami_frame"  # of the collection: similarity from the sparse model to Blender, by rows


class Document:
    """A document, stored in its collection.

    Parameters
    ----------
    collection : bpy.types.Collection
        One that `new_document` made.
    """

    def __init__(self, collection: bpy.types.Collection) -> None:
        self.collection = collection

    @property
    def name(self) -> str:
        """The name with which everything in the document is marked."""
        return str(self.collection[_MARK])

    @property
    def title(self) -> str:
        """The name of its collection, which the user sees and may change."""
        return str(self.collection.name)

    @property
    def scene(self) -> bpy.types.Scene | None:
        """Its scene, which need not be the one in the window; None if it is in no scene."""
        shown = bpy.context.scene
        scenes = sorted(bpy.data.scenes, key=lambda each: each != shown)
        return next((each for each in scenes if self.collection in each.collection.children_recursive), None)

    def made(self, thing: bpy.types.ID) -> bool:
        """Whether an object, or data, was made for the document."""
        return bool(thing.get(_MARK) == self.name)

    def rename(self, name: str) -> None:
        """Take another name; only the collection may be marked with the old one."""
        self.collection[_MARK] = name

    @property
    def state(self) -> State:
        """The document's state as it was computed."""
        content = self.collection.get(_STATE)
        return State() if content is None else _unpacked(bytes(content))

    @state.setter
    def state(self, state: State) -> None:
        self.keep(to_bytes(state_arrays(state)))

    def reached(self, kind: type[Kind]) -> Kind:
        """The document's state as a given kind; raises UsageError if less is known."""
        return reached(self.state, kind)

    def keep(self, content: bytes) -> None:
        """Keep a state that `to_bytes` has packed already."""
        # Blender cuts bytes at the first zero where it writes over others.
        self.collection.pop(_STATE, None)
        self.collection[_STATE] = content

    def state_digest(self) -> str:
        """A short text that changes whenever the kept state does."""
        return hashlib.blake2b(bytes(self.collection.get(_STATE, b"")), digest_size=8).hexdigest()

    @property
    def frame(self) -> Array:
        """Similarity (4, 4) from the sparse model's frame to Blender's, in metres."""
        return np.array(self.collection.get(_FRAME, np.eye(4).ravel())).reshape(4, 4)

    @frame.setter
    def frame(self, frame: Array) -> None:
        self.collection[_FRAME] = [float(value) for value in frame.ravel()]

    def objects(self, role: str) -> list[bpy.types.Object]:
        """The document's objects with ``role``, sorted by name."""
        mine = filter(self.made, self.collection.all_objects)
        return sorted((each for each in mine if each.get(_ROLE) == role), key=lambda each: each.name)

    def object(self, role: str) -> bpy.types.Object | None:
        """The document's only object with ``role``, or None."""
        return next(iter(self.objects(role)), None)

    def add(self, made: bpy.types.Object, role: str) -> None:
        """Add a new object to the document; the document's origin, if it has one, moves it."""
        made.parent = self.object(ORIGIN)
        made[_ROLE] = role
        self.collection.objects.link(made)
        self.own(made, made.data)

    def own(self, *made: bpy.types.ID | None) -> None:
        """Mark data made for the document, which are removed with it."""
        for each in made:
            if each is not None:
                each[_MARK] = self.name

    def remove(self, role: str) -> None:
        """Remove the objects with ``role``, and the data that only they use."""
        for each in self.objects(role):
            self.remove_object(each)

    def remove_object(self, each: bpy.types.Object) -> None:
        """Remove one of its objects, and the data that only this one uses."""
        bpy.data.objects.remove(each)
        _remove_unused(self.name)


@lru_cache(maxsize=_UNPACKED)
def _unpacked(content: bytes) -> State:
    """A packed state; unpacking takes hundredths of a second, and whatever looks for edits asks for it."""
    return state_from_arrays(from_bytes(content))


def new_document(name: str, scene: bpy.types.Scene) -> Document:
    """An empty document in the scene; its name gets a number if it is taken."""
    free = free_name(name)
    collection = bpy.data.collections.new(free)
    collection[_MARK] = free
    scene.collection.children.link(collection)
    return Document(collection)


def free_name(name: str) -> str:
    """The name, with a number if the file already has a document of that name."""
    taken = {document.name for document in documents()}
    number, free = 1, name
    while free in taken:
        number, free = number + 1, f"{name}.{number:03d}"
    return free


def documents() -> list[Document]:
    """All documents of the file, except those linked from another file."""
    return [Document(each) for each in bpy.data.collections if _MARK in each and each.library is None]


def some_are_linked() -> bool:
    """Whether the file shows documents of other files, which cannot be changed here."""
    return any(_MARK in each and each.library is not None for each in bpy.data.collections)


def document_of(thing: bpy.types.ID | None) -> Document | None:
    """The document of a collection, or of an object made for it; None if there is none."""
    name = None if thing is None or thing.library is not None else thing.get(_MARK)
    return next((document for document in documents() if document.name == name), None)


def role_of(made: bpy.types.Object) -> str:
    """The role of an object made for a document."""
    return str(made[_ROLE])


def same_part(one: bpy.types.Object, other: bpy.types.Object) -> bool:
    """Whether two objects are the same part of their documents: of two cameras, those of the same photo."""
    return all(one.get(key) == other.get(key) for key in (_ROLE, "photo"))


def find_document(name: str) -> Document:
    """The document called ``name``.

    Raises
    ------
    StepFailed
        If the file has none.
    """
    for document in documents():
        if document.name == name:
            return document
    raise StepFailed(f"This .blend holds no document {name!r}: rectify its photos first.")


def remove_document(name: str) -> None:
    """Remove the document's collection and everything made for it.

    Other objects in the collection are the user's and move to its scene; data used elsewhere stay.
    """
    for document in [each for each in documents() if each.name == name]:
        collection, top = document.collection, (document.scene or bpy.context.scene).collection
        for inside in list(collection.objects):
            if inside.get(_MARK) == name:
                bpy.data.objects.remove(inside)
            elif inside.users_collection == (collection,):
                top.objects.link(inside)
        for inside in list(collection.children):
            if inside.name not in top.children:
                top.children.link(inside)
        bpy.data.collections.remove(collection)
    _remove_unused(name)


def _remove_unused(name: str) -> None:
    # Users before what they use: materials and cameras before their images.
    for kind in (bpy.data.meshes, bpy.data.curves, bpy.data.cameras, bpy.data.materials, bpy.data.images):
        for data in [each for each in kind if each.get(_MARK) == name and each.users == 0]:
            kind.remove(data)
