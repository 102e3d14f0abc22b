"""The folded sheet as a document in the open Blender file."""

from __future__ import annotations

from pathlib import Path

from folded import Folded
from origami.origami_addon.files.image_files import write_jpeg
from origami.origami_addon.scene.camera_object import VIEWS, write_views
from origami.origami_addon.scene.document import Document
from origami.origami_addon.scene.show import Pictures
from origami.origami_addon.scene.whole_document import build_document


def pictures_of(case: Folded, folder: Path, *, pack: bool = False) -> Pictures:
    """The pictures of a document, as files in a folder; both photos and the page are one file."""
    folder.mkdir(exist_ok=True)
    page = folder / "page.jpg"
    write_jpeg(page, case.photos[0], 100)
    views = list(write_views(folder / VIEWS, case.model.cameras, case.photos.__getitem__))
    return Pictures(views, [page] * 2, pack)


def folded_document(name: str, case: Folded, folder: Path, *, pack: bool = False) -> Document:
    """A new document whose pictures lie in a folder, or are packed into the .blend."""
    pictures = pictures_of(case, folder, pack=pack)
    return build_document(name, case.state, pictures, pictures.photos[0])
