"""One stage of a document after the other, in a job as in a whole run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..core.watch import SILENT, Watch
from . import steps
from .files.photos import Photo
from .report import Report
from .settings import RunSettings
from .stages import Stage
from .state import State


def advance(
    stage: Stage,
    photos: Sequence[Photo],
    state: State,
    work: Path,
    settings: RunSettings,
    report: Report,
    watch: Watch = SILENT,
) -> State:
    """The state after a stage; what later stages had found before is dropped, for it no longer holds.

    Parameters
    ----------
    stage : Stage
    photos : sequence of Photo
    state : State
        With all that the stages before this one find.
    work : Path
        Folder for what takes long to compute.
    settings : RunSettings
    report : Report
    watch : Watch

    Raises
    ------
    Cancelled, StepFailed, UnusablePhotos, UsageError
    """
    if stage == "place":
        return State(steps.place(photos, work, settings, report, watch))
    assert state.model is not None
    if stage == "find":
        return State(state.model, steps.find_sheet(photos, state.model, work, settings, report, watch))
    assert state.region is not None
    if stage == "surface":
        sheet = steps.reconstruct_sheet(state.model, state.region, work, settings, report, watch)
        return State(state.model, state.region, sheet)
    assert state.sheet is not None
    if stage == "unwrap":
        uv = steps.flatten_sheet(state.sheet, work, settings, report, watch)
        return State(state.model, state.region, state.sheet, uv)
    assert state.uv is not None
    flat = steps.lay_out_page(photos, state.model, state.region, state.sheet, state.uv, settings, report, watch)
    return replace(state, flat=flat)
