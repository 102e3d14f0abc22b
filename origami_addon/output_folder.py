"""The folder of a whole run: what it may contain, and its work folder.

`own_results.py` says which files there are Origami's, and `new_results.py` replaces those of an earlier run.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from ..core.errors import UsageError
from .export.outputs import OTHER_LIGHT
from .files.atomic import WRITING, write_text_at_once
from .files.content_hash import sha256_of
from .files.kept import KEPT_FILE
from .files.links import real, unshared_file
from .files.marker import LOCK, MARKER, NUMBER, REPORT, claim, number_of
from .files.results_folder import keep_off_inputs, keep_off_others
from .new_results import drop_unfinished, is_exchanging, put_in_place
from .one_line import is_text
from .own_results import (
    EDITABLE,
    FILES,
    FOLDERS,
    LOG,
    RESULTS,
    WORK,
    keep_off_others_in,
    named_by_report,
    other_light_files,
    outputs_of_report,
    sheet_folder,
    sheet_folders,
)
from .scene.camera_object import VIEWS

# The report of a run that stopped after a stage, as asked; it is there only if that was the last run to end well.
STOPPED = f"{WORK}/stopped.json"
# In the work folder: the kept results of a run that recomputes everything, and the photos taken from movies.
_RECOMPUTED, _MOVIES = "recomputed", "movies"
_PROBE = 4096  # bytes: more than a file system stores beside a file's name
# What the steps keep in the work folder beside files of `files/kept.py`.
_KEPT_FOLDERS = ("sfm", "on_page")


def keep_off_photos(paths: Sequence[Path], out: Path, *, sheets: bool) -> None:
    """Refuse the photos' own folder: a page among the photos would become a photo of the next run.

    With ``sheets``, results also go into the sheets' folders.

    Raises
    ------
    UsageError
    """
    places = [out, *(out / name for name in sheet_folders(out) if sheets)]
    for path in paths:
        folder = real(path if path.is_dir() else path.parent)
        if any(folder == real(place) for place in places):
            raise UsageError(f"{folder} is the folder of the photos; choose another folder for the results.")


def keep_off_what_is_read(inputs: Sequence[Path], out: Path) -> None:
    """Refuse inputs in places that the results would replace.

    Origami's own report, outline and creases are allowed: they are read before they are replaced.

    Raises
    ------
    UsageError
    """
    taken = [VIEWS, OTHER_LIGHT, *(name for name in RESULTS if name not in EDITABLE)]
    names = [*taken, WORK, LOG, MARKER, LOCK, *(f"{sheet}/{name}" for sheet in sheet_folders(out) for name in taken)]
    if not named_by_report(out):
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
            f"The name of {out} is not text in this system's encoding (UTF-8), and Blender cannot write there; choose "
            "another folder for the results."
        )
    if sheets:
        keep_off_sheets(out, 1)  # the number is not known yet
    keep_off_others_in(out)
    if (out / REPORT).exists() and not (resume or force or is_exchanging(out)):
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
        probe.write(bytes(_PROBE))


def open_folder(out: Path) -> None:
    """Claim a folder that was checked and locked, and finish an interrupted replacement.

    Raises
    ------
    OSError
    UsageError, StepFailed
        If the results of the interrupted replacement cannot be put in place.
    """
    claim(out, [WORK, LOG, *(name for name in FILES + FOLDERS if (out / name).exists())])
    (out / WORK).mkdir(exist_ok=True)
    write_text_at_once(out / NUMBER, json.dumps({"number": number_of(out)}) + "\n")
    _unshare(out / WORK)
    if is_exchanging(out):
        put_in_place(out)
    drop_unfinished(out)
    for unfinished in (out / WORK).rglob(f"{WRITING}*"):
        shutil.rmtree(unfinished, ignore_errors=True)


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
    keep_off_others_in(out, [sheet_folder(number) for number in range(1, count + 1)])


def keep_off_other_light(out: Path, names: Sequence[str]) -> None:
    """Refuse to replace the user's files with the pages of other photos, which have these names.

    Raises
    ------
    UsageError
    """
    keep_off_others(out, [OTHER_LIGHT], known=[OTHER_LIGHT], folders=[OTHER_LIGHT])
    keep_off_others(out, other_light_files(names), known=named_by_report(out))


def _keep_off_edited(out: Path, read: Sequence[Path]) -> None:
    """Refuse to replace an outline or creases that the user has edited since the run wrote them."""
    outputs = outputs_of_report(out) or {}
    given = {real(path) for path in read}
    for name, entry in outputs.items():
        path = out / name
        if path.name not in EDITABLE or not path.exists() or real(path) in given:
            continue
        if sha256_of(path) != entry.get("sha256"):
            number = "" if path.parent == out else f"{path.parent.name.replace('sheet-', '--sheet ')} and "
            raise UsageError(
                f"{path} was changed since it was written and would be replaced; pass it in with "
                f"{number}--{path.stem}, or move it elsewhere."
            )


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
