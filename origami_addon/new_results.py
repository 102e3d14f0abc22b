"""How new results replace those of an earlier run.

The results of a finished run stay until the next run has written all of its own. Those are written into a separate
folder, the report last. Then the earlier report is deleted, the files are put in place one by one, and the new report
comes last. A run that was stopped in between finds its results complete and puts them in place when it is started
again. A first run does the same, so nothing unfinished ever lies among the user's files.

The sheets' folders of a run of every sheet are replaced together, and the report of the whole run still comes last.
Sheets of an earlier run that are not replaced are deleted with its report, so no page of an earlier run can pass for
one of this run.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Container, Sequence
from contextlib import suppress
from pathlib import Path

from ..core.errors import StepFailed
from .export.outputs import OTHER_LIGHT
from .files.atomic import sync_folder
from .files.json_files import parsed_json
from .files.marker import REPORT, claim, release
from .own_results import (
    RESULTS,
    WORK,
    keep_off_others_in,
    other_pages_in,
    own_results,
    own_sheets,
    results_in,
    results_of_sheets,
    sheet_folders,
    written_by_a_run,
)
from .scene.camera_object import VIEWS

# In the work folder: complete results that wait to be put in place.
_STAGED = "results"


def place_for_results(out: Path) -> Path:
    """A new folder for the results, until all are written."""
    staged = out / WORK / _STAGED
    staged.mkdir()
    return staged


def is_exchanging(out: Path) -> bool:
    """Whether complete results wait to be put in place."""
    return (out / WORK / _STAGED / REPORT).is_file()


def drop_unfinished(out: Path) -> None:
    """Delete results that an interrupted run did not complete."""
    shutil.rmtree(out / WORK / _STAGED, ignore_errors=True)


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
    others = other_pages_in(staged)
    waiting = results_in(staged) + others + results_of_sheets(staged)
    sheets = [sheet for sheet in sheet_folders(staged) if any(name.startswith(f"{sheet}/") for name in waiting)]
    keep_off_others_in(out, sheets)
    claim(out, [REPORT, *(name for name in RESULTS if name in waiting), VIEWS, *sheets, *others])
    for sheet in sheets:
        (out / sheet).mkdir(exist_ok=True)
        claim(out / sheet, (REPORT, *RESULTS, VIEWS))
    try:
        (out / REPORT).unlink(missing_ok=True)
        # Reports first: a sheet with a report is complete.
        for name in sorted(own_results(out), key=lambda name: Path(name).name != REPORT):
            if name not in outputs or (name in waiting and Path(name).name == REPORT):
                (out / name).unlink(missing_ok=True)
        _leave_other_light(out, outputs)
        _leave_sheets(out, [sheet for sheet in own_sheets(out) if not any(n.startswith(f"{sheet}/") for n in outputs)])
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


def _leave_other_light(out: Path, outputs: Container[str]) -> None:
    """Release the pages of other photos that are no longer results."""
    gone = [name for name in written_by_a_run(out) if name.startswith(f"{OTHER_LIGHT}/") and name not in outputs]
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
