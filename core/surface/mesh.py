"""The triangle mesh of the sheet: it ends at the paper's edge and has edges along the creases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, cKDTree

from ..arrays import Array, Indices
from ..numeric.polygon import inside_polygon
from ..numeric.triangles import closed_loops, parts, rim, signed_areas
from ..sheet import Sheet
from .surface import Surface

# Values without a figure are choices; no measurement of them is recorded.
# Grid nodes nearer than this (in steps) to the outline or a crease are dropped in favour of the vertices there.
_CLEARANCE = 0.6
# Vertices along the outline and creases are denser than the grid's, which makes the Delaunay triangles follow them.
_LINE_SPACING = 0.7
# Creases that end this near to the outline end on it, in the spacing of its vertices.
_ON_EDGE = 0.1
# A corner of the outline, which the mesh keeps, turns by at least this.
_LEAST_CORNER = np.radians(20)
# Area of a triangle, relative to the square of its longest side, below which it is slim and left out.
_SLIM = 5e-4


@dataclass(frozen=True)
class PlaneMesh:
    """A triangulation of the paper's region in the reference view.

    Attributes
    ----------
    positions : (V, 2) array
        Plane coordinates.
    triangles : (F, 3) int array
        All oriented from the x axis to the y axis.
    lines : tuple of (K,) int arrays
        The vertices along each crease.
    boundary : (B,) int array
        The vertices along the outline.
    """

    positions: Array
    triangles: Indices
    lines: tuple[Indices, ...]
    boundary: Indices


def build_sheet(surface: Surface, polygon: Array, creases: list[Array]) -> Sheet:
    """Cut the sheet out of the surface.

    Parameters
    ----------
    surface : Surface
    polygon : (K, 2) array
        The paper's outline in the reference view, distorted pixels.
    creases : list of (2, 2) arrays
        End points of straight creases, plane coordinates of the surface's frame.
    """
    grid = surface.grid
    mesh = triangulate(grid.frame.from_pixels(polygon), creases, grid.step, grid.node_positions())
    # Pixels have y downwards: the camera sees the triangles as clockwise.
    return Sheet(surface.at(mesh.positions), mesh.triangles[:, ::-1], mesh.lines, mesh.boundary)


def triangulate(polygon: Array, creases: list[Array], step: float, nodes: Array) -> PlaneMesh:
    """Triangulate the inside of an outline with vertices along it, along the creases and at grid nodes.

    Parameters
    ----------
    polygon : (K, 2) array
        Closed outline.
    creases : list of (2, 2) arrays
        End points of straight creases.
    step : float
        Grid step.
    nodes : (N, 2) array
        Positions of the grid nodes.
    """
    spacing = _LINE_SPACING * step
    edge = _along_closed(polygon, spacing, np.concatenate([np.zeros((0, 2)), *creases]))
    runs = [_along(crease, spacing) for crease in creases]
    runs = [run[_clear_of(run, edge, 0.5 * spacing) & inside_polygon(run, edge)] for run in runs]
    positions, lines = _weld(edge, runs, creases, 0.5 * spacing)
    inner = nodes[inside_polygon(nodes, polygon)]
    inner = inner[_clear_of(inner, positions, _CLEARANCE * step)]
    positions = np.vstack([positions, inner])
    triangles = _without_pinches(_delaunay_inside(positions, polygon))
    return _drop_unused(PlaneMesh(positions, triangles, lines, max(closed_loops(triangles), key=len)))


def _along_closed(polygon: Array, spacing: float, ends: Array) -> Array:
    """Resample a closed polygon (K, 2), with a vertex at each of its corners and of the ``ends`` (E, 2) that lie on it.

    Otherwise a crease would bend towards the nearest vertex just before the paper's edge.
    """
    closed = np.vstack([polygon, polygon[:1]])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    at = np.linspace(0, length[-1], max(round(length[-1] / spacing), 3) + 1)[:-1]
    place, gap = _nearest_place(polygon, length, ends)
    free = np.ones(len(at), bool)
    for each in (*length[:-1][_turns(polygon)], *place[gap < _ON_EDGE * spacing]):
        apart = np.abs(at - each)
        nearest = int(np.argmin(np.minimum(apart, length[-1] - apart)))
        if free[nearest]:
            at[nearest] = each
        free[nearest] = False
    at = np.unique(at)
    return np.stack([np.interp(at, length, closed[:, 0]), np.interp(at, length, closed[:, 1])], axis=1)


def _nearest_place(polygon: Array, length: Array, points: Array) -> tuple[Array, Array]:
    """How far along a closed polygon the place nearest to each point (E, 2) is, and how far away from the point."""
    side = np.roll(polygon, -1, axis=0) - polygon
    squared = np.maximum((side**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(((points[:, None] - polygon) * side).sum(axis=2) / squared, 0, 1)
    gaps = np.linalg.norm(polygon + share[..., None] * side - points[:, None], axis=2)
    nearest = gaps.argmin(axis=1)
    each = np.arange(len(points))
    return length[nearest] + share[each, nearest] * np.sqrt(squared[nearest]), gaps[each, nearest]


def _turns(polygon: Array) -> NDArray[np.bool_]:
    """Vertices at which a closed polygon turns by more than `_LEAST_CORNER`."""
    before, after = polygon - np.roll(polygon, 1, axis=0), np.roll(polygon, -1, axis=0) - polygon
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.abs(np.arctan2(cross, (before * after).sum(1))) > _LEAST_CORNER


def _along(segment: Array, spacing: float) -> Array:
    count = max(round(float(np.linalg.norm(segment[1] - segment[0])) / spacing), 1)
    return segment[0] + np.linspace(0, 1, count + 1)[:, None] * (segment[1] - segment[0])


def _clear_of(points: Array, others: Array, distance: float) -> NDArray[np.bool_]:
    return cKDTree(others).query(points)[0] > distance


def _weld(edge: Array, runs: list[Array], creases: list[Array], distance: float) -> tuple[Array, tuple[Indices, ...]]:
    """Join the creases' vertices where creases meet, and put the ends of each crease on the outline if it is near."""
    positions = [edge]
    total = len(edge)
    lines = []
    for run, ends in zip(runs, creases, strict=True):
        if len(run) < 2:
            continue
        existing = np.vstack(positions)
        gap, near = cKDTree(existing).query(run)
        fresh = gap > distance
        index = np.where(fresh, total + np.cumsum(fresh) - 1, near)
        positions.append(run[fresh])
        total += int(fresh.sum())
        lines.append(_joined_to_edge(index, run, ends, edge))
    return np.vstack(positions), tuple(lines)


