"""The folder of a whole run: what it may contain, and how new results replace those of an earlier run.

The results of a finished run stay until the next run has written all of its own. Those are written into a separate
folder, the report last. Then the earlier report is deleted, the files are put in place one by one, and the new report
comes last. A run that was stopped in between finds its results complete and puts them in place when it is started
again. A first run does the same, so nothing unfinished ever lies among the user's files.

A run of every sheet has its results in subfolders, one for each sheet. All of them are replaced together, and the
report of the whole run still comes last. Sheets of an earlier run that are not replaced are deleted with its report, so
no page of an earlier run can pass for one of this run.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import tempfile
from collections.abc import Container, Mapping, Sequence
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import Any

from ..core.errors import StepFailed, UsageError
from .export.outputs import OTHER_LIGHT, OTHER_PAGE_FILES, OUTPUTS, names_of
from .files.atomic import WRITING, sync_folder, write_text_at_once
from .files.content_hash import sha256_of
from .files.json_files import parsed_json
from .files.kept import KEPT_FILE
from .files.results_folder import (
    LOCK,
    MARKER,
    NUMBER,
    REPORT,
    claim,
    is_link,
    is_marked_with,
    keep_off_inputs,
    keep_off_links,
    keep_off_others,
    number_of,
    owners,
    real,
    release,
    unshared_file,
)
from .one_line import is_text
from .scene.camera_object import VIEWS

LOG, WORK = "log.txt", "work"
# The report of a run that stopped after a stage, as asked; it is there only if that was the last run to end well.
STOPPED = f"{WORK}/stopped.json"
RESULTS = tuple(names_of(each for each in OUTPUTS if each.in_run))
# Files for the user to edit and pass to the next run.
_EDITABLE = tuple(names_of(each for each in OUTPUTS if each.editable))
_FILES = (REPORT, *RESULTS, LOG)
_FOLDERS = (WORK, VIEWS)
# In the work folder: complete results that wait to be put in place, and the kept results of a run that recomputes
# everything.
_STAGED, _RECOMPUTED = "results", "anew"
# In the work folder: the photos taken from movies.
_MOVIES = "movies"
# What the steps keep in the work folder beside files of `files/kept.py`.
_KEPT_FOLDERS = ("sfm", "on_page")
# Folders with the results of one sheet each.
_SHEET_FOLDER = re.compile(r"sheet-[1-9]\d*")
# The names that `camera_object.py` gives to the pictures behind its cameras.
_CAMERA_PHOTO = re.compile(r"\d{2,}_.*\.jpg")


def sheet_folder(number: int) -> str:
    """The subfolder for a sheet's results."""
    return f"sheet-{number}"


def keep_off_photos(paths: Sequence[Path], out: Path, *, sheets: bool) -> None:
    """Refuse the photos' own folder: a page among the photos would become a photo of the next run.

    With ``sheets``, results also go into the sheets' folders.

    Raises
    ------
    UsageError
    """
    places = [out, *(out / name for name in _sheet_folders(out) if sheets)]
    for path in paths:
        folder = real(path if path.is_dir() else path.parent)
        if any(folder == real(place) for place in places):
            raise UsageError(f"{folder} is the folder of the photos; choose another folder for the results.")


def _sheet_folders(folder: Path) -> list[str]:
    """Everything with the name of a sheet's folder, in the order of the sheets."""
    there = [path.name for path in folder.iterdir()] if folder.is_dir() else []
    return sorted(filter(_SHEET_FOLDER.fullmatch, there), key=lambda name: (len(name), name))


def keep_off_what_is_read(inputs: Sequence[Path], out: Path) -> None:
    """Refuse inputs in places that the results would replace.

    Origami's own report, outline and creases are allowed: they are read before they are replaced.

    Raises
    ------
    UsageError
    """
    taken = [VIEWS, OTHER_LIGHT, *(name for name in RESULTS if name not in _EDITABLE)]
    names = [*taken, WORK, LOG, MARKER, LOCK, *(f"{sheet}/{name}" for sheet in _sheet_folders(out) for name in taken)]
    if not _named_by_report(out):
        names.append(REPORT)
    keep_off_inputs(inputs, out, names)


