"""The folder of a whole run: what may lie there, and how new results take the place of those of an earlier run.

The results of a finished run stay until those of the next one are all written. They are written into a folder of their
own, their report last; then the earlier report goes, file after file is put in its place, and the new report comes
last. A run that was stopped between these two finds its results whole and puts them in place when it is started again.
Where there is no finished run, the results are written to their places at once.

A run of every sheet has its results in folders inside, one for each sheet; all of them are exchanged at once, and the
report of the whole run still comes last. What a run does not replace of the sheets of an earlier one goes with that
run's report, so that no page of another run looks like one of this.
"""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import Any

from ..core.errors import StepFailed, UsageError
from .export.outputs import OUTPUTS, names_of
from .files.results_folder import (
    MARKER,
    claim,
    is_link,
    keep_off_inputs,
    keep_off_links,
    keep_off_others,
    owners,
    release,
)
from .report import sha256_of
from .scene.camera_object import VIEWS

REPORT, LOG, WORK = "report.json", "log.txt", "work"
RESULTS = tuple(names_of(each for each in OUTPUTS if each.in_run))
# Meant to be mended in an editor and given back.
_MENDABLE = tuple(names_of(each for each in OUTPUTS if each.mendable))
DISK_FULL = (errno.ENOSPC, errno.EDQUOT)
_FILES = (REPORT, *RESULTS, LOG)
_FOLDERS = (WORK, VIEWS)
# In the work folder: results that are to be put in place once they are whole, and what a run that does all anew keeps.
_STAGED, _ANEW = "results", "anew"
# Folders with the results of one sheet each.
_SHEET_FOLDER = re.compile(r"sheet-[1-9]\d*")
# As `camera_object.py` names the pictures behind its cameras.
_CAMERA_PHOTO = re.compile(r"\d{2,}_.*\.jpg")


def sheet_folder(number: int) -> str:
    """The folder inside that of the run in which a sheet's results lie."""
    return f"sheet-{number}"


def keep_off_photos(paths: Sequence[Path], out: Path, *, sheets: bool) -> None:
    """Refuse the photos' own folder: a page among the photos would be a photo of the next run.

    With ``sheets`` results also go into the sheets' folders.

    Raises
    ------
    UsageError
    """
    places = [out, *(out / name for name in _sheet_folders(out) if sheets)]
    for path in paths:
        folder = (path if path.is_dir() else path.parent).resolve()
        if any(folder == place.resolve() for place in places):
            raise UsageError(f"{folder} is the folder of the photos; choose another one for the results.")


def _sheet_folders(folder: Path) -> list[str]:
    """What has the name of a sheet's folder, in the order of the sheets."""
    there = [path.name for path in folder.iterdir()] if folder.is_dir() else []
    return sorted(filter(_SHEET_FOLDER.fullmatch, there), key=lambda name: (len(name), name))


def keep_off_what_is_read(inputs: Sequence[Path], out: Path) -> None:
    """Refuse inputs that lie where the results go.

    A report of Origami's may, and an outline and creases: they are read before they are replaced.

    Raises
    ------
    UsageError
    """
    taken = [VIEWS, *(name for name in RESULTS if name not in _MENDABLE)]
    names = [*taken, WORK, LOG, MARKER, *(f"{sheet}/{name}" for sheet in _sheet_folders(out) for name in taken)]
    if not _named_by_report(out):
        names.append(REPORT)
    keep_off_inputs(inputs, out, names)


def open_folder(out: Path, *, resume: bool, force: bool, read: Sequence[Path] = (), sheets: bool = False) -> None:
    """Make sure that results can be written into the folder and that nobody's are lost; finish an exchange of results.

    ``read`` are files that the settings came from; with ``sheets`` results go into the sheets' folders.

    Raises
    ------
    UsageError
        If it cannot be written, holds files of the user's that have the names of results, or links in their place, or
        holds results and neither ``resume`` nor ``force`` is given, or an outline or creases that were mended there
        and are not among the files read.
    StepFailed
        If its disk is full.
    """
    if out.exists() and not out.is_dir():
        raise UsageError(f"{out} is a file, not a folder; choose another folder for the results.")
    try:
        if sheets:
            keep_off_sheets(out, 1)  # how many there are is not known yet
        _keep_off_others(out)
        exchanging = (out / WORK / _STAGED / REPORT).is_file()
        if (out / REPORT).exists() and not (resume or force or exchanging):
            raise UsageError(
                f"{out} holds a finished run; add --resume to keep what is unchanged or --force to do all anew, "
                "or choose another folder."
            )
        _keep_off_mended(out, read)
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=out) as probe:
            probe.write(bytes(4096))
        claim(out, [WORK, LOG, *(name for name in _FILES + _FOLDERS if (out / name).exists())])
        (out / WORK).mkdir(exist_ok=True)
        for unfinished in out.glob(".writing-*"):
            shutil.rmtree(unfinished, ignore_errors=True)
    except OSError as error:
        if error.errno in DISK_FULL:
            raise StepFailed(disk_full(out)) from error
        raise UsageError(
            f"{out} cannot be written ({error.strerror}); choose another folder for the results."
        ) from error
    if exchanging:
        put_in_place(out)
    shutil.rmtree(out / WORK / _STAGED, ignore_errors=True)