def _joined_to_edge(index: Indices, run: Array, ends: Array, edge: Array) -> Indices:
    spacing = float(np.median(np.linalg.norm(np.diff(run, axis=0), axis=1)))
    near = cKDTree(edge).query(ends)[1]
    gap = np.linalg.norm(edge[near] - run[[0, -1]], axis=1)
    first, last = (near[[k]] if gap[k] < 2 * spacing else np.empty(0, int) for k in (0, 1))
    joined = np.concatenate([first, index, last])
    return joined[np.concatenate([[True], np.diff(joined) != 0])]


def _delaunay_inside(positions: Array, polygon: Array) -> Indices:
    triangles = Delaunay(positions).simplices
    area = signed_areas(positions, triangles)
    triangles = np.where(area[:, None] < 0, triangles[:, ::-1], triangles)
    corners = positions[triangles]
    longest = np.sqrt(((corners - np.roll(corners, 1, axis=1)) ** 2).sum(2)).max(1)
    slim = np.abs(area) < _SLIM * longest**2
    inside = inside_polygon(corners.mean(1), polygon)
    return triangles[inside & ~slim].astype(np.int64)


def _without_pinches(triangles: Indices) -> Indices:
    """The largest edge-connected part, without vertices at which it only touches itself."""
    while True:
        triangles = _largest_part(triangles)
        start, times = np.unique(rim(triangles)[:, 0], return_counts=True)
        pinched = start[times > 1]
        if len(pinched) == 0:
            return triangles
        keep = np.ones(len(triangles), bool)
        for vertex in pinched:
            around = np.flatnonzero((triangles == vertex).any(1))
            fan = parts(triangles[around])
            keep[around[fan != np.argmax(np.bincount(fan))]] = False
        triangles = triangles[keep]


def _largest_part(triangles: Indices) -> Indices:
    part = parts(triangles)
    return triangles[part == np.argmax(np.bincount(part))]


def _drop_unused(mesh: PlaneMesh) -> PlaneMesh:
    """Remove vertices that no triangle uses and renumber."""
    used = np.zeros(len(mesh.positions), bool)
    used[mesh.triangles] = True
    number = np.cumsum(used) - 1
    lines = tuple(number[line[used[line]]] for line in mesh.lines)
    return PlaneMesh(mesh.positions[used], number[mesh.triangles], lines, number[mesh.boundary])
