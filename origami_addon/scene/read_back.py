"""Reads a document back from the scene, so that whatever was edited by hand counts.

What nobody has edited comes back as it was computed, to the last bit: the scene holds single precision only, and the
window is to make the same page as the command line.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy
import numpy as np

from ...core.camera import Camera
from ...core.outline import Outline
from ...core.polygon import signed_area
from ...core.sheet import Indices
from ..stages import Part
from ..state import State
from .document import Document
from .edits import edited_parts
from .modes import set_mode
from .outline_curve import object_to_outline
from .points_mesh import points_left
from .ridge_group import read_ridges
from .sheet_mesh import object_to_sheet, pinned_vertices, read_flat
from .show import OUTLINE, POINTS, SHEET

_NO_PINS = np.zeros(0, np.int64)


@dataclass(frozen=True)
class ReadBack:
    """A document as it is now, what of it was edited by hand since it was computed, and the vertices pinned."""

    state: State
    edited: frozenset[Part]
    pinned: Indices


def read_back(document: Document) -> ReadBack:
    """The document as the scene has it; its objects leave Edit Mode.

    A moved frame of the page counts only once it is applied.

    Raises
    ------
    StepFailed
        If an object has become something that cannot be used, with what to do about it.
    """
    points, outline, sheet_object = (document.object(role) for role in (POINTS, OUTLINE, SHEET))
    for shown in (points, outline, sheet_object):
        if shown is not None:
            set_mode(shown, "OBJECT")
    state = document.state
    edited = edited_parts(document, state) - {"frame"}
    if "points" in edited:
        state = _with_points(state, points)
    if "outline" in edited:
        state = _with_outline(state, outline)
    if edited & {"vertices", "creases", "page"}:
        state = _with_sheet(state, sheet_object, edited)
    pinned = _NO_PINS if sheet_object is None or state.flat is None else pinned_vertices(sheet_object)
    return ReadBack(state, frozenset(edited), pinned)


def _with_points(state: State, points: bpy.types.Object) -> State:
    model, region = state.model, state.region
    assert model is not None
    left = points_left(points, model)
    if region is not None:
        region = replace(region, on_sheet=region.on_sheet[left])
    return replace(state, model=model.select(left), region=region)


def _with_outline(state: State, outline: bpy.types.Object) -> State:
    assert state.region is not None
    polygon = object_to_outline(outline, state.region.outline.polygon, reference_of(state))
    polygon = polygon if signed_area(polygon) > 0 else polygon[::-1]
    return replace(state, region=replace(state.region, outline=Outline(polygon, 1.0, ())))


def _with_sheet(state: State, sheet_object: bpy.types.Object, edited: set[Part]) -> State:
    assert state.sheet is not None
    sheet, flat = state.sheet, read_flat(sheet_object)
    if "vertices" in edited:
        sheet, flat = object_to_sheet(sheet_object)
    elif "creases" in edited:
        sheet = replace(sheet, ridges=read_ridges(sheet_object, None if flat is None else flat.uv))
    state = replace(state, sheet=sheet)
    return state if flat is None or "page" not in edited else replace(state, uv=flat.uv, flat=flat)


def reference_of(state: State) -> Camera:
    """The camera of the reference photo."""
    assert state.model is not None
    assert state.region is not None
    return state.model.cameras[state.region.reference]
