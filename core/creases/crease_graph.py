"""The planar graph of a paper's outline and its straight creases.

Measured creases only nearly meet. This module extends them to the paper's edge and to each other, merges points that
are then very close, and merges creases that continue each other. A crease that ends inside the page is continued to the
next line by joins, edges that only divide faces.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..arrays import Array, Indices
from ..numeric.polygon import inside_polygon
from .planar_graph import (
    PlanarGraph,
    arrangement,
    cross,
    inner_faces,
    line_crossings,
    parts,
    without_short_edges,
    without_slight_bends,
)

# Edges that are not numbered creases.
BORDER, JOIN = -1, -2

# Values without a figure are choices; no measurement of them is recorded.
# Shares of the page's longer side: an end of a crease is only known to a few grid steps, and is extended by this much;
_REACH = 0.07
# points nearer together are merged;
_NEAR = 0.015
# and this much is rounding.
_ROUNDING = 1e-7
# A ray leaves its own point behind after this many roundings.
_LEFT_BEHIND = 10
# Sine of the angle below which the crossing of two creases is uncertain.
_SLANT = 0.15


@dataclass(frozen=True)
class CreasePattern:
    """A planar graph on the page.

    Attributes
    ----------
    vertices : (V, 2) array
        u to the right, v down, in the unit of the flat map.
    edges : (E, 2) int array
    line : (E,) int array
        For each edge the index of its crease, `BORDER` or `JOIN`. Creases that continue each other in one line have the
        number of the longest.
    faces : tuple of (K,) int arrays
        The vertices around each, counter-clockwise as the page is read; together they cover the paper.
    """

    vertices: Array
    edges: Indices
    line: Indices
    faces: tuple[Indices, ...]


def arrange(outline: Array, creases: Sequence[Array]) -> CreasePattern:
    """Make the graph of an outline and straight creases.

    Parameters
    ----------
    outline : (K, 2) array
        Corners of a closed polygon that does not touch itself.
    creases : sequence of (2, 2) arrays
        End points. A crease too short to be distinguished from a point gets no edge.
    """
    size = float(np.ptp(outline, axis=0).max())
    sides = np.stack([outline, np.roll(outline, -1, axis=0)], axis=1)
    given = np.array(creases, float).reshape(-1, 2, 2)
    number = np.flatnonzero(np.linalg.norm(given[:, 1] - given[:, 0], axis=1) > _NEAR * size)
    reaching = _reaching(given[number], sides, _REACH * size)
    gaps, before = _gaps(reaching, size)
    number = np.concatenate([number, number[before]])
    lines = np.concatenate([sides, reaching, gaps])
    graph = _with_joins(lines, outline, size)
    border = graph.segment < len(sides)
    graph, faces = without_short_edges(
        graph, inner_faces(graph), _NEAR * size, border, _are_corners(graph.nodes, outline)
    )
    kind = np.digitize(graph.segment, [len(sides), len(lines)])
    graph, faces = without_slight_bends(graph, faces, _NEAR * size, kind, _are_corners(graph.nodes, outline))
    kind = np.digitize(graph.segment, [len(sides), len(lines)])
    line = np.array([BORDER, 0, JOIN])[kind]
    line[kind == 1] = number[graph.segment[kind == 1] - len(sides)]
    return CreasePattern(graph.nodes, graph.edges, line, tuple(faces))


def _are_corners(nodes: Array, outline: Array) -> NDArray[np.bool_]:
    corners = np.zeros(len(nodes), bool)
    corners[cKDTree(nodes).query(outline)[1]] = True
    return corners


def _reaching(creases: Array, sides: Array, reach: float) -> Array:
    """Creases (C, 2, 2) extended to the next side or crease, if their line meets one within reach."""
    if len(creases) == 0:
        return creases
    along = creases[:, 1] - creases[:, 0]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    direction = along / length
    longer = creases + reach * np.stack([-direction, direction], axis=1)
    others = np.concatenate([sides, longer])
    at, where = line_crossings(creases, others), line_crossings(others, creases).T
    with np.errstate(invalid="ignore"):
        rounding = _ROUNDING * reach
        met = (where >= -rounding) & (where <= np.linalg.norm(others[:, 1] - others[:, 0], axis=1) + rounding)
    met[:, len(sides) :] &= np.abs(cross(direction[:, None], direction)) > _SLANT
    moved = creases.copy()
    for end, place, half in ((0, np.zeros_like(length), at < length / 2), (1, length, at > length / 2)):
        gap = np.where(met & half, np.abs(at - place), np.inf)
        nearest = gap.argmin(axis=1)[:, None]
        stop = np.where(np.take_along_axis(gap, nearest, 1) <= reach, np.take_along_axis(at, nearest, 1), place)
        moved[:, end] = creases[:, 0] + stop * direction
    return moved


def _gaps(creases: Array, size: float) -> tuple[Array, Indices]:
    """The gaps between creases that continue each other, (G, 2, 2), and the crease before each gap."""
    ends = creases.reshape(-1, 2)
    heading = (creases[:, ::-1] - creases).reshape(-1, 2)
    heading /= -np.linalg.norm(heading, axis=1, keepdims=True)
    gap = ends - ends[:, None]
    length = np.linalg.norm(gap, axis=2)
    ahead = (gap * heading[:, None]).sum(axis=2) > 0
    in_line = np.abs(cross(heading[:, None], gap)) < _NEAR * size
    found = ahead & ahead.T & in_line & in_line.T & (length < _REACH * size) & (length > _ROUNDING * size)
    one, other = np.nonzero(np.triu(found))
    apart = one // 2 != other // 2
    return np.stack([ends[one[apart]], ends[other[apart]]], axis=1), one[apart] // 2


def _with_joins(lines: Array, outline: Array, size: float) -> PlanarGraph:
    """The graph of lines, the outline's first, with joins that connect it and leave no edge ending inside."""
    graph = _inside(lines, outline, size)
    joins = _joins_of_near(graph, len(outline), size)
    while joins := joins or _joins_of_ends(graph, size) or _joins_of_islands(graph, size):
        lines = np.concatenate([lines, joins])
        graph, joins = _inside(lines, outline, size), []
    return graph


