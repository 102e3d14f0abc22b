"""Which triangle of a mesh lies under each pixel of a picture, and values in between its corners."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, Indices
from ..sheet import FlatMap, Sheet

_BAND = 1 << 18  # pixels processed at once: their temporaries fit about into the processor's cache
_TRIANGLES_AT_ONCE = 4 * _BAND  # by the squares around them: most of a square is outside its triangle


@dataclass(frozen=True)
class PageLookup:
    """Which triangle of a mesh covers each pixel of a picture.

    Attributes
    ----------
    triangle : (H, W) int32 array
        Index of the triangle under the pixel's centre, -1 if there is none.
    barycentric : (H, W, 2) float32 array
        Weights of the triangle's first two corners there; all three add up to 1.
    """

    triangle: NDArray[np.int32]
    barycentric: NDArray[np.float32]


def page_lookup(sheet: Sheet, flat: FlatMap, size_px: tuple[int, int]) -> PageLookup:
    """Find the triangle that covers each pixel of the flat page.

    Parameters
    ----------
    sheet : Sheet
    flat : FlatMap
    size_px : (width, height)
        Size of the page image; it spans the whole page.

    Returns
    -------
    PageLookup
        Every pixel centre inside the flat mesh has exactly one triangle, even on a shared edge.
    """
    scale = np.array([size_px[0] / flat.width, size_px[1] / flat.height])
    return rasterize(flat.uv * scale, sheet.triangles, size_px)


def rasterize(corners: Array, triangles: Indices, size_px: tuple[int, int]) -> PageLookup:
    """Find the triangle under each pixel centre of a picture; of several, the last one listed.

    Parameters
    ----------
    corners : (V, 2) array
        Pixels. Triangles with a corner that is not finite are left out.
    triangles : (F, 3) int array
        In either orientation.
    size_px : (width, height)
    """
    width, height = size_px
    triangle = np.full(height * width, -1, np.int32)
    barycentric = np.zeros((height * width, 2), np.float32)
    for owner, row, start, stop in _spans(corners, triangles, width, height):
        _fill(triangle, barycentric, corners, triangles, width, (owner, row, start, stop))
    return PageLookup(triangle.reshape(height, width), barycentric.reshape(height, width, 2))


def _spans(
    corners: Array, triangles: Indices, width: int, height: int
) -> Iterator[tuple[Indices, Indices, Indices, Indices]]:
    """The pixel runs ``owner, row, start, stop`` of all triangles, in their order, in bands of bounded size."""
    usable = np.flatnonzero(np.isfinite(corners[triangles]).all(axis=(1, 2)))
    y = corners[triangles[usable], 1]
    first = np.clip(np.ceil(y.min(axis=1) - 0.5), 0, height).astype(np.int64)
    last = np.clip(np.ceil(y.max(axis=1) - 0.5), 0, height).astype(np.int64)
    extent = np.ptp(np.clip(corners[triangles[usable], 0], 0, width), axis=1) + 1
    load = np.cumsum((last - first) * extent)
    bands = np.append(np.searchsorted(load, np.arange(0, load[-1:].sum(), _TRIANGLES_AT_ONCE)), len(load))
    for begin, end in itertools.pairwise(bands):
        rows = (last - first)[begin:end]
        owner = np.repeat(usable[begin:end], rows)
        row = np.arange(rows.sum()) - np.repeat(np.cumsum(rows) - rows - first[begin:end], rows)
        left, right = _crossings(corners, triangles, owner, row + 0.5)
        start = np.clip(np.ceil(left - 0.5), 0, width).astype(np.int64)
        stop = np.clip(np.ceil(right - 0.5), 0, width).astype(np.int64)
        yield owner, row, start, np.maximum(start, stop)


def _crossings(corners: Array, triangles: Indices, owner: Indices, y: Array) -> tuple[Array, Array]:
    """Where the line at height ``y`` enters and leaves the triangle ``owner``.

    An edge is always traversed from its upper to its lower end, so both its triangles compute the same number: no pixel
    between them is lost or assigned twice.
    """
    order = np.lexsort((triangles, corners[triangles, 1]), axis=1)
    top, middle, bottom = np.take_along_axis(triangles, order, axis=1)[owner].T
    upper_half = y < corners[middle, 1]
    short_top = np.where(upper_half, top, middle)
    short_bottom = np.where(upper_half, middle, bottom)
    crossings = []
    for a, b in ((top, bottom), (short_top, short_bottom)):
        fraction = (y - corners[a, 1]) / np.maximum(corners[b, 1] - corners[a, 1], np.finfo(float).tiny)
        crossings.append(corners[a, 0] + fraction * (corners[b, 0] - corners[a, 0]))
    return np.minimum(*crossings), np.maximum(*crossings)


def _fill(
    triangle: NDArray[np.int32],
    barycentric: NDArray[np.float32],
    corners: Array,
    triangles: Indices,
    width: int,
    spans: tuple[Indices, Indices, Indices, Indices],
) -> None:
    """Write the pixels of ``spans`` into the flat ``triangle`` and ``barycentric``."""
    owner, row, start, stop = spans
    lengths = stop - start
    column = np.arange(lengths.sum()) - np.repeat(np.cumsum(lengths) - lengths - start, lengths)
    pixel = np.repeat(row * width, lengths) + column
    a, b, c = (corners[triangles[owner, k]] for k in range(3))
    area = (a[:, 0] - c[:, 0]) * (b[:, 1] - c[:, 1]) - (b[:, 0] - c[:, 0]) * (a[:, 1] - c[:, 1])
    area = np.where(area == 0, np.inf, area)
    dy = row + 0.5 - c[:, 1]
    triangle[pixel] = np.repeat(owner, lengths)
    for k, (p, q) in enumerate(((b, c), (c, a))):
        # The weight is linear along a run: its value at column 0 and its slope are worked out once per run.
        slope = (p[:, 1] - q[:, 1]) / area
        at_zero = slope * (0.5 - c[:, 0]) + (q[:, 0] - p[:, 0]) / area * dy
        barycentric[pixel, k] = np.repeat(at_zero, lengths) + np.repeat(slope, lengths) * column


def interpolate(lookup: PageLookup, triangles: Indices, values: Array) -> NDArray[np.float64]:
    """Values (V, C) at the vertices, linear over each triangle, on every pixel (H, W, C); NaN where no triangle is."""
    at_corners = values[triangles]
    triangle = lookup.triangle.reshape(-1)
    weights = lookup.barycentric.reshape(-1, 2).astype(float)
    out = np.full((triangle.size, values.shape[1]), np.nan)
    for begin in range(0, triangle.size, _BAND):
        band = slice(begin, begin + _BAND)
        inside = np.flatnonzero(triangle[band] >= 0)
        corner = at_corners[triangle[band][inside]]
        a, b = weights[band][inside].T[..., None]
        out[begin + inside] = a * corner[:, 0] + b * corner[:, 1] + (1 - a - b) * corner[:, 2]
    return out.reshape(*lookup.triangle.shape, -1)
