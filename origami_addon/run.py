"""A whole run: the steps from photos to page, and the folder with its results.

The folder shows at any time how far a run got. Each file is complete or absent, the steps keep their results in `work`,
and `report.json` comes last: if it exists, the run has finished, and its results stay until those of the next run are
complete. Only Origami's own files are replaced or removed: a marker lists them, and a run refuses inputs in places that
its results would replace.
"""

from __future__ import annotations

import logging
import re
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..core.errors import Cancelled, OrigamiError, UnusablePhotos, UsageError
from ..core.watch import SILENT, Watch
from . import steps
from .advance import advance, advance_through
from .export.outputs import OTHER_LIGHT, write_other_page
from .feasibility import check_page_size, check_reference
from .files.content_hash import sha256_of
from .files.folder_lock import only_run_in
from .files.json_files import parsed_json
from .files.kept import drop_superseded
from .files.movie_photos import with_photos_of_movies
from .files.photo_files import photo_files
from .files.photos import Photo, gather
from .files.results_folder import REPORT, number_of, real, unshared_file
from .one_line import OneLine
from .other_light import OtherPage, OtherPhotos, finished_other, gather_others, lay_other_photos
from .output_folder import (
    LOG,
    STOPPED,
    check_folder,
    is_as_reported,
    keep_off_other_light,
    keep_off_photos,
    keep_off_sheets,
    keep_off_what_is_read,
    keep_only_recomputed,
    make_folder,
    movies_folder_of,
    open_folder,
    other_light_files,
    place_for_results,
    put_in_place,
    results_in,
    results_of_sheets,
    sheet_folder,
    work_folder_of,
)
from .plan import Known, plan, plan_all
from .report import Report, version, versions
from .settings import RunSettings
from .settings_json import to_json
from .sfm.colmap_files import check_files, model_folder
from .stages import STAGES, Stage, about, as_option, parts_of_time
from .state import Paged, Placed, State, reached
from .system_errors import system_errors_as_failures, unwritable_as_failure

_COLMAP_FILE = re.compile(r"(cameras|images|points3D|rigs|frames)\.(bin|txt)")
# The share of a run's time after which the photos are placed.
_PLACED = 0.6

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
        return _logged(
            found, other_photos, out, settings, watch, recursive=recursive, force=force, stop_after=stop_after
        )


def _logged(
    found: tuple[Sequence[Path], Sequence[str]],
    other_photos: Sequence[Path],
    out: Path,
    settings: RunSettings,
    watch: Watch,
    *,
    recursive: bool,
    force: bool,
    stop_after: Stage | None,
) -> Report:
    """Run, and note in the log how it went."""
    with _logging_to(out / LOG):
        report = Report(to_json(settings), number=number_of(out))
        log.info("Origami %s, photos %s, settings %s", version(), [str(path) for path in found[0]], report.settings)
        try:
            with system_errors_as_failures(out):
                return _rectify(
                    found,
                    other_photos,
                    out,
                    settings,
                    report,
                    watch,
                    recursive=recursive,
                    force=force,
                    stop_after=stop_after,
                )
        except OrigamiError as error:
            error.warnings = tuple(report.warnings)
            log.error(str(error))
            raise
        except Exception:
            log.exception("internal error")
            raise


def _rectify(
    found: tuple[Sequence[Path], Sequence[str]],
    other_photos: Sequence[Path],
    out: Path,
    settings: RunSettings,
    report: Report,
    watch: Watch,
    *,
    recursive: bool,
    force: bool,
    stop_after: Stage | None,
) -> Report:
    files, left_out = found
    watch.step(0, "Reading the photos")
    with report.stage("read photos") as figures:
        report.warn(*left_out)
        reading = watch.part(0, 0.02)
        pictures, movies = with_photos_of_movies(
            files, lambda _: movies_folder_of(out), report.warn, reading, again=force
        )
        photos, warnings = gather(pictures)
        report.warn(*warnings)
        report.inputs = [_described(photo) for photo in photos]
        report.inputs += [
            {"name": each.path.name, "path": str(real(each.path)), "sha256": each.sha256} for each in movies
        ]
        if settings.colmap_model is not None:
            report.inputs += _files_of_model(Path(settings.colmap_model))
        figures["photos"] = len(photos)
        others = gather_others(other_photos, recursive=recursive)
        for other in others:
            report.inputs += [_described(photo) | {"other_photos": other.name} for photo in other.photos]
    keep_off_other_light(out, [each.name for each in others])
    check_reference(photos, settings)
    check_page_size(photos, settings)
    if not force and (finished := _finished(out, report)):
        log.info("Nothing has changed since the last run.")
        (out / STOPPED).unlink(missing_ok=True)
        return finished
    work = steps.Work(photos, work_folder_of(out, recompute=force), settings, report)
    begun = plan_all(Known(_paths(photos), settings))
    placed = reached(advance(begun.stages[0], begun.start, work, watch.part(0.02, _PLACED)), Placed)
    if stop_after is not None:
        return _stopped(placed, work, out, stop_after, watch.part(_PLACED, 0.99))
    if settings.sheet == "all":
        place = _every_sheet(placed, work, out, watch.part(_PLACED, 0.99))
    else:
        paged = 0.75 if others else 0.88
        page = _page_of(placed, work, watch.part(_PLACED, paged))
        other_pages = _other_pages(page, others, work, watch.part(paged, 0.88))
        names = [other.photos.name for other in other_pages]
        place = place_for_results(out)
        _write(page, work, place, out, watch.part(0.88, 0.99))
        for made in other_pages:
            write_other_page(place / OTHER_LIGHT, made.photos.name, finished_other(made, out))
        for name in other_light_files(names):
            report.add_output(place, name)
    report.write(place / REPORT)
    put_in_place(out)
    (out / STOPPED).unlink(missing_ok=True)
    for image in (steps.PAGE_IMAGE, steps.OTHER_IMAGE):
        drop_superseded(work.folder, image, work.images)
    if force:
        keep_only_recomputed(out)
    watch.progress(1, "Done")
    return report


