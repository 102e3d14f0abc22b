"""The files of Origami in the folder of a whole run: their names, and which of the files there are its own.

A run of every sheet has its results in subfolders, one for each sheet.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from .export.outputs import OTHER_LIGHT, OTHER_PAGE_FILES, OUTPUTS, names_of
from .files.content_hash import sha256_of
from .files.json_files import parsed_json
from .files.links import is_link
from .files.marker import REPORT, is_marked_with, owners
from .files.results_folder import keep_off_links, keep_off_others
from .scene.camera_object import VIEWS

LOG, WORK = "log.txt", "work"
RESULTS = tuple(names_of(each for each in OUTPUTS if each.in_run))
# Files for the user to edit and pass to the next run.
EDITABLE = tuple(names_of(each for each in OUTPUTS if each.editable))
FILES = (REPORT, *RESULTS, LOG)
FOLDERS = (WORK, VIEWS)
# Folders with the results of one sheet each.
_SHEET_FOLDER = re.compile(r"sheet-[1-9]\d*")
# The names that `camera_object.py` gives to the pictures behind its cameras.
_CAMERA_PHOTO = re.compile(r"\d{2,}_.*\.jpg")


def sheet_folder(number: int) -> str:
    """The subfolder for a sheet's results."""
    return f"sheet-{number}"


def sheet_folders(folder: Path) -> list[str]:
    """Everything with the name of a sheet's folder, in the order of the sheets."""
    there = [path.name for path in folder.iterdir()] if folder.is_dir() else []
    return sorted(filter(_SHEET_FOLDER.fullmatch, there), key=lambda name: (len(name), name))


def other_light_files(names: Sequence[str]) -> list[str]:
    """The files of the pages of other photos, which have these names."""
    return [f"{OTHER_LIGHT}/{name}{ending}" for name in names for ending in OTHER_PAGE_FILES]


def results_in(folder: Path) -> list[str]:
    """The results of one page in a folder, by name, except the report."""
    pictures = [path.name for path in sorted((folder / VIEWS).glob("*.jpg")) if _CAMERA_PHOTO.fullmatch(path.name)]
    return [name for name in RESULTS if (folder / name).exists()] + [f"{VIEWS}/{name}" for name in pictures]


def other_pages_in(folder: Path) -> list[str]:
    """The pages of other photos in a folder, by name."""
    paths = sorted((folder / OTHER_LIGHT).glob("*"))
    return [f"{OTHER_LIGHT}/{path.name}" for path in paths if path.suffix in OTHER_PAGE_FILES]


def results_of_sheets(folder: Path) -> list[str]:
    """The results in a folder's sheet folders, each sheet's report after its files."""
    found = []
    for sheet in sheet_folders(folder):
        inside = results_in(folder / sheet) + [REPORT] * (folder / sheet / REPORT).exists()
        found += [f"{sheet}/{name}" for name in inside]
    return found


def named_by_report(out: Path) -> set[str]:
    """The files of the run whose report is in the folder; empty if the report is not Origami's."""
    outputs = outputs_of_report(out)
    if outputs is None:
        return set()
    folders = {parent.as_posix() for name in outputs for parent in PurePosixPath(name).parents}
    return {REPORT, LOG, WORK, VIEWS, *outputs, *folders}


def outputs_of_report(out: Path) -> dict[str, dict[str, Any]] | None:
    """The results that the report in the folder names; None if there is no report of Origami's."""
    try:
        content = parsed_json(out / REPORT)
        if "origami" not in content["versions"]:
            return None
        outputs = {str(name): dict(entry) for name, entry in content.get("outputs", {}).items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    number = content.get("number")
    marked = is_marked_with(out, number) if number else True
    if marked is None:  # the marker was deleted, or the report was copied here alone
        marked = all(not (out / name).exists() or is_as_reported(out / name, entry) for name, entry in outputs.items())
    return outputs if marked else None


def is_as_reported(path: Path, entry: Mapping[str, Any]) -> bool:
    """Whether a file has the content that a report states.

    Raises
    ------
    OSError
    """
    return path.stat().st_size == entry["bytes"] and sha256_of(path) == entry["sha256"]


def own_results(out: Path) -> list[str]:
    """The results in the folder that a run of the command line wrote, with the reports of its sheets."""
    written = written_by_a_run(out)
    found = results_in(out) + [name for name in other_pages_in(out) if name in written]
    for sheet in own_sheets(out):
        known = written_by_a_run(out / sheet)
        names = [name for name in (*results_in(out / sheet), REPORT) if PurePosixPath(name).parts[0] in known]
        found += [f"{sheet}/{name}" for name in names if (out / sheet / name).exists()]
    return found


def own_sheets(out: Path) -> list[str]:
    """The sheets' folders that a run made; other folders may have these names too, or have replaced them."""
    known = written_by_a_run(out)
    return [name for name in sheet_folders(out) if name in known and (out / name).is_dir() and not is_link(out / name)]


def written_by_a_run(folder: Path) -> set[str]:
    """The names in a folder that a run of the command line wrote."""
    listed = owners(folder, FILES + FOLDERS) or {}
    return named_by_report(folder) | {name for name, document in listed.items() if document == ""}


def keep_off_others_in(out: Path, sheets: Sequence[str] = ()) -> None:
    """Refuse to replace the user's files with the results of a run, or of its sheets in these folders.

    Raises
    ------
    UsageError
    """
    names, folders = (*FILES, *FOLDERS, *sheets), (*FOLDERS, *sheets)
    keep_off_others(out, names, known=named_by_report(out), folders=folders)
    keep_off_links(out / WORK)
    for sheet in sheets:
        inside = out / sheet
        keep_off_others(inside, (REPORT, *RESULTS, VIEWS), known=named_by_report(inside), folders=[VIEWS])
