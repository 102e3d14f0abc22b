"""The command `handover`: a METS workspace with the page, its text as PAGE XML, and the dewarping grid of a photo."""

from __future__ import annotations

import argparse
import mimetypes
import shutil
import uuid
from collections.abc import Sequence
from pathlib import Path

from ...core.errors import UsageError
from ...origami_addon.files.content_hash import sha256_of
from ...origami_addon.files.json_files import parsed_json
from . import dewarping, page_xml, text
from .command import exit_code_of
from .delivered import delivering
from .finished_run import FinishedRun, InputPhoto, finished_run
from .hocr import Block, read_hocr
from .mets import WorkspaceFile, id_in, write_mets
from .page_in_photos import PageInPhotos, page_in_photos
from .pictures import opened, written

FOLDER, METS = "handover", "mets.xml"
# The file groups. The first three have the names that OCR-D gives them; for the others it has none.
IMAGE, WITH_TEXT, WITHOUT_TEXT = "OCR-D-IMG", "OCR-D-OCR-TESS", "OCR-D-SEG-PAGE"
PHOTO, GRID = "PHOTO", "DEWARPING"
_TIFF = "image/tiff"


def main(argv: Sequence[str]) -> int:
    """Run with the given arguments and return the exit code; never raises."""
    return exit_code_of(lambda: _handover(argv))


def _handover(argv: Sequence[str]) -> None:
    parser = argparse.ArgumentParser(
        prog="handover.py",
        description="Write DOCUMENT/handover: a METS workspace for OCR-D and Kitodo with the finished page, PAGE XML "
        "with its text if text.py has recognized it, and the dewarping grid of the reference photo.",
        allow_abbrev=False,
    )
    parser.add_argument("document", metavar="DOCUMENT", type=Path, help="the folder of a finished run of rectify.py")
    write_handover(finished_run(parser.parse_args(argv).document))


def write_handover(run: FinishedRun) -> None:
    """Write the folder ``handover`` of a document.

    Raises
    ------
    UsageError, StepFailed
    """
    page = page_in_photos(run)
    image, photo = run.file("page.tif"), _reference_photo(run)
    blocks = _recognized(run, page)
    with delivering(run.folder / FOLDER, METS) as new:
        picture = _file(new, IMAGE, ".tif", _TIFF)
        shutil.copyfile(image, new / picture.path)
        described = _file(new, WITHOUT_TEXT if blocks is None else WITH_TEXT, ".xml", page_xml.MEDIA_TYPE)
        page_xml.write_page_xml(
            new / described.path, blocks or [], picture.path, page.size_px, id=id_in(described.group)
        )
        files = [picture, described, *_write_grid(new, run, page, photo)]
        number = run.report.get("number", "")
        identifier = uuid.UUID(number).urn if _is_number(number) else uuid.uuid4().urn
        write_mets(new / METS, identifier, run.title, files)


def _reference_photo(run: FinishedRun) -> InputPhoto:
    """The reference photo, which must still be as the run read it.

    Raises
    ------
    UsageError
    """
    photo = run.photos.get(str(run.figure("reference")))
    if photo is None:
        raise UsageError(f"The report in {run.folder} names no reference photo; run rectify.py again with --force.")
    if not photo.path.is_file() or sha256_of(photo.path) != photo.sha256:
        raise UsageError(
            f"The reference photo {photo.path} is no longer the one that the run read; put it back, or run rectify.py "
            "again with the photos where they are now."
        )
    return photo


def _recognized(run: FinishedRun, page: PageInPhotos) -> list[Block] | None:
    """The text that `text` has recognized on this page; None if it has not.

    Raises
    ------
    UsageError
        If it was recognized on an earlier page.
    """
    folder = run.folder / text.FOLDER
    if not (folder / text.PDF).is_file():
        return None
    try:
        of_page = parsed_json(folder / text.FIGURES)["of_page"]
    except (OSError, ValueError, KeyError, TypeError):
        of_page = None
    if of_page != run.hash_of("page.pdf"):
        raise UsageError(f"The text in {folder} is that of an earlier page; run text.py on {run.folder} again.")
    return read_hocr(folder / text.HOCR, page.size_px)


def _write_grid(new: Path, run: FinishedRun, page: PageInPhotos, photo: InputPhoto) -> list[WorkspaceFile]:
    """Write the photo, upright, and its grid.

    Raises
    ------
    StepFailed
    """
    view = page.view([camera.name for camera in page.cameras].index(photo.name))
    turns = dewarping.quarter_turns(view)
    if turns:
        picture = _file(new, PHOTO, ".tif", _TIFF)
        upright = opened(photo.path).rot(f"d{90 * turns}").copy()
        upright.remove("orientation")
        written(upright.tiffsave, str(new / picture.path), compression="deflate", predictor="horizontal")
    else:
        kind = mimetypes.guess_type(photo.path.name)[0] or "application/octet-stream"
        picture = _file(new, PHOTO, photo.path.suffix.lower(), kind)
        shutil.copyfile(photo.path, new / picture.path)
    grid = dewarping.dewarping_grid(view, turns)
    described = _file(new, GRID, ".xml", dewarping.MEDIA_TYPE)
    dewarping.write_dewarping_xml(
        new / described.path,
        grid,
        picture.path,
        f"The page in the photo {photo.name}: refLinePos are pixels of {IMAGE}, points those of {PHOTO}"
        + (f", which is turned by {90 * turns} degrees clockwise" if turns else "")
        + f". The grid covers {100 * grid.share:.1f} % of the page, as far as the photo shows it, and is nowhere "
        f"farther than {grid.largest_error:.2f} pixels from the map that Origami wrote.",
    )
    return [picture, described]


def _file(new: Path, group: str, ending: str, media_type: str) -> WorkspaceFile:
    """A file of the workspace, in the folder of its group, which is made."""
    (new / group).mkdir()
    return WorkspaceFile(group, f"{group}/{id_in(group)}{ending}", media_type)


def _is_number(number: str) -> bool:
    try:
        uuid.UUID(number)
    except ValueError:
        return False
    return True
