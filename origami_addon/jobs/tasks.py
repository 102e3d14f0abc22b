"""The work of jobs: arrays and settings in, arrays and files out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...core.arrays import Indices
from ...core.errors import OrigamiError, UnusablePhotos
from ...core.flat.pins import pinned_on_page
from ...core.page.page import framed
from ...core.unwrap.unwrap import unwrap
from ...core.watch import SILENT, Watch
from .. import other_light, steps
from ..advance import advance_through
from ..export.outputs import PAGE_FILES, chosen, write_outputs
from ..files.atomic import replacing
from ..files.image_files import write_png
from ..files.kept import Arrays
from ..files.movie_photos import with_photos_of_movies
from ..files.photo_pixels import JudgedPixels
from ..files.photos import Photo, gather
from ..other_light import gather_others
from ..report import Report, plain
from ..scene.camera_object import write_views
from ..scene.foreign_mesh import unwrap_arguments
from ..scene.unfolding import unfolding
from ..settings import RunSettings
from ..stages import STAGES, parts_of_time
from ..state import LaidOut, Paged, Placed, State, Surfaced, reached, state_arrays, state_from_arrays
from .process import OTHER_PICTURE, RESULT, UNFOLDING
from .requests import CompareMethods, LayOtherPhotos, Request, RunStages, UnwrapMesh, WriteFiles

# The share of a job's time after which the photos are taken from the movies.
_FROM_MOVIES = 0.1
Say = Callable[..., None]


def run_stages(request: RunStages, given: Arrays, folder: Path, say: Say, watch: Watch) -> None:
    """Run the stages of a request and report each result; a stage that runs again in another way is reported again.

    Parameters
    ----------
    request : RunStages
    given : dict of arrays
        The known state, as from `state_arrays`, and in ``pinned`` the vertices pinned on the page. If there are any,
        the sheet is unwrapped around them and the page keeps its layout.
    folder : Path
        Receives ``<stage>.npz`` with the state after each stage, the views of the cameras, the page, and in
        `UNFOLDING` the shapes of the sheet on its way to flat.
    say : callable
    watch : Watch

    Raises
    ------
    StepFailed, UnusablePhotos, UsageError
        With the stage's earlier warnings.
    """
    settings, stages = request.settings, request.stages
    settings.check()
    watch.step(0, "Reading the photos")
    state = state_from_arrays(given)
    photos, warnings, movies = _photos(request, watch) if _reads_photos(stages, state, settings) else ([], [], {})
    parts = parts_of_time(stages)
    sharpness: dict[str, float] = {}

    after_movies = watch.part(_FROM_MOVIES if movies else 0, 1)

    def part(stage: str) -> Watch:
        return after_movies.part(*parts[stage])

    def report_stage(stage: str, state: State, report: Report) -> None:
        # A stage may run twice, and the window may still be reading the files of the first time.
        with replacing(folder / RESULT.format(stage=stage)) as unfinished:
            np.savez_compressed(unfinished, **state_arrays(state))  # type: ignore[arg-type, unused-ignore]
        if stage == "lay_out" or (stage == "page" and not (folder / UNFOLDING).exists()):
            state = reached(state, LaidOut)
            with replacing(folder / UNFOLDING) as unfinished:
                np.savez(unfinished, shapes=unfolding(state.sheet, state.flat))
        say(done=stage, movies=movies, sharpness=sharpness, **_report_message(report))

    left = list(stages)
    with _working(request, photos, settings) as work:
        if STAGES[0] in stages:
            work.report.warn(*warnings)
        if request.corners is not None:
            before = reached(state, LaidOut)
            state = replace(before, flat=framed(before.flat, np.array(request.corners)))
            left.remove("lay_out")
            report_stage("lay_out", state, Report({}))
        elif "pinned" in given:
            state = _unwrap_around_pins(reached(state, LaidOut), given["pinned"], work, part("unwrap"))
            report_stage("unwrap", state, work.report)
            left = [stage for stage in stages if stage == "page"]
            if "lay_out" in stages:
                report_stage("lay_out", state, Report({}))
        for done in advance_through(left, state, work, part):
            state = done.state
            if done.stage == STAGES[0]:
                model = reached(state, Placed).model
                part(STAGES[0]).step(1, "Undistorting the photos behind the cameras")
                pixels = JudgedPixels(photos, model)
                list(write_views(folder / "views", model.cameras, pixels.__getitem__))
                sharpness.update(pixels.sharpness)
                done.report.warnings[:0] = warnings
            if isinstance(state, Paged):
                write_outputs(PAGE_FILES, folder, steps.finished(photos, state, folder), done.report, SILENT)
            report_stage(done.stage, state, done.report)


def write_files(request: WriteFiles, given: Arrays, folder: Path, say: Say, watch: Watch) -> None:
    """Write the document as files of the kinds of a request; the other parameters are those of `run_stages`.

    Raises
    ------
    StepFailed, UnusablePhotos, UsageError
    """
    watch.step(0, "Reading the photos")
    photos, *_ = _photos(request, watch)
    with _working(request, photos, request.settings) as work:
        state = steps.advance("page", state_from_arrays(given), work, watch.part(0.1, 0.5))
        done = steps.finished(photos, reached(state, Paged), folder, request.bits)
        write_outputs(chosen(request.kinds), Path(request.out), done, work.report, watch.part(0.5, 1))
    say(done="export", **_report_message(work.report))


def lay_other_photos(request: LayOtherPhotos, given: Arrays, folder: Path, say: Say, watch: Watch) -> None:
    """Make a page of the other photos that a request names; the folder receives it as `OTHER_PICTURE`.

    The other parameters are those of `run_stages`.

    Raises
    ------
    StepFailed, UnusablePhotos, UsageError
    """
    watch.step(0, "Reading the photos")
    photos, *_ = _photos(request, watch)
    (others,) = gather_others([Path(request.directory)])
    with _working(request, photos, request.settings) as work:
        paged = reached(steps.advance("page", state_from_arrays(given), work, watch.part(0.1, 0.4)), Paged)
        work.report.forget((0, 0))  # the page's own figures are known
        page = other_light.lay_other_photos(paged, others, work, watch.part(0.4, 1)).state.page
        profile = others.photos[0].icc_profile
        write_png(folder / OTHER_PICTURE, page.texture.image, page.dpi, profile, bits=None)
    say(done=OTHER_PICTURE, name=others.name, **_report_message(work.report))


@contextmanager
def _working(request: Request, photos: Sequence[Photo], settings: RunSettings) -> Iterator[steps.Work]:
    """What steps work with, and a new report, whose warnings an error raised in the block gets."""
    work = steps.Work(photos, Path(request.work), settings, Report({}))
    try:
        yield work
    except OrigamiError as error:
        error.warnings = tuple(work.report.warnings)
        raise


def _unwrap_around_pins(state: LaidOut, pinned: Indices, work: steps.Work, watch: Watch) -> LaidOut:
    """The state with a new flat map, in which the pinned vertices keep their places on the page."""
    pins, scale = pinned_on_page(state.sheet, state.flat, pinned)
    uv = steps.unwrap_sheet(state.sheet, work, watch, pins)
    return replace(state, uv=uv, flat=replace(state.flat, uv=uv * scale))


def compare_methods(request: CompareMethods, given: Arrays, folder: Path, say: Say, watch: Watch) -> None:
    """Unwrap and lay out the sheet with each of the methods of a request.

    The other parameters are those of `run_stages`; the folder receives ``<method>.npz`` with the state after each.

    Raises
    ------
    StepFailed, UnusablePhotos, UsageError
    """
    settings, state = request.settings, state_from_arrays(given)
    photos = _photos(request, watch)[0] if _reads_photos(["unwrap", "lay_out"], state, settings) else []
    for number, method in enumerate(request.methods):
        part = watch.part(number / len(request.methods), (number + 1) / len(request.methods))
        chosen = replace(settings, flatten=replace(settings.flatten, method=method))
        with _working(request, photos, chosen) as work:
            flat = steps.advance("unwrap", state, work, part.part(0, 0.6))
            flat = steps.advance("lay_out", flat, work, part.part(0.6, 1))
        np.savez(folder / RESULT.format(stage=method), **state_arrays(flat))  # type: ignore[arg-type, unused-ignore]
        say(done=method, **_report_message(work.report))


def unwrap_mesh(request: UnwrapMesh, given: Arrays, folder: Path, say: Say, watch: Watch) -> None:
    """Lay any mesh flat.

    Parameters
    ----------
    request : UnwrapMesh
    given : dict of arrays
        As from `foreign_mesh.read_mesh`.
    folder : Path
        Receives ``uv.npy``.
    say : callable
    watch : Watch

    Raises
    ------
    UnusableMesh
    """
    watch.step(0, "Unwrapping")
    unwrapped = unwrap(**unwrap_arguments(given), settings=request.flatten, watch=watch)
    np.save(folder / "uv.npy", unwrapped.uv)
    figures = {
        "stretch_mean": unwrapped.mean_stretch,
        "stretch_most": unwrapped.most_stretch,
        "islands": int(unwrapped.island.max()) + 1,
    }
    say(done="unwrap", figures=figures, warnings=[] if unwrapped.warning is None else [unwrapped.warning])


def _photos(request: Request, watch: Watch) -> tuple[list[Photo], list[str], dict[str, list[str]]]:
    """The document's photos, a sentence about each that is left out, and the photos that were taken from each movie.

    Those of a movie go beside it, where the user finds them.

    Raises
    ------
    UnusablePhotos
    """
    paths = [Path(path) for path in request.photos]
    gone = [path for path in paths if not path.is_file()]
    if gone:
        raise UnusablePhotos(
            f"{len(gone)} of {len(paths)} photos are no longer where they were, {gone[0]} for example: choose their "
            "folder with Find Photos, or leave them out and place the photos again."
        )
    warnings: list[str] = []
    files, taken = with_photos_of_movies(
        paths, lambda movie: movie.parent, warnings.append, watch.part(0, _FROM_MOVIES)
    )
    photos, about_photos = gather(files)
    movies = {str(each.path): [str(picture) for picture in each.pictures] for each in taken}
    return photos, warnings + about_photos, movies


def _reads_photos(stages: Sequence[str], state: State, settings: RunSettings) -> bool:
    """Whether the stages need pixels, or the window will show a photo that it does not show yet."""
    reading = {"place", "find", "surface", "page"} | ({"lay_out"} if settings.page.turn == "auto" else set())
    return not isinstance(state, Surfaced) or not reading.isdisjoint(stages)


def _report_message(report: Report) -> dict[str, Any]:
    figures = {name: value for stage in report.stages for name, value in stage["figures"].items()}
    seconds = sum(stage["seconds"] for stage in report.stages)
    return {"figures": plain(figures), "seconds": seconds, "warnings": report.warnings}


TASKS: dict[type, Callable[[Any, Arrays, Path, Say, Watch], None]] = {
    RunStages: run_stages,
    CompareMethods: compare_methods,
    LayOtherPhotos: lay_other_photos,
    UnwrapMesh: unwrap_mesh,
    WriteFiles: write_files,
}
