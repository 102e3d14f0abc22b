"""A whole run: the stages from photos to page, and the folder with its results.

The folder shows at any time how far a run got. Each file is complete or absent, the steps keep their results in `work`,
and `report.json` comes last: if it exists, the run has finished, and its results stay until those of the next run are
complete. Only Origami's own files are replaced or removed: a marker lists them, and a run refuses inputs in places that
its results would replace.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..core.errors import OrigamiError, UnusablePhotos, UsageError
from ..core.watch import SILENT, Watch
from . import steps
from .export.outputs import OTHER_LIGHT, write_other_page
from .feasibility import check_page_size, check_reference
from .files.folder_lock import only_run_in
from .files.kept import drop_superseded
from .files.marker import REPORT, number_of
from .files.photo_files import photo_files
from .new_results import place_for_results, put_in_place
from .other_light import OtherPage, OtherPhotos, finished_other, lay_other_photos
from .output_folder import (
    STOPPED,
    check_folder,
    keep_off_other_light,
    keep_off_photos,
    keep_off_what_is_read,
    keep_only_recomputed,
    make_folder,
    open_folder,
    work_folder_of,
)
from .own_results import LOG, other_light_files
from .pages_of_sheets import advanced, page_of, pages_of_every_sheet, paths_of, write_page
from .plan import Known, plan_all
from .report import Report, version
from .run_inputs import Asked, read_inputs
from .run_log import logging_to
from .settings import RunSettings
from .settings_json import to_json
from .sfm.colmap_files import check_files, model_folder
from .stages import STAGES, Stage, about, as_option
from .state import Paged, Placed, reached
from .steps.work import OTHER_IMAGE, PAGE_IMAGE
from .system_errors import system_errors_as_failures, unwritable_as_failure
from .unchanged_run import unchanged_run

# The shares of a run's time after which the photos are read and placed, the page is made and laid under other photos,
# and all files are written.
_READ, _PLACED, _PAGED, _LAID, _WRITTEN = 0.02, 0.6, 0.75, 0.88, 0.99

log = logging.getLogger("origami")


def rectify(
    paths: Sequence[Path],
    out: Path,
    settings: RunSettings,
    watch: Watch = SILENT,
    *,
    recursive: bool = False,
    other_photos: Sequence[Path] = (),
    resume: bool = False,
    force: bool = False,
    stop_after: Stage | None = None,
    also_read: Sequence[Path] = (),
) -> Report:
    """Make the flat page of the photos and write everything into a folder.

    Parameters
    ----------
    paths : sequence of Path
        Folders of photos, or photos.
    out : Path
        Created if missing.
    settings : RunSettings
    watch : Watch
    recursive : bool
        Also take the photos in subfolders.
    other_photos : sequence of Path
        Folders of photos of the same sheet in another light; each gets a page of its own, named after the folder.
    resume : bool
        The folder may hold a finished run; unchanged results are kept.
    force : bool
        The folder may hold a finished run; everything is recomputed and then replaces it.
    stop_after : Stage, optional
        Stop after this stage: its results are kept for the next run, and no file of the page is written or replaced.
    also_read : sequence of Path
        Files of the settings; the results must not replace them either.

    Returns
    -------
    Report
        As written to ``report.json``, or to ``work/stopped.json`` if the run stopped after a stage. In a run of every
        sheet some may have failed; its ``sheets`` say which.

    Raises
    ------
    UsageError, UnusablePhotos, StepFailed, Cancelled
        With a sentence for the user and the earlier warnings. The results until then are kept for the next run.
    """
    settings.check()
    every = settings.sheet == "all"
    if every and other_photos:
        raise UsageError(
            "Other photos need one page to be laid on; name its sheet (--sheet 1, --sheet 2, ...), or leave out "
            "--texture-from."
        )
    if every and stop_after not in (None, STAGES[0]):
        raise UsageError(
            "Every sheet is taken to its page one after the other; name one (--sheet 1, --sheet 2, ...) to stop after "
            f"this stage, or stop after {as_option(STAGES[0])}, which the sheets share."
        )
    found = photo_files(paths, recursive=recursive)
    keep_off_photos([*paths, *found[0], *other_photos], out, sheets=every)
    model = [] if settings.colmap_model is None else [Path(settings.colmap_model)]
    keep_off_what_is_read([*paths, *other_photos, *model, *also_read], out)
    for each in model:
        check_files(model_folder(each))
    checks: dict[str, Any] = {"resume": resume, "force": force, "read": also_read, "sheets": every}
    with unwritable_as_failure(out):
        check_folder(out, **checks)
        make_folder(out)
    with system_errors_as_failures(out), only_run_in(out):
        with unwritable_as_failure(out):
            check_folder(out, **checks)  # again, because another run may have ended meanwhile
            open_folder(out)
        return _logged(Asked(*found, other_photos, out, settings, recursive, force, stop_after), watch)


def _logged(asked: Asked, watch: Watch) -> Report:
    """Run, and note in the log how it went."""
    out = asked.out
    with logging_to(out / LOG):
        report = Report(to_json(asked.settings), number=number_of(out))
        files = [str(path) for path in asked.files]
        log.info("Origami %s, photos %s, settings %s", version(), files, report.settings)
        try:
            with system_errors_as_failures(out):
                return _rectify(asked, report, watch)
        except OrigamiError as error:
            error.warnings = tuple(report.warnings)
            log.error(str(error))
            raise
        except Exception:
            log.exception("internal error")
            raise


def _rectify(asked: Asked, report: Report, watch: Watch) -> Report:
    out, settings = asked.out, asked.settings
    watch.step(0, "Reading the photos")
    photos, others = read_inputs(asked, report, watch.part(0, _READ))
    keep_off_other_light(out, [each.name for each in others])
    check_reference(photos, settings)
    check_page_size(photos, settings)
    if not asked.force and (finished := unchanged_run(out, report)):
        log.info("Nothing has changed since the last run.")
        (out / STOPPED).unlink(missing_ok=True)
        return finished
    work = steps.Work(photos, work_folder_of(out, recompute=asked.force), settings, report)
    begun = plan_all(Known(paths_of(photos), settings))
    placed = reached(steps.advance(begun.stages[0], begun.start, work, watch.part(_READ, _PLACED)), Placed)
    if asked.stop_after is not None:
        return _stopped(placed, work, out, asked.stop_after, watch.part(_PLACED, _WRITTEN))
    if settings.sheet == "all":
        place = pages_of_every_sheet(placed, work, out, watch.part(_PLACED, _WRITTEN))
    else:
        place = _one_page(placed, others, work, out, watch)
    report.write(place / REPORT)
    put_in_place(out)
    (out / STOPPED).unlink(missing_ok=True)
    for image in (PAGE_IMAGE, OTHER_IMAGE):
        drop_superseded(work.folder, image, work.images)
    if asked.force:
        keep_only_recomputed(out)
    watch.progress(1, "Done")
    return report


def _one_page(placed: Placed, others: Sequence[OtherPhotos], work: steps.Work, out: Path, watch: Watch) -> Path:
    """Make the page of one sheet, and those of other photos on it; returns the folder with their files."""
    paged = _PAGED if others else _LAID
    page = page_of(placed, work, watch.part(_PLACED, paged))
    other_pages = _other_pages(page, others, work, watch.part(paged, _LAID))
    place = place_for_results(out)
    write_page(page, work, place, out, watch.part(_LAID, _WRITTEN))
    for made in other_pages:
        write_other_page(place / OTHER_LIGHT, made.photos.name, finished_other(made, out))
    for name in other_light_files([other.photos.name for other in other_pages]):
        work.report.add_output(place, name)
    return place


def _stopped(placed: Placed, work: steps.Work, out: Path, last: Stage, watch: Watch) -> Report:
    """Go on to a stage and no further, and write down what was found."""
    if last != STAGES[0]:
        advanced(placed, work, watch, STAGES[1 : STAGES.index(last) + 1])
    work.report.stopped_after = about(last).reported
    work.report.write(out / STOPPED)
    log.info("Stopped after %s, as asked.", work.report.stopped_after)
    watch.progress(1, "Done")
    return work.report


def _other_pages(page: Paged, others: Sequence[OtherPhotos], work: steps.Work, watch: Watch) -> list[OtherPage]:
    """The page of the photos in each folder; where no photo can be laid on the page, a warning instead."""
    count = len(others)
    pages = []
    for index, each in enumerate(others):
        try:
            pages.append(lay_other_photos(page, each, work, watch.part(index / count, (index + 1) / count)))
        except UnusablePhotos as error:
            work.report.warn(f"{error} The page itself is made without them.")
    return pages
