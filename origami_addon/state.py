"""The state of a document: the nouns between its photos and its page, and their form as plain arrays."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import islice
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Array
from ..core.camera import Camera
from ..core.errors import UsageError
from ..core.page.texture import PageTexture
from ..core.paper.outline import Outline
from ..core.paper.sheet_search import FoundSheet
from ..core.sheet import FlatMap, Sheet, sheet_arrays, sheet_from_arrays
from ..core.sparse_model import SparseModel, camera_arrays, cameras_from_arrays, model_arrays, model_from_arrays
from .files.image_files import PageImage
from .files.kept import Arrays
from .stages import STAGES, Stage, about


@dataclass(frozen=True)
class Region:
    """Where the sheet is.

    Attributes
    ----------
    reference : int
        Index into the model's cameras.
    outline : Outline
        In that camera's photo.
    on_sheet : (N,) bool array
        Which of the model's points are the sheet's.
    in_view : tuple of (K, 3) arrays
        World points along the edge of each sheet that was found, in the order of their numbers; none if the outline was
        given.
    """

    reference: int
    outline: Outline
    on_sheet: NDArray[np.bool_]
    in_view: tuple[Array, ...] = ()


@dataclass(frozen=True)
class Page:
    """The finished page.

    Attributes
    ----------
    texture : PageTexture
        In its light and in colour, with where each pixel is from.
    dpi : float
        Dots per inch, a nominal number where the paper's size is unknown.
    image : array
        The page for its files: in colour (H, W, 3), in grey (H, W), or black and white (H, W) bool with True for white.
    """

    texture: PageTexture
    dpi: float
    image: PageImage


@dataclass(frozen=True)
class State:
    """What is known of a document. Each subclass below adds the result of one more stage."""


@dataclass(frozen=True)
class Placed(State):
    """The photos are placed."""

    model: SparseModel


@dataclass(frozen=True)
class Found(Placed):
    """The sheet is found."""

    region: Region

    @property
    def reference(self) -> Camera:
        """The camera of the reference photo, as the sparse model has it."""
        return self.model.cameras[self.region.reference]


@dataclass(frozen=True)
class Surfaced(Found):
    """The sheet's surface and its creases are found.

    ``cameras`` are those of the sparse model, in its order, adjusted to the sheet's print: they see the sheet.
    """

    cameras: tuple[Camera, ...]
    sheet: Sheet

    @property
    def sheet_reference(self) -> Camera:
        """The camera of the reference photo, as it sees the sheet."""
        return self.cameras[self.region.reference]


@dataclass(frozen=True)
class Unwrapped(Surfaced):
    """The sheet is flat: the places (V, 2) of its vertices, not yet laid out as a page."""

    uv: Array


@dataclass(frozen=True)
class LaidOut(Unwrapped):
    """The flat sheet is laid out as a page."""

    flat: FlatMap


@dataclass(frozen=True)
class Paged(LaidOut):
    """The page has its image, which is kept as a file and not among the arrays."""

    page: Page


AFTER: dict[Stage, Any] = dict(zip(STAGES, (Placed, Found, Surfaced, Unwrapped, LaidOut, Paged), strict=True))
Kind = TypeVar("Kind", bound=State)


def reached(state: State, kind: type[Kind]) -> Kind:
    """A state as a given kind.

    Raises
    ------
    UsageError
        If the state has fewer results.
    """
    if isinstance(state, kind):
        return state
    missing = next(stage for stage, after in AFTER.items() if not isinstance(state, after))
    raise UsageError(f"{about(missing).verb} is not done yet: run it first, or press Rectify Photos.")


def extended(state: State, kind: type[Kind], **found: Any) -> Kind:
    """The state of a kind: what a stage ``found``, and the nouns before it; results of later stages are dropped."""
    return kind(
        **{field.name: getattr(state, field.name) for field in fields(kind) if field.name not in found}, **found
    )


def region_arrays(region: Region) -> Arrays:
    """A region as plain arrays."""
    return {
        "reference": np.array(region.reference),
        "polygon": region.outline.polygon,
        "confidence": np.array(region.outline.confidence),
        "notes": np.array(region.outline.notes, np.str_),
        "on_sheet": region.on_sheet,
        **edge_arrays(region.in_view),
    }


def region_from_arrays(arrays: Mapping[str, NDArray[Any]]) -> Region:
    """The region from the arrays of `region_arrays`."""
    notes = tuple(str(note) for note in arrays["notes"])
    outline = Outline(arrays["polygon"], float(arrays["confidence"]), notes)
    in_view = edges_from_arrays(arrays) if "edge_sizes" in arrays else ()
    return Region(int(arrays["reference"]), outline, arrays["on_sheet"], in_view)


def edge_arrays(edges: Sequence[Array]) -> Arrays:
    """The edges of several sheets (K, 3) as plain arrays."""
    return {"edges": np.concatenate([np.empty((0, 3)), *edges]), "edge_sizes": np.array([*map(len, edges)], np.int64)}


def edges_from_arrays(arrays: Mapping[str, NDArray[Any]]) -> tuple[Array, ...]:
    """The edges from the arrays of `edge_arrays`."""
    sizes = arrays["edge_sizes"]
    return tuple(np.split(arrays["edges"], np.cumsum(sizes)[:-1])) if len(sizes) else ()


def sheets_arrays(sheets: Sequence[FoundSheet]) -> Arrays:
    """Sheets that were found, each followed by its rivals, as plain arrays."""
    every = [each for sheet in sheets for each in (sheet, *sheet.rivals)]
    return edge_arrays([each.outline for each in every]) | {
        "points": np.array([each.points for each in every]),
        "sure": np.array([(each.probability, each.agreement) for each in every]),
        "rivals": np.array([len(sheet.rivals) for sheet in sheets], np.int64),
    }


def sheets_from_arrays(arrays: Mapping[str, NDArray[Any]]) -> tuple[FoundSheet, ...]:
    """The sheets from the arrays of `sheets_arrays`."""
    parts = zip(edges_from_arrays(arrays), arrays["points"], arrays["sure"].tolist(), strict=True)
    every = iter([FoundSheet(outline, points, *sure) for outline, points, sure in parts])
    return tuple(
        replace(sheet, rivals=tuple(islice(every, count)))
        for count, sheet in ((count, next(every)) for count in arrays["rivals"])
    )


def flat_arrays(flat: FlatMap) -> Arrays:
    """A flat map as plain arrays."""
    return {
        "uv": flat.uv,
        "page_size": np.array([flat.width, flat.height]),
        "unit": np.array(flat.unit),
        "world_scale": np.array(np.nan if flat.world_scale is None else flat.world_scale),
    }


def flat_from_arrays(arrays: Mapping[str, NDArray[Any]]) -> FlatMap:
    """The flat map from the arrays of `flat_arrays`."""
    width, height = arrays["page_size"]
    scale = float(arrays["world_scale"])
    return FlatMap(arrays["uv"], float(width), float(height), str(arrays["unit"]), None if np.isnan(scale) else scale)


_PARTS: dict[str, tuple[Callable[[Any], Arrays], Callable[[Arrays], Any]]] = {
    "model": (model_arrays, model_from_arrays),
    "region": (region_arrays, region_from_arrays),
    "cameras": (camera_arrays, cameras_from_arrays),
    "sheet": (sheet_arrays, sheet_from_arrays),
    "uv": (lambda uv: {"uv": uv}, lambda arrays: arrays["uv"]),
    "flat": (flat_arrays, flat_from_arrays),
}


def state_arrays(state: State) -> Arrays:
    """The whole state as plain arrays named ``noun.array``."""
    return {
        f"{noun}.{name}": array
        for noun, (take_apart, _) in _PARTS.items()
        if hasattr(state, noun)
        for name, array in take_apart(getattr(state, noun)).items()
    }


def state_from_arrays(arrays: Mapping[str, NDArray[Any]]) -> State:
    """The state from the arrays of `state_arrays`."""
    nouns: dict[str, Any] = {}
    for noun, (_, put_together) in _PARTS.items():
        parts = {name.partition(".")[2]: array for name, array in arrays.items() if name.startswith(f"{noun}.")}
        if parts:
            nouns[noun] = put_together(parts)
    if "sheet" in nouns:  # files from before cameras were adjusted have none of their own
        nouns.setdefault("cameras", nouns["model"].cameras)
    kind = next(kind for kind in (State, *AFTER.values()) if {field.name for field in fields(kind)} == nouns.keys())
    return kind(**nouns)


def to_bytes(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Arrays as the content of an npz file."""
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)  # type: ignore[arg-type, unused-ignore]
    return file.getvalue()


def from_bytes(content: bytes) -> Arrays:
    """The arrays that `to_bytes` wrote."""
    with np.load(io.BytesIO(content)) as stored:
        return dict(stored)
