"""Reads a document back from the scene, so edits by hand count.

Parts that nobody has edited come back exactly as they were computed: the scene only has single precision, and the
window must make the same page as the command line.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy
import numpy as np

from ...core.arrays import Indices
from ...core.errors import StepFailed
from ...core.numeric.polygon import signed_area
from ...core.paper.outline import Outline
from ..stages import Part, about
from ..state import Found, LaidOut, Placed, State, Surfaced, reached
from .document import Document
from .edits import edited_parts
from .modes import set_mode
from .outline_curve import object_to_outline
from .points_mesh import points_left
from .ridge_group import read_ridges
from .roles import OUTLINE, POINTS, SHEET
from .sheet_mesh import object_to_sheet, pinned_vertices, read_flat

_NO_PINS = np.zeros(0, np.int64)


@dataclass(frozen=True)
class ReadBack:
    """A document as it is now, the parts edited by hand since it was computed, and the pinned vertices."""

    state: State
    edited: frozenset[Part]
    pinned: Indices


def read_back(document: Document) -> ReadBack:
    """The document as it is in the scene; its objects leave Edit Mode.

    A moved page frame only counts once it is applied.

    Raises
    ------
    StepFailed
        If an object has become unusable; the message says what to do.
    """
    points, outline, sheet_object = (document.object(role) for role in (POINTS, OUTLINE, SHEET))
    for shown in (points, outline, sheet_object):
        if shown is not None:
            set_mode(shown, "OBJECT")
    state = document.state
    edited = edited_parts(document, state) - {"frame"}
    if "points" in edited:
        state = _with_points(reached(state, Placed), points)
    if "outline" in edited:
        state = _with_outline(reached(state, Found), outline)
    if edited & {"vertices", "creases", "page"}:
        state = _with_sheet(reached(state, Surfaced), sheet_object, edited)
    pinned = pinned_vertices(sheet_object) if sheet_object is not None and isinstance(state, LaidOut) else _NO_PINS
    return ReadBack(state, frozenset(edited), pinned)


def _with_points(state: Placed, points: bpy.types.Object) -> State:
    left = points_left(points, state.model)
    if isinstance(state, Found):
        state = replace(state, region=replace(state.region, on_sheet=state.region.on_sheet[left]))
    return replace(state, model=state.model.select(left))


def _with_outline(state: Found, outline: bpy.types.Object) -> State:
    polygon = object_to_outline(outline, state.region.outline.polygon, state.reference)
    polygon = polygon if signed_area(polygon) > 0 else polygon[::-1]
    return replace(state, region=replace(state.region, outline=Outline(polygon, 1.0, ())))


def _with_sheet(state: Surfaced, sheet_object: bpy.types.Object, edited: set[Part]) -> State:
    if sheet_object.type != "MESH":
        verb = about("surface").verb
        raise StepFailed(f"{sheet_object.name} is no longer a mesh: press Ctrl-Z, or delete it and press {verb}.")
    sheet, flat = state.sheet, read_flat(sheet_object)
    if "vertices" in edited:
        sheet, flat = object_to_sheet(sheet_object)
    elif "creases" in edited:
        sheet = replace(sheet, ridges=read_ridges(sheet_object, None if flat is None else flat.uv))
    if isinstance(state, LaidOut) and flat is not None and "page" in edited:
        # nobody knows how exact a hand is
        return replace(state, sheet=replace(sheet, bound=None), uv=flat.uv, flat=flat)
    state = replace(state, sheet=sheet)
    return state
