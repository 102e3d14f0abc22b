"""One stage of a document after the other, in a job as in a whole run, with a gate after each.

Where a gate refuses what a stage has found, or a stage fails, the next best way is tried: the surface without creases,
another reference photo, another region as the sheet. This is the only place that decides it. Nothing is computed for it
where the first way passes.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core.checks.gates import Refusal, refuse_flat, refuse_page, refuse_sheet
from ..core.errors import StepFailed
from ..core.watch import SILENT, Watch
from . import steps
from .report import Report
from .settings import RunSettings
from .stages import Stage
from .state import Found, LaidOut, Paged, Placed, State, Surfaced, Unwrapped, reached
from .steps import Work

# Of the regions that are none of the sheets in view, so many are tried.
_OTHER_SHEETS = 2
# From this probability on a sheet that leaves a part of the page white is torn, or of another shape: no other region,
# of a cloth say, is taken for it because it is more like a rectangle.
_SURE_OF_SHEET = 0.75
_BY_HAND = "give the outline by hand (--outline, or Edit Outline in Blender)"

log = logging.getLogger("origami")


@dataclass(frozen=True)
class Way:
    """What is chosen where the photos leave a choice.

    Attributes
    ----------
    told : str
        For the user.
    begins : Stage
        The first stage that it changes.
    other : int
        0 for the sheet that the settings ask for, n for the n-th likeliest region that is none of those in view.
    without : tuple of str
        Photos that are not to be the reference.
    creases : bool
        Whether creases are looked for.
    """

    told: str
    begins: Stage
    other: int = 0
    without: tuple[str, ...] = ()
    creases: bool = True


FIRST = Way("the likeliest sheet in its best photo", "find")


@dataclass(frozen=True)
class Done:
    """A stage that was done.

    Attributes
    ----------
    stage : Stage
    state : State
        After it.
    report : Report
        What it told.
    """

    stage: Stage
    state: State
    report: Report


def advance_through(
    stages: Sequence[Stage], state: State, work: Work, watch_of: Callable[[Stage], Watch], *, one_of_all: bool = False
) -> Iterator[Done]:
    """Go through stages, and on another way where one turns out to be wrong.

    A stage that is done again on another way is told of again; what came after it no longer holds. The report gets
    what was tried. Only what these stages find is ever chosen otherwise, never what a setting, a person or an earlier
    run has fixed; what these make of the sheet is warned of and kept. Where several ways were tried and none passes,
    the first one is kept with a warning unless it is hopeless.

    Parameters
    ----------
    stages : sequence of Stage
    state : State
        With all that the stages before these find.
    work : Work
    watch_of : callable
        The watch for a stage.
    one_of_all : bool
        Whether the other sheets in view are taken as well.

    Raises
    ------
    Cancelled, StepFailed, UnusablePhotos, UsageError
    """
    report = work.report
    before: dict[Stage, tuple[State, tuple[int, int]]] = {}
    way, believing = FIRST, False
    ways: list[Way] | None = None
    first: tuple[Refusal, StepFailed | None] | None = None
    begin = position = 0
    noted: tuple[str, ...] = ()
    while position < len(stages):
        stage = stages[position]
        before[stage] = state, report.mark()
        report.warn(*noted)
        noted = ()
        failure, refusal = None, None
        try:
            reached = advance(stage, state, work, watch_of(stage), way, one_of_all=one_of_all)
            refusal = None if believing else _refuse(stage, reached)
        except StepFailed as error:
            if believing or stage in ("place", "page"):  # on another way these would fail the same
                raise
            failure, refusal, reached = error, Refusal("the step itself", np.nan, np.nan, True, str(error)), state
        if refusal is None:
            state = reached
            yield Done(stage, state, report.since(before[stage][1]))
            position += 1
            continue
        log.info("refused: %s, %s: %s", way.told, stage, refusal)
        report.tried.append({"way": way.told, "taken": False, "stage": stage} | _figures(refusal))
        first = first or (refusal, failure)
        if ways is None:
            unsure = refusal.hopeless or _probability(report) < _SURE_OF_SHEET
            ways = _other_ways(stages, work.settings, reached, elsewhere=unsure and not one_of_all)
            begin = min((stages.index(each.begins) for each in ways), default=position)
        if ways:
            way = ways.pop(0)
        elif first[0].hopeless and (len(report.tried) > 1 or not np.isfinite(first[0].figure)):
            raise first[1] or StepFailed(_given_up(first[0], report.tried))
        else:
            way, believing = FIRST, True
        position = begin if believing else stages.index(way.begins)
        state, mark = before[stages[position]]
        report.forget(mark)
        noted = (_taken(first[0], None if believing else way),)
    if report.tried:
        report.tried.append({"way": way.told, "taken": True})


def _refuse(stage: Stage, state: State) -> Refusal | None:
    """What the gate after a stage says."""
    if stage == "surface":
        surfaced = reached(state, Surfaced)
        return refuse_sheet(surfaced.sheet, surfaced.cameras)
    if stage == "unwrap":
        unwrapped = reached(state, Unwrapped)
        return refuse_flat(unwrapped.sheet, unwrapped.uv)
    if stage == "lay_out":
        laid_out = reached(state, LaidOut)
        return refuse_page(laid_out.sheet, laid_out.flat)
    return None


def _probability(report: Report) -> float:
    """That the region that was found is the sheet, as finding it told; 1 where it was given."""
    told = [stage["figures"]["sheet_probability"] for stage in report.stages if "sheet_probability" in stage["figures"]]
    return float(told[-1]) if told else 1.0


def _other_ways(stages: Sequence[Stage], settings: RunSettings, state: State, *, elsewhere: bool) -> list[Way]:
    """What else may be tried, the likeliest to help first; other regions only where the sheet may be ``elsewhere``."""
    ways = []
    if "surface" in stages and settings.creases is None and isinstance(state, Surfaced) and state.sheet.ridges:
        ways.append(Way("the surface without creases", "surface", creases=False))
    if "find" in stages and settings.outline is None:
        if settings.reference is None and isinstance(state, Found):
            ways.append(Way("another reference photo", "find", without=(state.reference.name,)))
        if elsewhere and settings.sheet == 1 and settings.reference is None and settings.creases is None:
            ways += [Way("another part of the scene", "find", other=1 + number) for number in range(_OTHER_SHEETS)]
    return ways


def _figures(refusal: Refusal) -> dict[str, object]:
    return {
        "gate": refusal.gate,
        "figure": refusal.figure,
        "limit": refusal.limit,
        "cause": refusal.cause,
    }


def _taken(refusal: Refusal, way: Way | None) -> str:
    """A warning: what was refused, and what was taken in its place, if anything."""
    cause = refusal.cause.rstrip(".")
    if way is None:
        return f"{cause}, and nothing better was found: the page is likely wrong; look at the outline, and {_BY_HAND}."
    return f"{cause}; {way.told} was taken instead: look whether the page is right, or {_BY_HAND}."


def _given_up(refusal: Refusal, tried: Sequence[dict[str, object]]) -> str:
    others = ", ".join(str(each["way"]) for each in tried[1:])
    also = f" ({others}: no better)" if others else ""
    return f"{refusal.cause}{also}: the sheet was not found as it is; look at the outline, and {_BY_HAND}."


def advance(
    stage: Stage, state: State, work: Work, watch: Watch = SILENT, way: Way = FIRST, *, one_of_all: bool = False
) -> State:
    """The state after a stage; what later stages had found before is dropped, for it no longer holds.

    Parameters
    ----------
    stage : Stage
    state : State
        With all that the stages before this one find.
    work : Work
    watch : Watch
    way : Way
    one_of_all : bool
        As for `steps.find_sheet`.

    Raises
    ------
    Cancelled, StepFailed, UnusablePhotos, UsageError
    """
    if stage == "place":
        return Placed(steps.place(work, watch))
    if stage == "find":
        model = reached(state, Placed).model
        region = steps.find_sheet(model, work, watch, one_of_all=one_of_all, other=way.other, without=way.without)
        return Found(model, region)
    if stage == "surface":
        found = reached(state, Found)
        chosen = work if way.creases else replace(work, settings=replace(work.settings, creases=()))
        return Surfaced(found.model, found.region, *steps.reconstruct_sheet(found, chosen, watch))
    if stage == "unwrap":
        surfaced = reached(state, Surfaced)
        uv = steps.flatten_sheet(surfaced.sheet, work, watch)
        return Unwrapped(surfaced.model, surfaced.region, surfaced.cameras, surfaced.sheet, uv)
    if stage == "lay_out":
        flattened = reached(state, Unwrapped)
        flat = steps.lay_out_page(flattened, work, watch)
        return LaidOut(flattened.model, flattened.region, flattened.cameras, flattened.sheet, flattened.uv, flat)
    laid_out = reached(state, LaidOut)
    page = steps.render(laid_out, work, watch)
    return Paged(
        laid_out.model, laid_out.region, laid_out.cameras, laid_out.sheet, laid_out.uv, laid_out.flat, page
    )