def keep_off_sheets(out: Path, count: int) -> None:
    """Make sure that nobody's files lie where the results of so many sheets go.

    Raises
    ------
    UsageError
    """
    _keep_off_others(out, [sheet_folder(number) for number in range(1, count + 1)])


def _keep_off_others(out: Path, sheets: Sequence[str] = ()) -> None:
    names, folders = (*_FILES, *_FOLDERS, *sheets), (*_FOLDERS, *sheets)
    keep_off_others(out, names, known=_named_by_report(out), folders=folders)
    keep_off_links(out / WORK)
    for sheet in sheets:
        inside = out / sheet
        keep_off_others(inside, (REPORT, *RESULTS, VIEWS), known=_named_by_report(inside), folders=[VIEWS])


def _keep_off_mended(out: Path, read: Sequence[Path]) -> None:
    """Refuse to replace an outline or creases that somebody has changed since the run wrote them."""
    outputs = _outputs_of_report(out) or {}
    given = {path.resolve() for path in read}
    for name, told in outputs.items():
        path = out / name
        if path.name not in _MENDABLE or not path.exists() or path.resolve() in given:
            continue
        if sha256_of(path) != told.get("sha256"):
            number = "" if path.parent == out else f"{path.parent.name.replace('sheet-', '--sheet ')} and "
            raise UsageError(
                f"{path} was changed since it was written and would be replaced; give it with {number}--{path.stem}, "
                "or move it elsewhere."
            )


def _named_by_report(out: Path) -> set[str]:
    """What belongs to the run whose report lies in the folder; nothing if it is no report of Origami's."""
    outputs = _outputs_of_report(out)
    if outputs is None:
        return set()
    folders = {parent.as_posix() for name in outputs for parent in PurePosixPath(name).parents}
    return {REPORT, LOG, WORK, VIEWS, *outputs, *folders}


