"""Reads a document back from the scene, so that whatever was mended by hand counts.

What nobody has touched comes back as it was computed, to the last bit: the scene holds single precision only, and the
window is to make the same page as the command line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...core.arrays import Indices
from ...core.camera import Camera
from ...core.numeric.polygon import signed_area
from ...core.paper.outline import Outline
from ...core.sheet import FlatMap
from ..state import State
from .document import Document
from .modes import set_mode
from .outline_curve import object_to_outline
from .points_mesh import points_left
from .ridge_group import read_ridges
from .sheet_mesh import is_unchanged, object_to_sheet, page_uv, pinned_vertices, read_flat
from .show import OUTLINE, POINTS, SHEET

_NO_PINS = np.zeros(0, np.int64)
Edited = Literal["points", "outline", "vertices", "creases", "page"]


@dataclass(frozen=True)
class ReadBack:
    """A document as it is now, what of it was edited by hand since it was computed, and the vertices pinned."""

    state: State
    edited: frozenset[Edited]
    pinned: Indices


def read_back(document: Document) -> ReadBack:
    """The document as the scene has it; its objects leave Edit Mode.

    Raises
    ------
    StepFailed
        If an object has become something that cannot be used, with what to do about it.
    """
    state, edited = document.state, set[Edited]()
    if state.model is None:
        return ReadBack(state, frozenset(), _NO_PINS)
    state = _with_points(document, state, edited)
    if state.region is not None:
        state = _with_outline(document, state, edited)
    if state.sheet is not None:
        state = _with_sheet(document, state, edited)
    sheet_object = document.object(SHEET)
    pinned = _NO_PINS if sheet_object is None or state.flat is None else pinned_vertices(sheet_object)
    return ReadBack(state, frozenset(edited), pinned)


def _with_points(document: Document, state: State, edited: set[Edited]) -> State:
    points = document.object(POINTS)
    model = state.model
    assert model is not None
    if points is None:
        return state
    set_mode(points, "OBJECT")
    left = points_left(points, model)
    if left.all():
        return state
    edited.add("points")
    region = state.region
    if region is not None:
        region = replace(region, on_sheet=region.on_sheet[left])
    return replace(state, model=model.select(left), region=region)


def _with_outline(document: Document, state: State, edited: set[Edited]) -> State:
    outline = document.object(OUTLINE)
    region = state.region
    assert region is not None
    if outline is None:
        return state
    set_mode(outline, "OBJECT")
    reference = reference_of(state)
    polygon = object_to_outline(outline, region.outline.polygon, reference)
    if polygon is region.outline.polygon:
        return state
    edited.add("outline")
    polygon = polygon if signed_area(polygon) > 0 else polygon[::-1]
    return replace(state, region=replace(region, outline=Outline(polygon, 1.0, ())))


def _with_sheet(document: Document, state: State, edited: set[Edited]) -> State:
    sheet_object = document.object(SHEET)
    assert state.sheet is not None
    if sheet_object is None:
        return state
    set_mode(sheet_object, "OBJECT")
    if is_unchanged(sheet_object, state.sheet, document.frame):
        flat = read_flat(sheet_object)
        ridges = read_ridges(sheet_object, None if flat is None else flat.uv)
        if not _same_ridges(ridges, state.sheet.ridges):
            edited.add("creases")
            state = replace(state, sheet=replace(state.sheet, ridges=ridges))
    else:
        edited.add("vertices")
        sheet, flat = object_to_sheet(sheet_object)
        state = replace(state, sheet=sheet)
    if flat is not None and state.flat is not None and not _same_flat(flat, state.flat):
        edited.add("page")
        state = replace(state, uv=flat.uv, flat=flat)
    return state


def reference_of(state: State) -> Camera:
    """The camera of the reference photo."""
    assert state.model is not None
    assert state.region is not None
    return state.model.cameras[state.region.reference]


def _same_ridges(read: Sequence[Indices], computed: Sequence[Indices]) -> bool:
    return len(read) == len(computed) and all(map(np.array_equal, read, computed))


def _same_flat(read: FlatMap, computed: FlatMap) -> bool:
    if read.uv.shape != computed.uv.shape or (read.width, read.height) != (computed.width, computed.height):
        return False
    return bool(np.abs(page_uv(read) - page_uv(computed)).max() <= 4 * np.finfo(np.float32).eps)
