"""A mesh cut open at its seams: every vertex there gets a copy on either side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from ..arrays import Array, Indices
from ..numeric.triangles import areas

# Edges shorter than this share of the mesh's size join two copies of one vertex.
_SAME_PLACE = 1e-7


@dataclass(frozen=True)
class Cut:
    """A mesh after cutting.

    Attributes
    ----------
    vertex : (W,) int array
        The vertex of the mesh of which each vertex is a copy.
    corner : (L,) int array
        The vertex at each face corner; -1 if no triangle has the corner, or only one that is a line or a point.
    kept : (T,) int array
        Which triangles of the mesh have three vertices in different places. The other arrays are about these.
    triangles : (T, 3) int array
        Their vertices, counter-clockwise as most of their piece is seen from outside.
    piece : (T,) int array
        Number of the piece of each, in the order of the pieces' first triangles.
    one_sided : (T,) bool array
        Whether that piece has no inside and outside.
    """

    vertex: Indices
    corner: Indices
    kept: Indices
    triangles: Indices
    piece: Indices
    one_sided: NDArray[np.bool_]


def cut_at_seams(vertices: Array, corner_vertex: Indices, triangles: Indices, seams: Indices) -> Cut:
    """Cut a mesh at its seams, and at edges where more than two triangles meet.

    Parameters
    ----------
    vertices : (V, 3) array
    corner_vertex : (L,) int array
        The vertex at each face corner.
    triangles : (F, 3) int array
        Face corners; the triangles of one face share some.
    seams : (E, 2) int array
        Pairs of vertices.
    """
    place = _places(vertices, corner_vertex[triangles])
    corner_place = place[corner_vertex]
    kept = np.flatnonzero((np.diff(np.sort(corner_place[triangles], axis=1), axis=1) > 0).all(1))
    corners = triangles[kept]
    one, other = _hinges(corner_place[corners], place[seams.reshape(-1, 2)], len(vertices))

    # Sides of triangles are numbered by the corner where they start; if two meet, so do the corners at both ends.
    after = np.arange(corners.size).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    start = corner_place[corners].ravel()
    opposed = start[one] != start[other]
    met = np.where(opposed, after[other], other), np.where(opposed, other, after[other])
    first_use = np.unique(corners.ravel(), return_index=True, return_inverse=True)
    same_corner = first_use[1][first_use[2].ravel()]
    copy = _components(
        corners.size,
        np.concatenate([one, after[one], np.arange(corners.size)]),
        np.concatenate([*met, same_corner]),
    )

    count = len(corners)
    turned, piece, one_sided = _outsides(
        count,
        np.concatenate([one, np.arange(corners.size)]) // 3,
        np.concatenate([other, same_corner]) // 3,
        np.concatenate([opposed, np.ones(corners.size, bool)]),
        areas(vertices, corner_vertex[corners]),
    )
    cut = copy.reshape(-1, 3)
    cut = np.where(turned[:, None], cut[:, ::-1], cut)
    vertex = np.empty(int(copy.max(initial=-1)) + 1, np.int64)
    vertex[copy] = start
    return Cut(vertex, _at_corners(corner_place, triangles, corners, copy, vertex), kept, cut, piece, one_sided)


def _components(count: int, one: Indices, other: Indices) -> Indices:
    links = sparse.coo_array((np.ones(len(one), bool), (one, other)), shape=(count, count))
    return connected_components(links, directed=False)[1].astype(np.int64)


def _places(vertices: Array, triangles: Indices) -> Indices:
    """For each vertex the first one that is in the same place and connected to it by edges."""
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    size = np.sqrt(areas(vertices, triangles).sum())
    short = np.linalg.norm(vertices[start] - vertices[end], axis=1) <= _SAME_PLACE * size
    group = _components(len(vertices), start[short], end[short])
    return np.unique(group, return_index=True)[1][group].astype(np.int64)


def _hinges(triangles: Indices, seams: Indices, count: int) -> tuple[Indices, Indices]:
    """Pairs of triangle sides, as indices into the flattened array, that are one edge of the mesh and not a seam."""

    def key(pairs: Indices) -> Indices:
        return pairs.min(1) * count + pairs.max(1)

    edge = key(np.stack([triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()], axis=1))
    order = np.argsort(edge, kind="stable")
    first, times = np.unique(edge[order], return_index=True, return_counts=True)[1:]
    first = first[times == 2]
    one, other = order[first], order[first + 1]
    whole = ~np.isin(edge[one], key(seams))
    return one[whole], other[whole]


def _outsides(
    count: int, one: Indices, other: Indices, alike: NDArray[np.bool_], area: Array
) -> tuple[NDArray[np.bool_], Indices, NDArray[np.bool_]]:
    """Which triangles to turn over to give each piece one outside, the pieces, and which have no outside.

    Every triangle is used twice, as it is and turned over; ``one`` and ``other`` are pairs of neighbours, ``alike``
    where both face the same way. A piece with an outside falls into two halves, of which the one with more area of
    unturned triangles is right.
    """
    side = _components(
        2 * count,
        np.concatenate([one, one + count]),
        np.concatenate([np.where(alike, other, other + count), np.where(alike, other + count, other)]),
    )
    as_is, over = side[:count], side[count:]
    unturned = np.bincount(as_is, weights=area, minlength=int(side.max(initial=-1)) + 1)
    turned = unturned[as_is] < unturned[over]
    tie = unturned[as_is] == unturned[over]
    turned |= tie & (as_is > over)
    piece = np.unique(np.minimum(as_is, over), return_inverse=True)[1].ravel().astype(np.int64)
    return turned, piece, as_is == over


def _at_corners(place: Indices, triangles: Indices, kept: Indices, copy: Indices, vertex: Indices) -> Indices:
    """The vertex at each corner; a corner that only belongs to lines takes any copy of its vertex."""
    at_place = np.full(int(place.max(initial=-1)) + 1, -1)
    at_place[vertex[::-1]] = np.arange(len(vertex))[::-1]
    at_corner = np.full(len(place), -1)
    at_corner[triangles] = at_place[place[triangles]]
    at_corner[kept.ravel()] = copy
    return at_corner
