"""Per-triangle geometry shared by the flatteners."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from ..arrays import Array, Indices


def local_coordinates(vertices: Array, triangles: Indices) -> Array:
    """Each triangle laid into its own plane (the paper's Fig. 4).

    Returns
    -------
    (F, 3, 2) array
        First corner at the origin, second on the positive x axis, third above it.
    """
    corners = vertices[triangles]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    length = np.linalg.norm(first, axis=1)
    x = (first * second).sum(1) / length
    y = np.linalg.norm(np.cross(first, second), axis=1) / length
    zero = np.zeros_like(length)
    return np.stack([np.stack([zero, zero], 1), np.stack([length, zero], 1), np.stack([x, y], 1)], axis=1)


def areas(vertices: Array, triangles: Indices) -> Array:
    """Area of each triangle, shape (F,)."""
    corners = vertices[triangles]
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2


def signed_areas(flat: Array, triangles: Indices) -> Array:
    """Area of each triangle in the plane, positive where it turns from the first axis to the second, shape (F,)."""
    corners = flat[triangles]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2


def gradient_rows(vertices: Array, triangles: Indices) -> tuple[sparse.csr_array, sparse.csr_array]:
    """Gradient of a function of the vertices along each triangle's local axes.

    With corners ``(X_i, Y_i)`` and area S these are the rows ``-dY_i / 2S`` and ``dX_i / 2S`` from which Eq. 13 is
    made.

    Returns
    -------
    along_x, along_y : (F, V) sparse arrays
    """
    local = local_coordinates(vertices, triangles)
    delta = np.roll(local, -2, axis=1) - np.roll(local, -1, axis=1)
    twice_area = (local[:, 1, 0] * local[:, 2, 1])[:, None]
    pointer = np.arange(0, triangles.size + 1, 3)
    shape = (len(triangles), len(vertices))
    along_x = sparse.csr_array(((-delta[..., 1] / twice_area).ravel(), triangles.ravel(), pointer), shape=shape)
    along_y = sparse.csr_array(((delta[..., 0] / twice_area).ravel(), triangles.ravel(), pointer), shape=shape)
    return along_x, along_y


def directed_edges(triangles: Indices) -> Indices:
    """All sides of all triangles, (3F, 2): first to second corner of each, then second to third, third to first."""
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


def interior_edges(triangles: Indices) -> tuple[Indices, Indices]:
    """Edges shared by two triangles.

    Returns
    -------
    edges : (E, 2) int array
    opposite : (E, 2) int array
        The third corner of the triangle on either side.
    """
    edges, sides = _shared_sides(triangles)
    return edges, np.roll(triangles, -2, axis=1).ravel()[sides]


def triangle_pairs(triangles: Indices) -> tuple[Indices, Indices]:
    """Edges shared by two triangles.

    Returns
    -------
    edges : (E, 2) int array
        As from `interior_edges`.
    pairs : (E, 2) int array
        The triangle on either side.
    """
    edges, sides = _shared_sides(triangles)
    return edges, sides // 3


def _shared_sides(triangles: Indices) -> tuple[Indices, Indices]:
    """The edges (E, 2) shared by two triangles, and the two sides (E, 2), numbered triangle by triangle."""
    start = triangles.ravel()
    end = np.roll(triangles, -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.lexsort((high, low))
    same = (low[order][1:] == low[order][:-1]) & (high[order][1:] == high[order][:-1])
    sides = np.stack([order[:-1][same], order[1:][same]], axis=1)
    return np.stack([low[sides[:, 0]], high[sides[:, 0]]], axis=1), sides


def rim(triangles: Indices) -> Indices:
    """Directed edges (E, 2) that belong to one triangle only."""
    edges = directed_edges(triangles)
    count = int(triangles.max()) + 1
    key, opposite = edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0]
    return edges[~np.isin(key, opposite)]


def closed_loops(triangles: Indices) -> list[Indices]:
    """The vertices along each edge of a mesh, in order; no vertex may be on two edges or twice on one."""
    following = dict(rim(triangles).tolist())
    loops = []
    while following:
        first, vertex = following.popitem()
        loop = [first]
        while vertex != first:
            loop.append(vertex)
            vertex = following.pop(vertex)
        loops.append(np.array(loop, dtype=np.int64))
    return loops


def parts(triangles: Indices) -> Indices:
    """Number, from 0, of the edge-connected part of each triangle, (F,)."""
    ends = np.sort(directed_edges(triangles), axis=1)
    _, edge = np.unique(ends[:, 0] * (int(triangles.max()) + 1) + ends[:, 1], return_inverse=True)
    owner = np.tile(np.arange(len(triangles)), 3)
    incidence = sparse.csr_array((np.ones(len(owner)), (owner, edge.ravel())))
    return connected_components(incidence @ incidence.T, directed=False)[1].astype(np.int64)


def one_part(triangles: Indices) -> bool:
    """Whether all triangles are connected by edges."""
    return bool((parts(triangles) == 0).all())
