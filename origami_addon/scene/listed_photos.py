"""A document's list of photos: what is added to it, and the names in it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence, Sized
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...core.sparse_model import SparseModel
from ..files.photo_files import short_names
from .document import Document

PLACED, LOST = "placed", "could not be placed"  # notes of photos


def counted(files: Sized) -> str:
    """How many photos or movies a list has, for the user."""
    return f"{len(files)} file" + "s" * (len(files) != 1)


def list_photos(document: Document, photos: Sequence[Path]) -> None:
    """Add photos to a document's list, except those that it has already, by whatever path."""
    group = document.collection.origami
    known = {os.path.realpath(bpy.path.abspath(photo.path)) for photo in group.photos}
    for path in photos:
        if (file := os.path.realpath(path)) not in known:
            known.add(file)
            added = group.photos.add()
            added.path = str(path)
    give_unique_names(group)


def list_movie_photos(
    document: Document, used: Sequence[str], photos_of: Mapping[str, Sequence[str]]
) -> tuple[str, ...]:
    """Put the photos that were taken from movies in the place of these in a document's list.

    Parameters
    ----------
    document : Document
    used : sequence of str
        The files that a run used, movies among them.
    photos_of : mapping of str to sequence of str
        The photos of each movie.

    Returns
    -------
    tuple of str
        The files used, with the photos in the place of each movie.
    """
    group = document.collection.origami
    for movie, photos in photos_of.items():
        at = next((index for index, photo in enumerate(group.photos) if bpy.path.abspath(photo.path) == movie), None)
        if at is None:
            continue
        group.photos.remove(at)
        for place, path in enumerate(photos, at):
            added = group.photos.add()
            added.path = path
            group.photos.move(len(group.photos) - 1, place)
    if photos_of:
        give_unique_names(group)
    return tuple(photo for path in used for photo in photos_of.get(path, [path]))


def note_photos(document: Document, model: SparseModel, sharpness: Mapping[str, float]) -> None:
    """Note for each photo of a document's list whether and how well it was placed, and how sharp it is.

    Parameters
    ----------
    document : Document
    model : SparseModel
    sharpness : mapping of str to float
        Of the photos by the names of their cameras, as `image.sharpness` gives it.
    """
    count = np.bincount(model.observed_camera, minlength=len(model.cameras))
    total = np.bincount(model.observed_camera, model.reprojection_errors(), len(model.cameras))
    for photo in document.collection.origami.photos:
        path = Path(bpy.path.abspath(photo.path))
        camera = next((n for n, each in enumerate(model.cameras) if is_named(path, each.name)), None)
        if camera is None:
            photo.note = LOST if photo.use else ""
            photo.points, photo.error, photo.sharpness = 0, 0.0, 0.0
            continue
        photo.note, photo.points = PLACED, int(count[camera])
        photo.error = float(total[camera] / max(count[camera], 1))
        photo.sharpness = sharpness.get(model.cameras[camera].name, 0.0)


def is_named(path: Path, name: str) -> bool:
    """Whether a photo's name in its document is that of a file; it includes as many folders as make it unique."""
    return path.parts[-len(Path(name).parts) :] == Path(name).parts


def give_unique_names(group: Any) -> None:
    """Give the photos unique names; the reference photo stays the same, whether chosen or not."""
    names = short_names([Path(bpy.path.abspath(photo.path)) for photo in group.photos])
    reference = group.settings.reference
    if reference:  # a photo just added has no name yet and cannot be the reference
        known = {photo.name: name for photo, name in zip(group.photos, names)}
        group.settings.reference = known.get(reference, reference)
    for photo, name in zip(group.photos, names):
        photo.name = name
