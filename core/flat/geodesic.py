"""Flattening by distances along the surface, after Zhang, Zhang and Tan (2008): the paper's baseline "Geo"."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..arrays import Array, Indices
from ..numeric.triangles import directed_edges, interior_edges
from ..sheet import Sheet
from ..watch import SILENT, Watch
from .pins import HeldSystem, Pins
from .settle import settle

# The most iterations; they end earlier once the vertices settle.
_ITERATIONS = 200


def keep_geodesic_lengths(sheet: Sheet, start: Array, watch: Watch = SILENT, *, pins: Pins | None = None) -> Array:
    """Give every edge, and every pair of corners across an edge, its length along the surface.

    Majorisation (SMACOF) minimises the squared errors of the lengths: it moves each end of a spring to where the spring
    would have its length.

    Parameters
    ----------
    sheet : Sheet
        Of about unit area.
    start : (V, 2) array
        A flat map without flips.
    watch : Watch
    pins : Pins, optional
        Two or more, in the frame of ``start``.

    Returns
    -------
    flat : (V, 2) array
    """
    pairs, length = _springs(sheet)
    count = len(sheet.vertices)
    row = np.arange(len(pairs)).repeat(2)
    sign = np.tile([1.0, -1.0], len(pairs))
    difference = sparse.csr_array((sign, (row, pairs.ravel())), shape=(len(pairs), count))
    weight = 1 / length
    held = Pins(np.zeros(0, np.int64), np.zeros((0, 2))) if pins is None else pins
    system = HeldSystem(difference.T @ difference.multiply(weight[:, None]), held.vertices)

    def lengthen(flat: Array) -> Array:
        spring = difference @ flat
        now = np.linalg.norm(spring, axis=1) + 1e-300
        return system.solve(difference.T @ (spring * (weight * length / now)[:, None]), held.uv)

    return settle(start, lengthen, _ITERATIONS, watch, centred=pins is None)


def _springs(sheet: Sheet) -> tuple[Indices, Array]:
    """Pairs of vertices and their distances along the surface: all edges, and the corners across each inner edge."""
    triangles = sheet.triangles
    edges = np.unique(np.sort(directed_edges(triangles), axis=1), axis=0)
    edge_length = np.linalg.norm(sheet.vertices[edges[:, 0]] - sheet.vertices[edges[:, 1]], axis=1)
    shared, opposite = interior_edges(triangles)
    unfolded = _unfolded_distance(sheet.vertices, shared, opposite)
    return np.vstack([edges, opposite]), np.concatenate([edge_length, unfolded])


def _unfolded_distance(vertices: Array, shared: Indices, opposite: Indices) -> Array:
    """Distance between the opposite corners of two triangles once unfolded about their shared edge."""
    origin = vertices[shared[:, 0]]
    axis = vertices[shared[:, 1]] - origin
    axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
    places = []
    for side in (0, 1):
        offset = vertices[opposite[:, side]] - origin
        along = (offset * axis).sum(1)
        places.append((along, np.linalg.norm(offset - along[:, None] * axis, axis=1)))
    (x0, y0), (x1, y1) = places
    return np.hypot(x1 - x0, y0 + y1)