def _stopped(placed: Placed, work: steps.Work, out: Path, last: Stage, watch: Watch) -> Report:
    """Go on to a stage and no further, and write down what was found."""
    if last != STAGES[0]:
        _advanced(placed, work, watch, STAGES[1 : STAGES.index(last) + 1])
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


def _every_sheet(placed: Placed, work: steps.Work, out: Path, watch: Watch) -> Path:
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
        count = len(steps.sheets_in_view(placed.model, work, watch.part(0, 0.1)))
        figures["sheets_in_view"] = count
    keep_off_sheets(out, count)
    before, warned = list(report.stages), list(report.warnings)
    failures: list[OrigamiError] = []
    place: Path | None = None
    for number in range(1, count + 1):
        part = watch.part(0.1 + 0.9 * (number - 1) / count, 0.1 + 0.9 * number / count)
        folder, settings = sheet_folder(number), replace(work.settings, sheet=number)
        own_report = Report(to_json(settings), report.inputs, list(before), list(warned), number=report.number)
        own = replace(work, settings=settings, report=own_report)
        failure = None
        try:
            page = _page_of(placed, own, part.part(0, 0.7), one_of_all=True)
            place = place or place_for_results(out)
            (place / folder).mkdir()
            _write(page, own, place / folder, out / folder, part.part(0.7, 1))
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


def _page_of(placed: Placed, work: steps.Work, watch: Watch, *, one_of_all: bool = False) -> Paged:
    """The sheet in placed photos as a flat page."""
    return reached(_advanced(placed, work, watch, STAGES[1:], one_of_all=one_of_all), Paged)


def _advanced(
    placed: Placed, work: steps.Work, watch: Watch, stages: Sequence[Stage], *, one_of_all: bool = False
) -> State:
    """The state after these stages, which follow the placing of the photos."""
    paths = _paths(work.photos)
    planned = plan(Known(paths, work.settings, placed=paths, state=placed), stages)
    state, parts = planned.start, parts_of_time(planned.stages)
    for done in advance_through(
        planned.stages, state, work, lambda stage: watch.part(*parts[stage]), one_of_all=one_of_all
    ):
        state = done.state
    return state


def _paths(photos: Sequence[Photo]) -> tuple[str, ...]:
    return tuple(str(photo.path) for photo in photos)


def _write(page: Paged, work: steps.Work, place: Path, home: Path, watch: Watch) -> None:
    """Write a page and all its files except the report into ``place``; they will be moved to ``home``."""
    steps.write_results(page, work, place, home, watch)
    for name in results_in(place):
        work.report.add_output(place, name)


def _described(photo: Photo) -> dict[str, Any]:
    return {
        "name": photo.name,
        "path": str(real(photo.path)),
        "sha256": photo.sha256,
        "width": photo.width,
        "height": photo.height,
        "make": photo.make,
        "model": photo.model,
        "taken": photo.taken,
    }


def _files_of_model(folder: Path) -> list[dict[str, Any]]:
    """The files of a COLMAP model for the report."""
    return [
        {"name": path.name, "path": str(real(path)), "sha256": sha256_of(path)}
        for path in sorted(model_folder(folder).iterdir())
        if _COLMAP_FILE.fullmatch(path.name)
    ]


def _finished(out: Path, report: Report) -> Report | None:
    """The earlier run of the same inputs with the same settings and code, if the folder holds it completely."""
    try:
        earlier = parsed_json(out / REPORT)
        same = (
            earlier["versions"] == versions()
            and earlier["settings"] == report.settings
            and earlier["inputs"] == report.inputs
            and all(is_as_reported(out / name, entry) for name, entry in earlier["outputs"].items())
            and not any(sheet["failure"] for sheet in earlier.get("sheets", []))
        )
        if not same:
            return None
        return Report(
            earlier["settings"],
            earlier["inputs"],
            earlier["stages"],
            earlier["warnings"],
            earlier["tried"],
            earlier["outputs"],
            number=earlier["number"],
            sheets=earlier.get("sheets", []),
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


class _QuietFileHandler(logging.FileHandler):
    """A log that never fails: a full disk is reported once, by the step that needs it."""

    def handleError(self, record: logging.LogRecord) -> None:
        pass


@contextmanager
def _logging_to(path: Path) -> Iterator[None]:
    if path.exists():
        unshared_file(path)
    handler = _QuietFileHandler(path, encoding="utf-8", errors="backslashreplace")
    handler.setFormatter(OneLine("%(asctime)s %(levelname)s %(message)s"))
    level = log.level
    log.setLevel(logging.DEBUG)
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)
        handler.close()
