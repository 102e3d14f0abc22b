"""Any mesh of sheets, such as a scanned label or a modelled sleeve, to UV coordinates in one scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, Indices
from ..errors import StepFailed, UnusableMesh
from ..flat.distortion import fit_similarity, flipped_triangles, measure_strain
from ..flat.flatten import FlattenSettings, flatten
from ..flat.pins import Pins
from ..numeric.triangles import areas, signed_areas
from ..sheet import Sheet
from ..watch import SILENT, Watch
from .island_layout import pack, turn_to_axes
from .islands import Island, find_islands

# Values without a figure are choices; no measurement of them is recorded.
# Free space between islands, as a share of the side of a square of their total area.
_GAP = 0.01
# Paper crumpled by noise has less; half a ball has 15 %.
_MOST_STRETCH = 0.1
_NO_SEAMS = np.zeros((0, 2), np.int64)
_DOWN = np.array([1.0, -1.0])  # between v up, as in UV space, and v down, as on a page
_NO_MAP = "A part bulges or closes so far that it has no flat map: mark more seams to cut it open and unwrap again."


@dataclass(frozen=True)
class Unwrapped:
    """The result of `unwrap`.

    Attributes
    ----------
    uv : (L, 2) array
        At each face corner, v up.
    island : (F,) int array
        Number of the island of each triangle, -1 for triangles without area.
    stretch : (F,) array
        Largest relative change of length in each triangle, relative to the overall scale of its island.
    mean_stretch : float
        The mean of the stretch over the area of the mesh.
    flipped : (F,) bool array
        Which triangles have their outside down in UV space, as where a map folds over.
    """

    uv: Array
    island: Indices
    stretch: Array
    mean_stretch: float
    flipped: NDArray[np.bool_]

    @property
    def most_stretch(self) -> float:
        """The largest change of length in any triangle."""
        return float(self.stretch.max())

    @property
    def warning(self) -> str | None:
        """A warning about the result for the user, with what to do."""
        count = int(self.flipped.sum())
        if count > 0:
            fault = f"The UV map folds over at {count} of {len(self.flipped)} triangles"
        elif self.mean_stretch > _MOST_STRETCH:
            fault = f"The UV map stretches the surface by {100 * self.mean_stretch:.0f} % on average"
        else:
            return None
        return f"{fault}: mark more seams where the surface bulges, or move misplaced pins."


def unwrap(
    vertices: Array,
    corner_vertex: Indices,
    triangles: Indices,
    seams: Indices = _NO_SEAMS,
    *,
    ridges: Sequence[Indices] = (),
    uv: Array | None = None,
    pinned: NDArray[np.bool_] | None = None,
    settings: FlattenSettings | None = None,
    watch: Watch = SILENT,
) -> Unwrapped:
    """Unwrap a mesh, piece by piece.

    Islands are side by side in one scale, not mirrored as seen from outside, with their straight sides along the axes.
    Without pins they fill the unit square. An island with two or more pins takes its place and its scale from them, one
    with a single pin only its place; the others are placed to their right in the same scale.

    Parameters
    ----------
    vertices : (V, 3) array
    corner_vertex : (L,) int array
        The vertex at each face corner.
    triangles : (F, 3) int array
        Face corners, counter-clockwise as seen from outside. All triangles of a face name its corners by the same
        numbers. Corners that no triangle names are left alone.
    seams : (E, 2) int array
        Pairs of vertices.
    ridges : sequence of (K,) int arrays
        Runs of vertices that are straight in the map, for ``settings.ridge_rows``.
    uv : (L, 2) array, optional
        The coordinates so far, needed for pins.
    pinned : (L,) bool array, optional
        Face corners that keep their coordinates exactly.
    settings : FlattenSettings, optional
    watch : Watch

    Returns
    -------
    Unwrapped

    Raises
    ------
    UnusableMesh
        If there is nothing to unwrap, a part has no flat map, or all pins are in one place.

    Examples
    --------
    A square folded along its diagonal:

    >>> corners = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0.5, 0.5**0.5], [0, 1, 0.0]])
    >>> unwrap(corners, np.arange(4), np.array([[0, 1, 3], [1, 2, 3]])).uv.round(6) + 0.0
    array([[0., 0.],
           [1., 0.],
           [1., 1.],
           [0., 1.]])
    """
    settings = settings or FlattenSettings()
    vertices = np.asarray(vertices, float)
    corner_vertex, triangles, seams = (np.asarray(each, np.int64) for each in (corner_vertex, triangles, seams))
    before = np.zeros((len(corner_vertex), 2)) if uv is None else np.asarray(uv, float)
    held = np.zeros(len(corner_vertex), bool) if pinned is None else pinned
    if not np.isfinite(vertices[corner_vertex[triangles]]).all():
        raise UnusableMesh("The mesh has vertices without a place (not a number): delete them and unwrap again.")
    islands = find_islands(vertices, corner_vertex, triangles, seams)
    if not islands:
        raise UnusableMesh("There are no faces with an area to unwrap: select some, or dissolve degenerate ones.")
    pins = [_pins(island, before, held) for island in islands]
    work = np.array([len(island.sheet.triangles) for island in islands])
    ends = np.cumsum(work) / work.sum()
    flat = []
    for island, pin, start, end in zip(islands, pins, ends - work / work.sum(), ends, strict=True):
        sheet = replace(island.sheet, ridges=tuple(_runs_in(island, ridges)))
        flat.append(_flat_island(sheet, pin, settings, watch.part(start, end)))
    flat = _laid_out(islands, flat, pins, _pinned_scale(islands, flat, pins, before, triangles))

    result = before.copy()
    number = np.full(len(triangles), -1)
    stretch = np.zeros(len(triangles))
    flipped = np.zeros(len(triangles), bool)
    for index, (island, places) in enumerate(zip(islands, flat, strict=True)):
        sheet = island.sheet
        result[island.corners] = island.at_corners(places)
        number[island.mesh_triangle] = index
        stretch[island.mesh_triangle] = measure_strain(sheet.vertices, sheet.triangles, places).stretch
        flipped[island.mesh_triangle] = flipped_triangles(sheet.triangles, places * _DOWN)
    result[held] = before[held]
    area = areas(vertices, corner_vertex[triangles])
    return Unwrapped(result, number, stretch, float(area @ stretch / area.sum()), flipped)


def _pins(island: Island, uv: Array, pinned: NDArray[np.bool_]) -> Pins:
    """The pinned vertices of an island; if corners at one vertex are pinned apart, their middle."""
    here = pinned[island.corners] & (island.vertex_of_corner < len(island.sheet.vertices))
    vertex, which, times = np.unique(island.vertex_of_corner[here], return_inverse=True, return_counts=True)
    total = np.zeros((len(vertex), 2))
    np.add.at(total, which.ravel(), uv[island.corners[here]])
    return Pins(vertex, total / times[:, None])


def _runs_in(island: Island, ridges: Sequence[Indices]) -> list[Indices]:
    """Runs of the mesh's vertices as runs of an island's, which end where they leave it or meet a seam inside it."""
    vertex, first, copies = np.unique(island.mesh_vertex, return_index=True, return_counts=True)
    own = dict(zip(vertex[copies == 1].tolist(), first[copies == 1].tolist(), strict=True))
    runs: list[Indices] = []
    for ridge in ridges:
        number = np.array([own.get(int(each), -1) for each in ridge], np.int64)
        pieces = np.split(number, np.flatnonzero(np.diff(number < 0)) + 1)
        runs += [piece for piece in pieces if len(piece) >= 3 and piece[0] >= 0]
    return runs


def _flat_island(sheet: Sheet, pins: Pins, settings: FlattenSettings, watch: Watch) -> Array:
    """The island's vertices (V, 2), v up: in its own unit and any place, or placed by two or more pins."""
    several = len(pins.vertices) > 2
    try:
        flat = flatten(sheet, settings, watch.part(0, 0.5 if several else 1), robust_start=False) * _DOWN
        if len(pins.vertices) >= 2:
            if np.ptp(pins.uv, axis=0).max() == 0:
                raise UnusableMesh("All pins of an island are in one place: move them apart or unpin them.")
            onto = fit_similarity(flat[pins.vertices], pins.uv)
            flat = flat @ onto[:, :2].T + onto[:, 2]
        if several:
            scale = float(np.hypot(*onto[:, 0]))
            own_unit = Pins(pins.vertices, pins.uv / scale * _DOWN)
            flat = flatten(sheet, settings, watch.part(0.5, 1), pins=own_unit, robust_start=False)
            flat = flat * (scale * _DOWN)
    except StepFailed as error:
        raise UnusableMesh(_NO_MAP) from error
    if not np.isfinite(flat).all():
        raise UnusableMesh(_NO_MAP)
    return flat


