"""The relief of a sheet as pictures on the page: where the paper faces, and how high it stands."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array, Indices
from ..page.raster import PageLookup, interpolate, page_lookup
from ..sheet import FlatMap, Sheet
from .relief import Relief

_LARGEST = 65535  # of a normal's numbers, which 16 bits hold
_ROWS = 256  # of a map at once


def covering_lookup(sheet: Sheet, flat: FlatMap, size_px: tuple[int, int]) -> PageLookup:
    """As `warp.page_lookup`; pixels beside the mesh, along the page's edge, take the nearest pixel's place on it."""
    lookup = page_lookup(sheet, flat, size_px)
    beside = lookup.triangle < 0
    if not beside.any():
        return lookup
    nearest = tuple(ndimage.distance_transform_edt(beside, return_distances=False, return_indices=True))
    return PageLookup(lookup.triangle[nearest], lookup.barycentric[nearest])


def normal_map(relief: Relief, lookup: PageLookup) -> NDArray[np.uint16]:
    """The direction of the paper at each pixel.

    Parameters
    ----------
    relief : Relief
    lookup : PageLookup
        Of the map's pixels.

    Returns
    -------
    (H, W, 3) uint16 array
        x to the right, y up and z out of the printed side, of unit length, from -1 (stored as 0) to 1 (65535): the
        tangent space of OpenGL, glTF and Blender.
    """
    corners = np.arange(relief.normals.size // 3).reshape(-1, 3)
    values = relief.normals.reshape(-1, 3)
    out = np.empty((*lookup.triangle.shape, 3), np.uint16)
    for rows in _bands(lookup):
        normal = interpolate(_part(lookup, rows), corners, values)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        out[rows] = np.rint((normal + 1) * (_LARGEST / 2))
    return out


def displacement_map(relief: Relief, triangles: Indices, lookup: PageLookup) -> NDArray[np.float32]:
    """The height of the relief at each pixel, in page heights; (H, W).

    Between the vertices it bends as smoothly as the sheet is shaded: a cubic patch over each triangle (the curved PN
    triangles of Vlachos et al., 2001), so that light on it shows no triangles, and creases stay sharp.
    """
    patches = _patches(relief, triangles)
    out = np.empty(lookup.triangle.shape, np.float32)
    for rows in _bands(lookup):
        part = _part(lookup, rows)
        a, b = np.moveaxis(part.barycentric, -1, 0)
        powers = _bernstein(a, b, 1 - a - b)
        out[rows] = sum(patches[:, k][part.triangle] * power for k, power in enumerate(powers))
    return out


def _patches(relief: Relief, triangles: Indices) -> NDArray[np.float32]:
    """Bezier ordinates (F, 10) of each triangle, in the order of `_bernstein`."""
    height, place = relief.heights[triangles, 2], relief.heights[triangles, :2]
    toward, ends = [], []  # on the side from each corner to the next, and to the one before
    for step in (-1, 1):
        side = np.roll(place, step, axis=1) - place
        toward.append(height + (relief.slopes * side).sum(axis=-1) / 3)
        ends.append(triangles * len(relief.heights) + np.roll(triangles, step, axis=1))
    # Across a crease the slopes along it may differ a little: with their mean, the relief has no gaps.
    _, key, count = np.unique(np.concatenate(ends, axis=1), return_inverse=True, return_counts=True)
    mean = np.bincount(key.ravel(), np.concatenate(toward, axis=1).ravel()) / count
    sides = mean[key].reshape(-1, 6)
    middle = sides.sum(axis=1) / 4 - height.sum(axis=1) / 6
    return np.column_stack([height, sides, middle]).astype(np.float32)


def _bernstein(a: Array, b: Array, c: Array) -> tuple[Array, ...]:
    """Cubic weights: of the corners, of their sides to the next corner and to the one before, of the middle."""
    cubes = a**3, b**3, c**3
    following = 3 * a * a * b, 3 * b * b * c, 3 * c * c * a
    preceding = 3 * a * a * c, 3 * b * b * a, 3 * c * c * b
    return (*cubes, *following, *preceding, 6 * a * b * c)


def _bands(lookup: PageLookup) -> list[slice]:
    return [slice(top, top + _ROWS) for top in range(0, len(lookup.triangle), _ROWS)]


def _part(lookup: PageLookup, rows: slice) -> PageLookup:
    return PageLookup(lookup.triangle[rows], lookup.barycentric[rows])
