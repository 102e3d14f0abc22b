"""A flat map without flips for any sheet without a handle: its edge on a circle, each vertex amid its neighbours.

After W. T. Tutte, "How to draw a graph", 1963. Holes are closed for it, so that their edges need no place of their own.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..arrays import Array, Indices
from ..numeric.robust import solve_symmetric
from ..numeric.triangles import closed_loops, directed_edges
from ..sheet import Sheet


def convex_map(sheet: Sheet) -> Array:
    """Flat coordinates (V, 2) on the unit disc, u right, v up, not mirrored as seen from the printed side.

    Parameters
    ----------
    sheet : Sheet
        Of one piece; its boundary is the outer one.
    """
    count = len(sheet.vertices)
    outer = _turning_left(sheet)
    step = np.linalg.norm(np.roll(sheet.vertices[outer], -1, axis=0) - sheet.vertices[outer], axis=1)
    angle = 2 * np.pi * np.concatenate([[0], np.cumsum(step)[:-1]]) / step.sum()
    edges = directed_edges(_closed(sheet, outer))
    total = int(edges.max()) + 1
    links = sparse.coo_array((np.ones(2 * len(edges)), (edges.ravel("F"), edges[:, ::-1].ravel("F"))), (total, total))
    links = links.tocsr().sign()
    laplacian = sparse.diags_array(links.sum(axis=1)) - links
    flat = np.zeros((total, 2))
    flat[outer] = np.column_stack([np.cos(angle), np.sin(angle)])
    inner = np.setdiff1d(np.arange(total), outer)
    if len(inner):
        rows = laplacian.tocsr()[inner]
        flat[inner] = solve_symmetric(rows[:, inner].tocsc(), -(rows[:, outer] @ flat[outer]))
    return flat[:count]


def _turning_left(sheet: Sheet) -> Indices:
    """The outer edge, counter-clockwise as seen from the printed side: in the direction of its triangles' sides."""
    outer = sheet.boundary
    first = set(map(tuple, directed_edges(sheet.triangles).tolist()))
    return outer if (int(outer[0]), int(outer[1])) in first else outer[::-1]


def _closed(sheet: Sheet, outer: Indices) -> Indices:
    """The triangles and, for each hole, a fan around a new vertex."""
    triangles = [sheet.triangles]
    fresh = len(sheet.vertices)
    inside = set(outer.tolist())
    for loop in closed_loops(sheet.triangles):
        if not inside.isdisjoint(loop.tolist()):
            continue
        triangles.append(np.column_stack([np.roll(loop, -1), loop, np.full(len(loop), fresh)]))
        fresh += 1
    return np.concatenate(triangles)
