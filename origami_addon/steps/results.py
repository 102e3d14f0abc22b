"""Write the results of a run: the page and all other files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ...core.watch import SILENT, Watch
from ..export.output import Finished
from ..export.outputs import OUTPUTS, PICTURE, sheet_with_page, write_outputs
from ..files.image_files import Bits
from ..files.links import real
from ..files.photo_pixels import JudgedPixels, PhotoPixels
from ..files.photos import Photo
from ..one_line import printable
from ..scene.camera_object import VIEWS, write_views
from ..scene.document import Document
from ..scene.document_group import fill_group
from ..scene.roles import SHEET
from ..scene.show import Pictures
from ..scene.whole_document import build_document
from ..state import Paged
from .work import Work


def finished(photos: Sequence[Photo], state: Paged, folder: Path, bits: Bits | None = None) -> Finished:
    """Everything that files are made from; models are made without a document, with their picture in ``folder``."""
    reference, pixels = state.region.reference, PhotoPixels(photos, state.model)
    return Finished(
        state,
        photo=lambda: pixels[reference],
        profile=pixels.photos[reference].icc_profile,
        bits=bits,
        make_object=lambda done: sheet_with_page(done, folder),
        home=folder,
        title=document_name(photos),
    )


def write_results(state: Paged, work: Work, out: Path, home: Path, watch: Watch = SILENT) -> None:
    """Write all files of a whole run, except its report, into ``out``, from where they will move to ``home``.

    Raises
    ------
    StepFailed
    """
    done = replace(
        finished(work.photos, state, home), make_object=lambda _: _document(state, work, out.resolve()).object(SHEET)
    )
    outputs = [each for each in OUTPUTS if each.in_run and each.asked_for(work.settings)]
    write_outputs(outputs, out, done, work.report, watch)


def _document(state: Paged, work: Work, folder: Path) -> Document:
    """Put the document into Blender, and its pictures into the folder that already has the page's."""
    pixels = JudgedPixels(work.photos, state.model)
    views = list(write_views(folder / VIEWS, state.model.cameras, pixels.__getitem__))
    pictures = Pictures(views, [photo.path.resolve() for photo in pixels.photos], pack=False)
    document = build_document(document_name(work.photos), state, pictures, folder / PICTURE)
    fill_group(document, work.photos, work.settings, work.report, pixels.sharpness)
    return document


def document_name(photos: Sequence[Photo]) -> str:
    """The name of the document of photos: that of the innermost folder with all of them."""
    folders = [real(photo.path).parent for photo in photos]
    outward = (folders[0], *folders[0].parents)
    shared = (each for each in outward if all(folder.is_relative_to(each) for folder in folders))
    return printable(next(shared, folders[0]).name) or "document"