def check_folder(out: Path, *, resume: bool, force: bool, read: Sequence[Path] = (), sheets: bool = False) -> None:
    """Check that results can be written into the folder without losing anything; nothing is written yet.

    ``read`` are the files of the settings; with ``sheets``, results go into the sheets' folders.

    Raises
    ------
    UsageError
        If the folder is a file; if it holds the user's own files or links with the names of results; if it holds
        results and neither ``resume`` nor ``force`` is given; or if it holds an edited outline or edited creases that
        are not among the files read.
    """
    if os.path.lexists(out) and not out.is_dir():
        raise UsageError(f"{out} is not a folder; choose another folder for the results.")
    if not is_text(out.absolute()):
        raise UsageError(
            f"The name of {out} is no text in this system's encoding (UTF-8), and Blender cannot write there; choose "
            "another folder for the results."
        )
    if sheets:
        keep_off_sheets(out, 1)  # the number is not known yet
    _keep_off_others(out)
    if (out / REPORT).exists() and not (resume or force or _is_exchanging(out)):
        raise UsageError(
            f"{out} holds a finished run; add --resume to keep what is unchanged, or --force to recompute "
            "everything, or choose another folder."
        )
    _keep_off_edited(out, read)


def make_folder(out: Path) -> None:
    """Make the folder and write something there, to see whether that is possible.

    Raises
    ------
    OSError
    """
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=out) as probe:
        probe.write(bytes(4096))


def open_folder(out: Path) -> None:
    """Claim a folder that was checked and locked, and finish an interrupted replacement.

    Raises
    ------
    OSError
    UsageError, StepFailed
        If the results of the interrupted replacement cannot be put in place.
    """
    claim(out, [WORK, LOG, *(name for name in _FILES + _FOLDERS if (out / name).exists())])
    (out / WORK).mkdir(exist_ok=True)
    write_text_at_once(out / NUMBER, json.dumps({"number": number_of(out)}) + "\n")
    _unshare(out / WORK)
    if _is_exchanging(out):
        put_in_place(out)
    shutil.rmtree(out / WORK / _STAGED, ignore_errors=True)
    for unfinished in (out / WORK).rglob(f"{WRITING}*"):
        shutil.rmtree(unfinished, ignore_errors=True)


def _is_exchanging(out: Path) -> bool:
    return (out / WORK / _STAGED / REPORT).is_file()


def _unshare(work: Path) -> None:
    """Give the kept files content of their own, because databases are written in place; a backup may be hard links."""
    for path in work.rglob("*"):
        if path.is_file():
            unshared_file(path)


def keep_off_sheets(out: Path, count: int) -> None:
    """Refuse to replace the user's files with the results of ``count`` sheets.

    Raises
    ------
    UsageError
    """
    _keep_off_others(out, [sheet_folder(number) for number in range(1, count + 1)])


def keep_off_other_light(out: Path, names: Sequence[str]) -> None:
    """Refuse to replace the user's files with the pages of other photos, which have these names.

    Raises
    ------
    UsageError
    """
    keep_off_others(out, [OTHER_LIGHT], known=[OTHER_LIGHT], folders=[OTHER_LIGHT])
    keep_off_others(out, other_light_files(names), known=_named_by_report(out))


def other_light_files(names: Sequence[str]) -> list[str]:
    """The files of the pages of other photos, which have these names."""
    return [f"{OTHER_LIGHT}/{name}{ending}" for name in names for ending in OTHER_PAGE_FILES]


