"""Straight segments as a planar graph: split where they meet, with the faces between them, and without short edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..arrays import Array, Indices
from ..numeric.polygon import signed_area

# Sine of the angle below which two segments count as parallel; if they overlap, their ends meet the other.
_PARALLEL = 1e-9


@dataclass(frozen=True)
class PlanarGraph:
    """Nodes joined by straight edges that meet only at nodes.

    Attributes
    ----------
    nodes : (V, 2) array
    edges : (E, 2) int array
    segment : (E,) int array
        The segment to which each edge belongs; the first one if several overlap.
    """

    nodes: Array
    edges: Indices
    segment: Indices


def cross(first: Array, second: Array) -> Array:
    """The z component of the cross product of plane vectors (..., 2)."""
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def arrangement(segments: Array, tolerance: float) -> PlanarGraph:
    """Split segments where they cross, touch or end on each other.

    Parameters
    ----------
    segments : (S, 2, 2) array
        End points.
    tolerance : float
        Points no farther apart are merged; for rounding, not for measurement errors.
    """
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    length = np.linalg.norm(along, axis=1)
    crossing = line_crossings(segments, segments)
    reach = length + tolerance
    with np.errstate(invalid="ignore"):
        on_first = (crossing >= -tolerance) & (crossing <= reach[:, None])
    owner, other = np.nonzero(on_first & on_first.T)
    place = crossing[owner, other]
    points = [start[owner] + (place / length[owner])[:, None] * along[owner]]
    owners, places = [owner], [place]
    for end in (0, 1):
        offset = segments[None, :, end] - start[:, None]
        at = (offset * along[:, None]).sum(2) / length[:, None]
        off = np.abs(cross(offset, along[:, None])) / length[:, None]
        owner, other = np.nonzero((off <= tolerance) & (at >= -tolerance) & (at <= reach[:, None]))
        points.append(segments[other, end])
        owners.append(owner)
        places.append(at[owner, other])
    nodes, node = _one_where_near(np.concatenate(points), tolerance)
    owner, place = np.concatenate(owners), np.concatenate(places)
    order = np.lexsort((place, owner))
    owner, node = owner[order], node[order]
    pairs = np.stack([node[:-1], node[1:]], axis=1)
    real = (owner[:-1] == owner[1:]) & (pairs[:, 0] != pairs[:, 1])
    return _each_edge_once(nodes, pairs[real], owner[:-1][real])


def line_crossings(segments: Array, others: Array) -> Array:
    """Where the lines through ``segments`` (S, 2, 2) cross those through ``others`` (T, 2, 2).

    Returns
    -------
    (S, T) array
        Distance from the segment's start, NaN for parallel lines.
    """
    start, along = segments[:, None, 0], (segments[:, 1] - segments[:, 0])[:, None]
    start_other, along_other = others[None, :, 0], (others[:, 1] - others[:, 0])[None]
    length, length_other = np.linalg.norm(along, axis=2), np.linalg.norm(along_other, axis=2)
    determinant = cross(along, along_other)
    parallel = np.abs(determinant) <= _PARALLEL * length * length_other
    share = cross(start_other - start, along_other) / np.where(parallel, np.nan, determinant)
    return np.asarray(share * length)


def parts(graph: PlanarGraph) -> Indices:
    """Number of the connected part of each node, (V,)."""
    count = len(graph.nodes)
    links = sparse.csr_array((np.ones(len(graph.edges)), graph.edges.T), shape=(count, count))
    return connected_components(links, directed=False)[1].astype(np.int64)


def inner_faces(graph: PlanarGraph) -> list[Indices]:
    """Nodes around each bounded face of a connected graph, counter-clockwise as seen with the second axis down."""
    heading = graph.nodes[graph.edges[:, 1]] - graph.nodes[graph.edges[:, 0]]
    both = np.concatenate([graph.edges, graph.edges[:, ::-1]])
    heading = np.concatenate([heading, -heading])
    around: dict[int, list[int]] = {}
    for index in np.argsort(np.arctan2(heading[:, 1], heading[:, 0])):
        around.setdefault(int(both[index, 0]), []).append(int(both[index, 1]))
    # Arriving at b from a, the face continues along the edge of b next to the one to a, in the direction of increasing
    # angles.
    following = {
        (a, b): (b, ends[(place + 1) % len(ends)]) for b, ends in around.items() for place, a in enumerate(ends)
    }
    faces = []
    while following:
        first, edge = following.popitem()
        face = [first[0]]
        while edge != first:
            face.append(edge[0])
            edge = following.pop(edge)
        loop = np.array(face, np.int64)
        if signed_area(graph.nodes[loop]) < 0:
            faces.append(loop)
    return faces


def without_short_edges(
    graph: PlanarGraph, faces: list[Indices], shortest: float, border: NDArray[np.bool_], corners: NDArray[np.bool_]
) -> tuple[PlanarGraph, list[Indices]]:
    """Contract short edges, the shortest first; faces that consist only of short edges vanish.

    The graph's border keeps its shape: its corners are never merged, and its nodes only along it.

    Parameters
    ----------
    graph : PlanarGraph
    faces : list of int arrays
    shortest : float
        The length below which an edge is short.
    border : (E,) bool array
    corners : (V,) bool array
    """
    rank = corners.astype(np.int64)
    rank[np.unique(graph.edges[border])] += 1
    nodes, became = graph.nodes.copy(), np.arange(len(graph.nodes))
    while True:
        first, second = edges = became[graph.edges].T
        length = np.linalg.norm(nodes[first] - nodes[second], axis=1)
        lower = np.minimum(rank[first], rank[second])
        length[(first == second) | (lower == 2) | ((lower == 1) & ~border)] = np.inf
        if not (length < shortest).any():
            break
        keep, drop = sorted(edges[:, length.argmin()].tolist(), key=lambda node: -rank[node])
        if rank[keep] == rank[drop]:
            nodes[keep] = (nodes[keep] + nodes[drop]) / 2
        became[became == drop] = keep
    real = first != second
    faces = [became[face] for face in faces]
    faces = [face[face != np.roll(face, 1)] for face in faces]
    graph = _each_edge_once(nodes, edges.T[real], graph.segment[real])
    return _renumbered(graph, [face for face in faces if len(face) > 2])


def without_slight_bends(
    graph: PlanarGraph, faces: list[Indices], most: float, kind: Indices, corners: NDArray[np.bool_]
) -> tuple[PlanarGraph, list[Indices]]:
    """Merge two edges that continue each other into one, which then belongs to the longer one's segment.

    Parameters
    ----------
    graph : PlanarGraph
    faces : list of int arrays
    most : float
        Largest distance of the node between them from the merged edge.
    kind : (E,) int array
        Only edges of the same kind are joined.
    corners : (V,) bool array
        Nodes that stay.
    """
    edges = graph.edges.copy()
    keep = np.ones(len(edges), bool)
    for node in np.flatnonzero(~corners):
        around = np.flatnonzero((edges == node).any(axis=1) & keep)
        if len(around) != 2 or kind[around[0]] != kind[around[1]]:
            continue
        ends = edges[around][edges[around] != node]
        lines = graph.nodes[ends] - graph.nodes[node]
        chord = lines[1] - lines[0]
        bent = np.abs(cross(lines[0], chord)) > most * np.linalg.norm(chord) or lines[0] @ lines[1] >= 0
        if bent or (keep & (edges == np.sort(ends)).all(axis=1)).any():
            continue
        shorter, longer = around[np.argsort(np.linalg.norm(lines, axis=1))]
        edges[longer], keep[shorter] = np.sort(ends), False
        faces = [face[face != node] for face in faces]
    return _renumbered(PlanarGraph(graph.nodes, edges[keep], graph.segment[keep]), faces)


def _renumbered(graph: PlanarGraph, faces: list[Indices]) -> tuple[PlanarGraph, list[Indices]]:
    """The graph without the nodes that no edge uses."""
    used, edges = np.unique(graph.edges, return_inverse=True)
    number = np.zeros(len(graph.nodes), np.int64)
    number[used] = np.arange(len(used))
    return (
        PlanarGraph(graph.nodes[used], edges.reshape(-1, 2).astype(np.int64), graph.segment),
        [number[face] for face in faces],
    )


def _one_where_near(points: Array, tolerance: float) -> tuple[Array, Indices]:
    """Points after merging coincident ones, and the new number of each old point."""
    # most only differ by rounding and would give very many pairs
    _, first, cell = np.unique(np.rint(points / tolerance), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    first, cell = first[order], np.argsort(order)[cell.ravel()]
    pairs = cKDTree(points[first]).query_pairs(tolerance, output_type="ndarray")
    links = sparse.csr_array((np.ones(len(pairs)), pairs.T), shape=(len(first), len(first)))
    group = connected_components(links, directed=False)[1].astype(np.int64)
    return points[first[np.unique(group, return_index=True)[1]]], group[cell]


def _each_edge_once(nodes: Array, edges: Indices, segment: Indices) -> PlanarGraph:
    order = np.argsort(segment, kind="stable")
    edges = np.sort(edges, axis=1)[order]
    _, first = np.unique(edges, axis=0, return_index=True)
    first = np.sort(first)
    return PlanarGraph(nodes, edges[first], segment[order][first])
