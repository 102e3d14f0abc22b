"""From placed photos to the pages of one sheet, or of every sheet in view, and their files."""

from __future__ import annotations

import logging
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..core.errors import Cancelled, OrigamiError
from ..core.watch import Watch
from . import steps
from .advance import advance_through
from .files.marker import REPORT
from .files.photos import Photo
from .new_results import place_for_results
from .output_folder import keep_off_sheets
from .own_results import results_in, results_of_sheets, sheet_folder
from .plan import Known, plan
from .report import Report
from .settings_json import to_json
from .stages import STAGES, Stage, parts_of_time
from .state import Paged, Placed, State, reached

# The part of a sheet's time after which its page is made, and its files are written.
_PAGED = 0.7
# The part of the time that the search for all sheets takes.
_SEARCHED = 0.1

log = logging.getLogger("origami")


def pages_of_every_sheet(placed: Placed, work: steps.Work, out: Path, watch: Watch) -> Path:
    """Make a page of each sheet in view; returns the folder with a subfolder for each.

    The failure of a single sheet goes into the report.

    Raises
    ------
    UsageError, UnusablePhotos, StepFailed
        If all of them fail.
    Cancelled
    """
    report = work.report
    with report.stage("find sheets") as figures:
        count = len(steps.sheets_in_view(placed.model, work, watch.part(0, _SEARCHED)))
        figures["sheets_in_view"] = count
    keep_off_sheets(out, count)
    before, warned = list(report.stages), list(report.warnings)
    failures: list[OrigamiError] = []
    place: Path | None = None
    for number in range(1, count + 1):
        part = watch.part(_SEARCHED, 1).part((number - 1) / count, number / count)
        folder, settings = sheet_folder(number), replace(work.settings, sheet=number)
        own_report = Report(to_json(settings), report.inputs, list(before), list(warned), number=report.number)
        own = replace(work, settings=settings, report=own_report)
        failure = None
        try:
            page = page_of(placed, own, part.part(0, _PAGED), one_of_all=True)
            place = place or place_for_results(out)
            (place / folder).mkdir()
            write_page(page, own, place / folder, out / folder, part.part(_PAGED, 1))
            own_report.write(place / folder / REPORT)
        except Cancelled:
            raise
        except OrigamiError as error:
            failure = f"Sheet {number}: {error}"
            failures.append(error)
            log.error(failure)
            if place is not None:
                shutil.rmtree(place / folder, ignore_errors=True)
        report.sheets.append({"folder": folder, "failure": failure})
        report.stages += [{**stage, "sheet": number} for stage in own_report.stages[len(before) :]]
        report.warn(*(f"Sheet {number}: {text}" for text in own_report.warnings[len(warned) :]))
    if len(failures) == count or place is None:
        messages = " ".join(sheet["failure"] for sheet in report.sheets)
        raise failures[0] if count == 1 else type(failures[0])(f"None of the {count} sheets could be made. {messages}")
    for name in results_of_sheets(place):
        report.add_output(place, name)
    return place


def page_of(placed: Placed, work: steps.Work, watch: Watch, *, one_of_all: bool = False) -> Paged:
    """The sheet in placed photos as a flat page."""
    return reached(advanced(placed, work, watch, STAGES[1:], one_of_all=one_of_all), Paged)


def advanced(
    placed: Placed, work: steps.Work, watch: Watch, stages: Sequence[Stage], *, one_of_all: bool = False
) -> State:
    """The state after these stages, which follow the placing of the photos."""
    paths = paths_of(work.photos)
    planned = plan(Known(paths, work.settings, placed=paths, state=placed), stages)
    state, parts = planned.start, parts_of_time(planned.stages)
    for done in advance_through(
        planned.stages, state, work, lambda stage: watch.part(*parts[stage]), one_of_all=one_of_all
    ):
        state = done.state
    return state


def paths_of(photos: Sequence[Photo]) -> tuple[str, ...]:
    """The photos' files, as a plan names them."""
    return tuple(str(photo.path) for photo in photos)


def write_page(page: Paged, work: steps.Work, place: Path, home: Path, watch: Watch) -> None:
    """Write a page and all its files except the report into ``place``; they will be moved to ``home``."""
    steps.write_results(page, work, place, home, watch)
    for name in results_in(place):
        work.report.add_output(place, name)
