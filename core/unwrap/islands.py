"""The islands of an unwrapping: pieces of a mesh between seams, each a sheet that can be flattened."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from ..arrays import Array, Indices
from ..errors import UnusableMesh
from ..flat.sides import edge_turning
from ..numeric.triangles import areas, closed_loops, parts
from ..sheet import Sheet
from .seams import Cut, cut_at_seams

# A triangle lower than this share of its longest side counts as a line.
_NO_HEIGHT = 1e-5
# The edge of a hole turns by -360 degrees within the surface, the far end of a tube not at all. Halfway is a cone of 30
# degrees half angle, whose least strained map still stretches it by 13 % (root mean square).
_LEAST_HOLE_TURN = np.pi


@dataclass(frozen=True)
class Island:
    """A piece of a mesh between seams.

    Attributes
    ----------
    sheet : Sheet
        The piece as seen from outside, with separate vertices on either side of a seam and without triangles that have
        no area. Its boundary is the outer one.
    hanging : tuple of (int, int, float)
        Vertices that only belong to triangles without area, numbered after the sheet's: each is on the line through two
        earlier ones, the given share of the way from the first to the second.
    mesh_vertex : (V,) int array
        The vertex of the mesh of which each of the sheet's is a copy.
    mesh_triangle : (F,) int array
        The triangle of the mesh for each of the sheet's.
    corners : (C,) int array
        The face corners of the mesh that belong to the piece.
    vertex_of_corner : (C,) int array
        The vertex at each of them, of the sheet or hanging.
    """

    sheet: Sheet
    hanging: tuple[tuple[int, int, float], ...]
    mesh_vertex: Indices
    mesh_triangle: Indices
    corners: Indices
    vertex_of_corner: Indices

    def at_corners(self, flat: Array) -> Array:
        """A flat map (V, 2) of the sheet at each of ``corners``, (C, 2)."""
        places = list(flat)
        for start, end, share in self.hanging:
            places.append((1 - share) * places[start] + share * places[end])
        return np.array(places)[self.vertex_of_corner]


def find_islands(vertices: Array, corner_vertex: Indices, triangles: Indices, seams: Indices) -> list[Island]:
    """Cut a mesh at its seams, and where more than two triangles meet, into pieces that can be flattened.

    Parameters
    ----------
    vertices : (V, 3) array
    corner_vertex : (L,) int array
        The vertex at each face corner.
    triangles : (F, 3) int array
        Face corners; the triangles of one face share some.
    seams : (E, 2) int array
        Pairs of vertices.

    Returns
    -------
    list of Island
        In the order of their first triangles. Pieces without any area are left out.

    Raises
    ------
    UnusableMesh
        If a piece is closed, a tube, has a handle or one side only, or is only connected by triangles without area.
    """
    cut = cut_at_seams(vertices, corner_vertex, triangles, seams)
    pieces = _groups(cut.piece)
    piece_of_vertex = np.empty(len(cut.vertex), np.int64)
    piece_of_vertex[cut.triangles] = cut.piece[:, None]
    has_vertex = np.flatnonzero(cut.corner >= 0)
    corners = [has_vertex[group] for group in _groups(piece_of_vertex[cut.corner[has_vertex]])]
    islands = []
    for piece, own_corners in zip(pieces, corners, strict=True):
        name = "The mesh" if len(pieces) == 1 else f"The part at vertex {cut.vertex[cut.triangles[piece[0], 0]]}"
        island = _island(vertices, cut, piece, own_corners, name)
        if island is not None:
            islands.append(island)
    return islands


def _groups(label: Indices) -> list[Indices]:
    """The places of each label, which are 0, 1, 2 and so on."""
    if len(label) == 0:
        return []
    return np.split(np.argsort(label, kind="stable"), np.cumsum(np.bincount(label))[:-1])


def _island(vertices: Array, cut: Cut, piece: Indices, corners: Indices, name: str) -> Island | None:
    if cut.one_sided[piece[0]]:
        raise UnusableMesh(f"{name} has only one side, like a twisted ring: mark a seam across it and unwrap again.")
    used, triangles = np.unique(cut.triangles[piece], return_inverse=True)
    triangles = triangles.reshape(-1, 3)
    whole = Sheet(vertices[cut.vertex[used]], triangles, (), np.zeros(0, np.int64))
    boundary = _outer_edge(whole, name)

    side = np.linalg.norm(np.roll(whole.vertices[triangles], 1, axis=1) - whole.vertices[triangles], axis=2)
    solid = 2 * areas(whole.vertices, triangles) > _NO_HEIGHT * side.max(1) ** 2
    if not solid.any():
        return None
    kept = np.unique(triangles[solid])
    number = np.full(len(used), -1)
    number[kept] = np.arange(len(kept))
    hanging = _hang(whole.vertices, triangles[~solid], number)
    if (number < 0).any() or not _held_together(triangles[solid]):
        raise UnusableMesh(
            f"{name} is only connected by faces without area: dissolve them (Mesh, Clean Up, Degenerate Dissolve) "
            "and unwrap again."
        )
    sheet = Sheet(whole.vertices[kept], number[triangles[solid]], (), number[boundary[np.isin(boundary, kept)]])
    at_corner = number[np.searchsorted(used, cut.corner[corners])]
    return Island(sheet, hanging, cut.vertex[used[kept]], cut.kept[piece[solid]], corners, at_corner)


def _outer_edge(whole: Sheet, name: str) -> Indices:
    """The vertices along a piece's outer edge; refuses pieces that have no flat map."""
    loops = closed_loops(whole.triangles)
    if not loops:
        raise UnusableMesh(f"{name} is closed: mark seams to cut it open (Edge, Mark Seam) and unwrap again.")
    sides = (whole.triangles.size + sum(len(loop) for loop in loops)) // 2
    if len(whole.vertices) - sides + len(whole.triangles) + len(loops) < 2:
        raise UnusableMesh(f"{name} has a handle, like a cup: mark seams around and along it and unwrap again.")
    if len(loops) == 1:
        return loops[0]
    turning = np.array([edge_turning(replace(whole, boundary=loop)).sum() for loop in loops])
    outer = int(np.argmax(turning))
    if np.delete(turning, outer).max() > -_LEAST_HOLE_TURN:
        raise UnusableMesh(f"{name} is a tube: mark a seam along it from end to end and unwrap again.")
    return loops[outer]


