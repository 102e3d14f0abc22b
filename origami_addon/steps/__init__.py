"""The work of each stage, one function each, which whole runs and jobs share; and writing the results.

Each function is named after the verb of its stage in `stages.py`. Slow results are kept in the work folder, so that a
second run with another resolution, for example, does not compute the surface again.
"""

from __future__ import annotations

from dataclasses import replace

from ...core.watch import SILENT, Watch
from ..stages import Stage
from ..state import Found, LaidOut, Paged, Placed, State, Surfaced, Unwrapped, extended, reached
from .find import find_sheet, sheets_in_view
from .lay_out import lay_out_page
from .page import make_page
from .place import place_photos
from .results import finished, write_results
from .surface import build_surface
from .unwrap import unwrap_sheet
from .work import FIRST, Way, Work

__all__ = [
    "Work",
    "advance",
    "build_surface",
    "find_sheet",
    "finished",
    "lay_out_page",
    "make_page",
    "place_photos",
    "sheets_in_view",
    "unwrap_sheet",
    "write_results",
]


def advance(
    stage: Stage, state: State, work: Work, watch: Watch = SILENT, way: Way = FIRST, *, one_of_all: bool = False
) -> State:
    """The state after a stage, without the results of later stages, which no longer hold.

    Parameters
    ----------
    stage : Stage
    state : State
        With the results of all stages before this one.
    work : Work
    watch : Watch
    way : Way
    one_of_all : bool
        As for `find_sheet`.

    Raises
    ------
    Cancelled, StepFailed, UnusablePhotos, UsageError
    """
    if stage == "place":
        return Placed(place_photos(work, watch))
    if stage == "find":
        model = reached(state, Placed).model
        region = find_sheet(model, work, watch, one_of_all=one_of_all, other=way.other, without=way.without)
        return Found(model, region)
    if stage == "surface":
        found = reached(state, Found)
        chosen = work if way.creases else replace(work, settings=replace(work.settings, creases=()))
        cameras, sheet = build_surface(found, chosen, watch)
        return extended(found, Surfaced, cameras=cameras, sheet=sheet)
    if stage == "unwrap":
        surfaced = reached(state, Surfaced)
        uv = unwrap_sheet(surfaced.sheet, work, watch)
        return extended(surfaced, Unwrapped, uv=uv)
    if stage == "lay_out":
        unwrapped = reached(state, Unwrapped)
        flat = lay_out_page(unwrapped, work, watch)
        return extended(unwrapped, LaidOut, flat=flat)
    laid_out = reached(state, LaidOut)
    page = make_page(laid_out, work, watch)
    return extended(laid_out, Paged, page=page)
