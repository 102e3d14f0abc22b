"""Run one stage of a document after the other, in a job or in a whole run, with a gate after each.

If a gate refuses a stage's result, or a stage fails, the next best way is tried: the surface without creases, another
reference photo, another region as the sheet. Only this module decides that. If the first way passes, it computes
nothing extra.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..core.checks.gates import Refusal, refuse_flat, refuse_page, refuse_sheet
from ..core.errors import StepFailed
from ..core.watch import Watch
from .report import Report
from .settings import RunSettings
from .stages import Stage
from .state import Found, LaidOut, State, Surfaced, Unwrapped, reached
from .steps import advance
from .steps.work import FIRST, Way, Work

# How many other regions, outside the sheets in view, are tried.
_OTHER_SHEETS = 2
# Above this probability, a sheet that leaves a part of the page white is torn or has another shape: no other region,
# such as one of a cloth, replaces it for being more like a rectangle.
_SURE_OF_SHEET = 0.75
_BY_HAND = "give the outline by hand (--outline, or Edit Outline in Blender)"

log = logging.getLogger("origami")


@dataclass(frozen=True)
class Done:
    """A finished stage.

    Attributes
    ----------
    stage : Stage
    state : State
        After it.
    report : Report
        Its figures and warnings.
    """

    stage: Stage
    state: State
    report: Report


def advance_through(
    stages: Sequence[Stage], state: State, work: Work, watch_of: Callable[[Stage], Watch], *, one_of_all: bool = False
) -> Iterator[Done]:
    """Run stages, and try other ways if one turns out to be wrong.

    A stage that runs again in another way is yielded again; the results after it are then invalid. The report lists
    what was tried. Other ways only change what these stages find, never what a setting, a user or an earlier run has
    fixed; a bad result that follows from those is kept, with a warning. If several ways were tried and none passes, the
    first one is kept with a warning, unless it is hopeless.

    Parameters
    ----------
    stages : sequence of Stage
    state : State
        With the results of all stages before these.
    work : Work
    watch_of : callable
        The watch for a stage.
    one_of_all : bool
        Whether the other sheets in view get a page too.

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
            if believing or stage in ("place", "page"):  # these would fail in any other way too
                raise
            failure, refusal, reached = error, Refusal("the step itself", np.nan, np.nan, True, str(error)), state
        if refusal is None:
            state = reached
            yield Done(stage, state, report.since(before[stage][1]))
            position += 1
            continue
        log.info("refused: %s, %s: %s", way.name, stage, refusal)
        report.tried.append({"way": way.name, "taken": False, "stage": stage} | _figures(refusal))
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
        report.tried.append({"way": way.name, "taken": True})


def _refuse(stage: Stage, state: State) -> Refusal | None:
    """The verdict of the gate after a stage."""
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
    """The reported probability that the region is the sheet; 1 if the user gave it."""
    name = "sheet_probability"
    reported = [stage["figures"][name] for stage in report.stages if name in stage["figures"]]
    return float(reported[-1]) if reported else 1.0


def _other_ways(stages: Sequence[Stage], settings: RunSettings, state: State, *, elsewhere: bool) -> list[Way]:
    """The other ways to try, the most promising first; other regions only if the sheet may be ``elsewhere``."""
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
    """A warning that says what was refused and what replaces it, if anything."""
    cause = refusal.cause.rstrip(".")
    if way is None:
        return f"{cause}, and nothing better was found: the page is likely wrong; check the outline, or {_BY_HAND}."
    return f"{cause}; {way.name} was taken instead: check the page, or {_BY_HAND}."


def _given_up(refusal: Refusal, tried: Sequence[dict[str, object]]) -> str:
    others = ", ".join(str(each["way"]) for each in tried[1:])
    also = f" ({others}: no better)" if others else ""
    return f"{refusal.cause}{also}: the sheet was not found correctly; check the outline, or {_BY_HAND}."