def _outputs_of_report(out: Path) -> dict[str, dict[str, Any]] | None:
    """The results that the report in the folder names; None if there is none of Origami's."""
    try:
        content = json.loads((out / REPORT).read_text(encoding="utf-8"))
        if "origami" in content["versions"]:
            return {str(name): dict(told) for name, told in content.get("outputs", {}).items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    return None


def work_folder_of(out: Path, *, anew: bool) -> Path:
    """The folder for what takes long to compute; an empty one where all is to be done anew.

    What an interrupted run did anew is taken up by the next one that may go on from it.
    """
    work, other = out / WORK, out / WORK / _ANEW
    if anew:
        shutil.rmtree(other, ignore_errors=True)
        other.mkdir(exist_ok=True)
        return other
    if other.is_dir():
        _move_into(other, work)
    return work


def keep_only_what_is_anew(out: Path) -> None:
    """Drop what earlier runs kept, after a run that did all anew."""
    for path in (out / WORK).iterdir():
        if path.name != _ANEW:
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    _move_into(out / WORK / _ANEW, out / WORK)


def _move_into(source: Path, target: Path) -> None:
    """Move what a folder holds into another one, folders into those of the same name, and remove it."""
    for path in list(source.iterdir()):
        there = target / path.name
        if path.is_dir() and there.is_dir():
            _move_into(path, there)
        else:
            os.replace(path, there)
    source.rmdir()


def place_for_results(out: Path, *, sheets: bool = False) -> Path:
    """The folder to write results into: a new one where there is a finished run, otherwise ``out`` itself.

    With ``sheets`` it is always a new one, for some of them may fail.
    """
    if not sheets and not (out / REPORT).exists():
        for name in _own_results(out):
            (out / name).unlink(missing_ok=True)
        _leave_sheets(out, _own_sheets(out))
        claim(out, (REPORT, *RESULTS, VIEWS))
        return out
    staged = out / WORK / _STAGED
    staged.mkdir()
    return staged


def results_in(folder: Path) -> list[str]:
    """The results of one page that a folder holds, by their names in it, but for the report."""
    pictures = [path.name for path in sorted((folder / VIEWS).glob("*.jpg")) if _CAMERA_PHOTO.fullmatch(path.name)]
    return [name for name in RESULTS if (folder / name).exists()] + [f"{VIEWS}/{name}" for name in pictures]


def results_of_sheets(folder: Path) -> list[str]:
    """The results that the sheets' folders in a folder hold, each sheet's report after its files."""
    found = []
    for sheet in _sheet_folders(folder):
        inside = results_in(folder / sheet) + [REPORT] * (folder / sheet / REPORT).exists()
        found += [f"{sheet}/{name}" for name in inside]
    return found


def put_in_place(out: Path) -> None:
    """Let new results, which are whole, take the place of the earlier ones; to do so again goes on with the rest.

    Raises
    ------
    StepFailed
        If a file is in use.
    UsageError
        If the user has put something of that name there meanwhile.
    """
    staged = out / WORK / _STAGED
    told = json.loads((staged / REPORT).read_text(encoding="utf-8"))["outputs"]
    waiting = results_in(staged) + results_of_sheets(staged)
    sheets = [sheet for sheet in _sheet_folders(staged) if any(name.startswith(f"{sheet}/") for name in waiting)]
    _keep_off_others(out, sheets)
    claim(out, [REPORT, *(name for name in RESULTS if name in waiting), VIEWS, *sheets])
    for sheet in sheets:
        (out / sheet).mkdir(exist_ok=True)
        claim(out / sheet, (REPORT, *RESULTS, VIEWS))
    try:
        (out / REPORT).unlink(missing_ok=True)
        # Reports first: a sheet whose report is there is whole.
        for name in sorted(_own_results(out), key=lambda name: Path(name).name != REPORT):
            if name not in told or (name in waiting and Path(name).name == REPORT):
                (out / name).unlink(missing_ok=True)
        _leave_sheets(out, [sheet for sheet in _own_sheets(out) if not any(n.startswith(f"{sheet}/") for n in told)])
        for name in (*waiting, REPORT):
            (out / name).parent.mkdir(exist_ok=True)
            os.replace(staged / name, out / name)
    except OSError as error:
        raise StepFailed(
            f"{error.filename2 or error.filename} could not be replaced ({error.strerror}): close the programs that "
            "have it open and run again; the new results are whole and are put in place then."
        ) from error
    shutil.rmtree(staged)


def _own_results(out: Path) -> list[str]:
    """The results in the folder that a run of the command line wrote, and the reports of its sheets."""
    found = results_in(out)
    for sheet in _own_sheets(out):
        known = _written_by_a_run(out / sheet)
        names = [name for name in (*results_in(out / sheet), REPORT) if PurePosixPath(name).parts[0] in known]
        found += [f"{sheet}/{name}" for name in names if (out / sheet / name).exists()]
    return found


def _own_sheets(out: Path) -> list[str]:
    """The sheets' folders that a run made; others may be called so too, or have been put in their place."""
    known = _written_by_a_run(out)
    return [name for name in _sheet_folders(out) if name in known and (out / name).is_dir() and not is_link(out / name)]


def _written_by_a_run(folder: Path) -> set[str]:
    listed = owners(folder, _FILES + _FOLDERS) or {}
    return _named_by_report(folder) | {name for name, document in listed.items() if document == ""}


def _leave_sheets(out: Path, sheets: Sequence[str]) -> None:
    """Give up sheets' folders that hold no result of a run any more; what else is in them stays."""
    for sheet in sheets:
        with suppress(OSError):
            (out / sheet / VIEWS).rmdir()
        release(out / sheet, (REPORT, *RESULTS, VIEWS))
        with suppress(OSError):
            (out / sheet).rmdir()
            release(out, [sheet])


def disk_full(out: Path) -> str:
    """The sentence for a disk without room."""
    return f"The disk of {out} is full; make room there and run again, what was done so far is kept."