def _keep_off_others(out: Path, sheets: Sequence[str] = ()) -> None:
    names, folders = (*_FILES, *_FOLDERS, *sheets), (*_FOLDERS, *sheets)
    keep_off_others(out, names, known=_named_by_report(out), folders=folders)
    keep_off_links(out / WORK)
    for sheet in sheets:
        inside = out / sheet
        keep_off_others(inside, (REPORT, *RESULTS, VIEWS), known=_named_by_report(inside), folders=[VIEWS])


def _keep_off_edited(out: Path, read: Sequence[Path]) -> None:
    """Refuse to replace an outline or creases that the user has edited since the run wrote them."""
    outputs = _outputs_of_report(out) or {}
    given = {real(path) for path in read}
    for name, entry in outputs.items():
        path = out / name
        if path.name not in _EDITABLE or not path.exists() or real(path) in given:
            continue
        if sha256_of(path) != entry.get("sha256"):
            number = "" if path.parent == out else f"{path.parent.name.replace('sheet-', '--sheet ')} and "
            raise UsageError(
                f"{path} was changed since it was written and would be replaced; pass it in with "
                f"{number}--{path.stem}, or move it elsewhere."
            )


def _named_by_report(out: Path) -> set[str]:
    """The files of the run whose report is in the folder; empty if the report is not Origami's."""
    outputs = _outputs_of_report(out)
    if outputs is None:
        return set()
    folders = {parent.as_posix() for name in outputs for parent in PurePosixPath(name).parents}
    return {REPORT, LOG, WORK, VIEWS, *outputs, *folders}


def _outputs_of_report(out: Path) -> dict[str, dict[str, Any]] | None:
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


def work_folder_of(out: Path, *, recompute: bool) -> Path:
    """The folder for kept results; an empty one to recompute everything.

    The next run that may continue an interrupted one takes over its results.
    """
    work, other = out / WORK, out / WORK / _RECOMPUTED
    if recompute:
        shutil.rmtree(other, ignore_errors=True)
        other.mkdir(exist_ok=True)
        return other
    if other.is_dir():
        _move_into(other, work)
    return work


def movies_folder_of(out: Path) -> Path:
    """The folder for the photos taken from movies; they stay where they are if everything is recomputed."""
    return out / WORK / _MOVIES


def keep_only_recomputed(out: Path) -> None:
    """Delete the kept results of earlier runs, after a run that recomputed everything; other files stay."""
    for path in (out / WORK).iterdir():
        if path.name in _KEPT_FOLDERS:
            shutil.rmtree(path)
        elif KEPT_FILE.fullmatch(path.name):
            path.unlink()
    _move_into(out / WORK / _RECOMPUTED, out / WORK)


def _move_into(source: Path, target: Path) -> None:
    """Move a folder's content into another one, merging folders of the same name, and remove it."""
    for path in list(source.iterdir()):
        there = target / path.name
        if path.is_dir() and there.is_dir():
            _move_into(path, there)
        else:
            os.replace(path, there)
    source.rmdir()


def place_for_results(out: Path) -> Path:
    """A new folder for the results, until all are written."""
    staged = out / WORK / _STAGED
    staged.mkdir()
    return staged


def results_in(folder: Path) -> list[str]:
    """The results of one page in a folder, by name, except the report."""
    pictures = [path.name for path in sorted((folder / VIEWS).glob("*.jpg")) if _CAMERA_PHOTO.fullmatch(path.name)]
    return [name for name in RESULTS if (folder / name).exists()] + [f"{VIEWS}/{name}" for name in pictures]


def _other_pages_in(folder: Path) -> list[str]:
    paths = sorted((folder / OTHER_LIGHT).glob("*"))
    return [f"{OTHER_LIGHT}/{path.name}" for path in paths if path.suffix in OTHER_PAGE_FILES]


def results_of_sheets(folder: Path) -> list[str]:
    """The results in a folder's sheet folders, each sheet's report after its files."""
    found = []
    for sheet in _sheet_folders(folder):
        inside = results_in(folder / sheet) + [REPORT] * (folder / sheet / REPORT).exists()
        found += [f"{sheet}/{name}" for name in inside]
    return found