def _held_together(triangles: Indices) -> bool:
    """Whether all parts share two vertices with another, so none can turn on its own."""
    part = parts(triangles)
    has = sparse.csr_array((np.ones(triangles.size), (part.repeat(3), triangles.ravel()))).sign()
    shared = (has @ has.T).tocoo()
    firm = shared.data >= 2
    links = sparse.coo_array((shared.data[firm], (shared.row[firm], shared.col[firm])), shape=shared.shape)
    return int(connected_components(links, directed=False)[0]) == 1


def _hang(positions: Array, slivers: Indices, number: Indices) -> tuple[tuple[int, int, float], ...]:
    """Number the vertices that only belong to slivers, and find for each the line through two others on which it is.

    ``number`` (V,) is -1 at these vertices, and is filled in as far as they can be found.
    """
    hanging: list[tuple[int, int, float]] = []
    fresh = int(number.max()) + 1
    while len(ready := slivers[(number[slivers] < 0).sum(1) == 1]):
        lone = number[ready[0]] < 0
        start, end = ready[0][~lone]
        line = positions[end] - positions[start]
        share = float((positions[ready[0][lone][0]] - positions[start]) @ line / (line @ line))
        number[ready[0][lone]] = fresh + len(hanging)
        hanging.append((int(number[start]), int(number[end]), share))
    return tuple(hanging)
