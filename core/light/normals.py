"""Normals of the sheet, which change abruptly at its creases and smoothly everywhere else."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from ..arrays import Array, Indices
from ..sheet import Sheet


def corner_normals(sheet: Sheet) -> Array:
    """The normal at each corner of each triangle.

    Triangles that meet at a vertex share one normal there, the mean weighted by area, unless a crease separates them.

    Parameters
    ----------
    sheet : Sheet

    Returns
    -------
    (F, 3, 3) array
        For each triangle and corner a unit vector in the world frame, on the printed side.

    Examples
    --------
    Two triangles folded along their common edge, once smooth, once as a crease:

    >>> vertices = np.array([[0.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    >>> triangles = np.array([[0, 1, 2], [1, 0, 3]])
    >>> smooth = Sheet(vertices, triangles, (), np.array([2, 0, 3, 1]))
    >>> corner_normals(smooth)[:, 0].round(3) + 0.0
    array([[-0.707,  0.   ,  0.707],
           [-0.707,  0.   ,  0.707]])
    >>> creased = Sheet(vertices, triangles, (np.array([0, 1]),), np.array([2, 0, 3, 1]))
    >>> corner_normals(creased)[:, 0].round(3) + 0.0
    array([[ 0.,  0.,  1.],
           [-1.,  0.,  0.]])
    """
    corner = sheet.vertices[sheet.triangles]
    area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    group = _smooth_corners(sheet)
    total = np.zeros((group.max() + 1, 3))
    np.add.at(total, group.reshape(-1), np.repeat(area, 3, axis=0))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.asarray((total / np.maximum(length, np.finfo(float).tiny))[group])


def _smooth_corners(sheet: Sheet) -> Indices:
    """Numbers (F, 3) of the groups of corners that share a normal: joined across each edge that is not a crease."""
    triangles = sheet.triangles
    first, second = (np.concatenate([triangles[:, k] for k in order]) for order in ((0, 1, 2), (1, 2, 0)))
    corner = np.arange(triangles.size).reshape(triangles.shape)
    at_first, at_second = (np.concatenate([corner[:, k] for k in order]) for order in ((0, 1, 2), (1, 2, 0)))
    swapped = first > second
    low, high = np.minimum(first, second), np.maximum(first, second)
    at_low, at_high = np.where(swapped, at_second, at_first), np.where(swapped, at_first, at_second)
    edge = low * len(sheet.vertices) + high
    order = np.argsort(edge, kind="stable")
    same = np.flatnonzero(edge[order][1:] == edge[order][:-1])
    one, other = order[same], order[same + 1]
    smooth = ~np.isin(edge[one], _crease_edges(sheet))
    one, other = one[smooth], other[smooth]
    rows, columns = np.concatenate([at_low[one], at_high[one]]), np.concatenate([at_low[other], at_high[other]])
    links = sparse.coo_array((np.ones(len(rows)), (rows, columns)), (triangles.size, triangles.size))
    return np.asarray(connected_components(links, directed=False)[1].reshape(triangles.shape))


def _crease_edges(sheet: Sheet) -> Indices:
    """The edges of all creases, each as one number."""
    ends = [np.sort(np.stack([ridge[:-1], ridge[1:]]), axis=0) for ridge in sheet.ridges]
    low, high = np.concatenate([np.zeros((2, 0), np.int64), *ends], axis=1)
    return low * len(sheet.vertices) + high