def _pinned_scale(
    islands: list[Island], flat: list[Array], pins: list[Pins], before: Array, triangles: Indices
) -> float | None:
    """UV units per unit of the mesh: from islands with several pins, otherwise from those with one, or None."""
    held = np.array([len(pin.vertices) for pin in pins])
    if not held.any():
        return None
    several = bool((held >= 2).any())
    on_map, in_space = 0.0, 0.0
    for index in np.flatnonzero(held >= (2 if several else 1)):
        sheet = islands[index].sheet
        now, corners = (flat[index], sheet.triangles) if several else (before, triangles[islands[index].mesh_triangle])
        on_map += float(np.abs(signed_areas(now, corners)).sum())
        in_space += float(areas(sheet.vertices, sheet.triangles).sum())
    # A map without area has no scale: give the new map about the area of the unit square.
    return float(np.sqrt((on_map or 1.0) / in_space))


def _laid_out(islands: list[Island], flat: list[Array], pins: list[Pins], scale: float | None) -> list[Array]:
    """All islands placed by their pins or side by side, in a given scale or otherwise filling the unit square."""
    placed = []
    for island, places, pin in zip(islands, flat, pins, strict=True):
        if len(pin.vertices) < 2:
            places = turn_to_axes(island.sheet, places) * (scale or 1.0)
        if len(pin.vertices) == 1:
            places = places + pin.uv - places[pin.vertices]
        placed.append(places)
    loose = [index for index, pin in enumerate(pins) if len(pin.vertices) == 0]
    if not loose:
        return placed
    extents = np.array([np.ptp(placed[index], axis=0) for index in loose])
    gap = _GAP * float(np.sqrt(extents.prod(1).sum()))
    corner = pack(extents, gap)
    if len(loose) < len(placed):
        fixed = np.vstack([places for places, pin in zip(placed, pins, strict=True) if len(pin.vertices) > 0])
        corner = corner + np.array([fixed[:, 0].max() + gap, fixed[:, 1].min()])
    shrink = 1.0 if scale is not None else float((corner + extents).max())
    for index, place in zip(loose, corner, strict=True):
        placed[index] = (placed[index] - placed[index].min(0) + place) / shrink
    return placed