def _inside(lines: Array, outline: Array, size: float) -> PlanarGraph:
    graph = arrangement(lines, _ROUNDING * size)
    within = inside_polygon(graph.nodes[graph.edges].mean(axis=1), outline) | (graph.segment < len(outline))
    return replace(graph, edges=graph.edges[within], segment=graph.segment[within])


def _joins_of_near(graph: PlanarGraph, sides: int, size: float) -> list[Array]:
    """The shortest way from each node to each line that it nearly touches: short edges are contracted later."""
    border = graph.segment < sides
    on_border = np.isin(np.arange(len(graph.nodes)), graph.edges[border])
    start, end = graph.nodes[graph.edges].swapaxes(0, 1)
    along, offset = end - start, graph.nodes[:, None] - start
    share = np.clip((offset * along).sum(axis=2) / (along**2).sum(axis=1), 0, 1)
    foot = start + share[..., None] * along
    distance = np.linalg.norm(graph.nodes[:, None] - foot, axis=2)
    distance[on_border[:, None] & border] = np.inf
    joins = []
    for line in np.unique(graph.segment):
        edges = np.flatnonzero(graph.segment == line)
        nearest = edges[distance[:, edges].argmin(axis=1)]
        gap = distance[np.arange(len(graph.nodes)), nearest]
        for node in np.flatnonzero((gap > _ROUNDING * size) & (gap < _NEAR * size)):
            joins.append(np.stack([graph.nodes[node], foot[node, nearest[node]]]))
    return joins


def _joins_of_ends(graph: PlanarGraph, size: float) -> list[Array]:
    """A join for each end of a crease inside the page: straight on, to the end of another crease or the next line."""
    ends = np.flatnonzero(np.bincount(graph.edges.ravel(), minlength=len(graph.nodes)) == 1)
    joins = []
    for end in ends:
        (edge,) = graph.edges[(graph.edges == end).any(axis=1)]
        heading = graph.nodes[end] - graph.nodes[edge[edge != end][0]]
        heading /= np.linalg.norm(heading)
        stop = _next_line(graph, graph.nodes[end], heading, size)
        offset = graph.nodes[ends] - graph.nodes[end]
        ahead = offset @ heading
        in_line = (np.abs(cross(heading, offset)) < _NEAR * size) & (ahead > _ROUNDING * size)
        in_line &= ahead < (stop - graph.nodes[end]) @ heading
        if in_line.any():
            stop = graph.nodes[ends[np.where(in_line, ahead, np.inf).argmin()]]
        joins.append(np.stack([graph.nodes[end], stop]))
    return joins


def _joins_of_islands(graph: PlanarGraph, size: float) -> list[Array]:
    """A join to the right for each part of the graph that is not connected to the paper's edge."""
    part = parts(graph)
    used = np.unique(graph.edges)
    joins = []
    for island in np.unique(part[used]):
        if island != part[graph.edges[0, 0]]:  # the first edge is one of the paper's
            nodes = graph.nodes[used[part[used] == island]]
            rightmost = nodes[nodes[:, 0].argmax()]
            joins.append(np.stack([rightmost, _next_line(graph, rightmost, np.array([1.0, 0.0]), size)]))
    return joins


def _next_line(graph: PlanarGraph, origin: Array, heading: Array, size: float) -> Array:
    """The first point of the graph that a ray from inside the page meets."""
    ray = np.stack([origin, origin + heading])[None]
    edges = graph.nodes[graph.edges]
    distance, place = line_crossings(ray, edges)[0], line_crossings(edges, ray)[:, 0]
    length = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    rounding = _ROUNDING * size
    with np.errstate(invalid="ignore"):
        met = (distance > _LEFT_BEHIND * rounding) & (place >= -rounding) & (place <= length + rounding)
    return np.asarray(origin + np.where(met, distance, np.inf).min() * heading)