def put_in_place(out: Path) -> None:
    """Replace the earlier results with complete new ones; calling this again continues with the rest.

    Raises
    ------
    StepFailed
        If a file is in use.
    UsageError
        If the user has meanwhile put something with that name there.
    """
    staged = out / WORK / _STAGED
    outputs = parsed_json(staged / REPORT)["outputs"]
    others = _other_pages_in(staged)
    waiting = results_in(staged) + others + results_of_sheets(staged)
    sheets = [sheet for sheet in _sheet_folders(staged) if any(name.startswith(f"{sheet}/") for name in waiting)]
    _keep_off_others(out, sheets)
    claim(out, [REPORT, *(name for name in RESULTS if name in waiting), VIEWS, *sheets, *others])
    for sheet in sheets:
        (out / sheet).mkdir(exist_ok=True)
        claim(out / sheet, (REPORT, *RESULTS, VIEWS))
    try:
        (out / REPORT).unlink(missing_ok=True)
        # Reports first: a sheet with a report is complete.
        for name in sorted(_own_results(out), key=lambda name: Path(name).name != REPORT):
            if name not in outputs or (name in waiting and Path(name).name == REPORT):
                (out / name).unlink(missing_ok=True)
        _leave_other_light(out, outputs)
        _leave_sheets(out, [sheet for sheet in _own_sheets(out) if not any(n.startswith(f"{sheet}/") for n in outputs)])
        sync_folder(out)
        for name in waiting:
            (out / name).parent.mkdir(exist_ok=True)
            os.replace(staged / name, out / name)
        for folder in {(out / name).parent for name in waiting}:
            sync_folder(folder)
        os.replace(staged / REPORT, out / REPORT)
        sync_folder(out)
    except OSError as error:
        raise StepFailed(
            f"{error.filename2 or error.filename} could not be replaced ({error.strerror}): close the programs that "
            "have it open and run again; the new results are complete and will then be put in place."
        ) from error
    shutil.rmtree(staged)


def _own_results(out: Path) -> list[str]:
    """The results in the folder that a run of the command line wrote, with the reports of its sheets."""
    written = _written_by_a_run(out)
    found = results_in(out) + [name for name in _other_pages_in(out) if name in written]
    for sheet in _own_sheets(out):
        known = _written_by_a_run(out / sheet)
        names = [name for name in (*results_in(out / sheet), REPORT) if PurePosixPath(name).parts[0] in known]
        found += [f"{sheet}/{name}" for name in names if (out / sheet / name).exists()]
    return found


def _own_sheets(out: Path) -> list[str]:
    """The sheets' folders that a run made; other folders may have these names too, or have replaced them."""
    known = _written_by_a_run(out)
    return [name for name in _sheet_folders(out) if name in known and (out / name).is_dir() and not is_link(out / name)]


def _written_by_a_run(folder: Path) -> set[str]:
    listed = owners(folder, _FILES + _FOLDERS) or {}
    return _named_by_report(folder) | {name for name, document in listed.items() if document == ""}


def _leave_other_light(out: Path, outputs: Container[str]) -> None:
    """Release the pages of other photos that are no longer results."""
    gone = [name for name in _written_by_a_run(out) if name.startswith(f"{OTHER_LIGHT}/") and name not in outputs]
    release(out, gone)
    with suppress(OSError):
        (out / OTHER_LIGHT).rmdir()


def _leave_sheets(out: Path, sheets: Sequence[str]) -> None:
    """Release sheets' folders that no longer hold results; other files in them stay."""
    for sheet in sheets:
        with suppress(OSError):
            (out / sheet / VIEWS).rmdir()
        release(out / sheet, (REPORT, *RESULTS, VIEWS))
        with suppress(OSError):
            (out / sheet).rmdir()
            release(out, [sheet])
