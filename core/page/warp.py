"""Photos to page pixels: the triangle under a pixel, its place in a photo, and the colour there."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, Indices
from ..camera import Camera
from ..sheet import FlatMap, Sheet

Photo = NDArray[np.unsignedinteger[Any]]
Weights = NDArray[np.float32]

_BAND = 1 << 18  # pixels processed at once: their temporaries fit about into the processor's cache
_KERNEL = 4  # pixels around a position that its colour depends on, with one to spare
# Up to 1.2 photo pixels from one page pixel to the next the photo itself is sampled: it hardly aliases, and half of the
# page of most photos lies there.
_UNREDUCED = 0.25
_SAMPLED_AT_ONCE = _BAND // 16  # pixels: each takes sixteen of the photo
_TRIANGLES_AT_ONCE = 4 * _BAND  # by the squares around them: most of a square is outside its triangle
_NO_AREA = 1e-9  # a triangle's area on the page, as a share of the largest, below which it shows nothing
_WHITE = {np.dtype(np.uint8): 255, np.dtype(np.uint16): 65535}


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


def photo_positions(sheet: Sheet, lookup: PageLookup, camera: Camera) -> NDArray[np.float32]:
    """The place of each page pixel in a photo.

    The point of the sheet under the pixel is projected, with lens distortion. Interpolating the vertices' pixels
    instead would bend straight lines inside large triangles.

    Returns
    -------
    (H, W, 2) float32 array
        Distorted pixels; NaN where the page has no triangle, and where the point is behind the camera or outside
        the photo's frame.
    """
    shape = lookup.triangle.shape
    in_camera = camera.to_camera_frame(sheet.vertices)
    out = np.empty((lookup.triangle.size, 2), np.float32)
    rows = max(1, _BAND // shape[1])
    for begin in range(0, shape[0], rows):
        band = slice(begin, begin + rows)
        part = PageLookup(lookup.triangle[band], lookup.barycentric[band])
        point = interpolate(part, sheet.triangles, in_camera).reshape(-1, 3)
        with np.errstate(invalid="ignore", divide="ignore"):
            pixels = camera.distort(point[:, :2] / np.where(point[:, 2:] > 0, point[:, 2:], np.nan))
            x, y = pixels.T
            inside = (x >= 0) & (x <= camera.width) & (y >= 0) & (y <= camera.height)
        out[begin * shape[1] : begin * shape[1] + len(pixels)] = np.where(inside[:, None], pixels, np.nan)
    return out.reshape(*shape, 2)


def sample(photo: Photo, positions: NDArray[np.float32], method: str = "bicubic") -> Photo:
    """Colours of a photo at given positions.

    Parameters
    ----------
    photo : (h, w, 3) uint8 or uint16 array
    positions : (H, W, 2) array
        Pixels of the photo, neighbours in the array being neighbours on the page.
    method : str
        ``"bicubic"``: Keys' kernel; where the page has fewer pixels than the photo, a reduced photo is used to avoid
        aliasing. ``"linear"``: only the four nearest pixels, as a render engine samples.

    Returns
    -------
    (H, W, 3) array of the photo's type
        White where the position is not finite.
    """
    if method not in ("bicubic", "linear"):
        raise ValueError(f"method must be 'bicubic' or 'linear', not {method!r}")
    out: Photo = np.full((*positions.shape[:2], 3), _WHITE[photo.dtype], photo.dtype)
    known = np.isfinite(positions[..., 0])
    if not known.any():
        return out
    if method == "linear":
        _sample_level(*_around(photo, positions, 1), known, 1.0, out, _linear_weights)
        return out
    level = reduction_level(positions)
    level = np.where(level < 1, np.maximum(level - _UNREDUCED, 0) / (1 - _UNREDUCED), level)
    coarsest = min(int(np.ceil(np.nanmax(level, initial=0))), int(np.log2(max(min(photo.shape[:2]), 1))))
    photo, positions = _around(photo, positions, 2**coarsest)
    for k in range(coarsest + 1):
        # Between two reduced photos the result is blended, because a hard switch would be visible as a line.
        share = np.clip(1 - np.abs(np.minimum(level, coarsest) - k), 0, 1)
        here = share > 0
        if k == 0:
            _sample_level(photo, positions, here, 1.0, out, _cubic_weights)
        elif here.any():
            finer = out[here].astype(np.float32)
            _sample_level(photo, positions, here, 0.5**k, out, _cubic_weights)
            coarser_share = np.where(level[here] < k, share[here], 1)[:, None].astype(np.float32)
            out[here] = np.rint(finer + coarser_share * (out[here] - finer)).astype(out.dtype)
        if k < coarsest:
            photo = halve(photo)
    return out


def _around(photo: Photo, positions: NDArray[np.float32], step: int) -> tuple[Photo, NDArray[np.float32]]:
    """The part of a photo around positions, and these in it: a band of a page needs little of the photo.

    It is cut at multiples of ``step`` pixels, so that reduced by that factor it is a part of the reduced photo.
    """
    ends = np.stack([np.nanmin(positions, axis=(0, 1)), np.nanmax(positions, axis=(0, 1))])
    low, high = np.clip(np.floor(ends / step).astype(int), 0, np.array(photo.shape[1::-1]) // step)
    left, top = np.maximum(low - _KERNEL, 0) * step
    right, bottom = (high + _KERNEL) * step
    return photo[top:bottom, left:right], positions - np.array([left, top], positions.dtype)


def reduction_level(positions: NDArray[np.float32]) -> NDArray[np.float32]:
    """How often to halve the photo for neighbours on the page to be neighbours in it, (H, W); 0 if never.

    The longer step of the two directions counts. NaN where the position is not finite.
    """
    longest = np.zeros(positions.shape[:2], np.float32)
    with np.errstate(invalid="ignore"):
        for axis in (0, 1):
            if positions.shape[axis] < 2:
                continue
            step = np.hypot(*np.moveaxis(np.diff(positions, axis=axis), -1, 0))
            ahead, behind = (np.insert(step, at, np.nan, axis=axis) for at in (step.shape[axis], 0))
            longest = np.fmax(longest, np.fmin(ahead, behind))
        level = np.log2(np.maximum(longest, 1))
    level[~np.isfinite(positions[..., 0])] = np.nan
    return level


def halve(photo: Photo) -> Photo:
    """Means of 2x2 pixels; an odd last row or column is repeated."""
    if photo.shape[0] % 2 or photo.shape[1] % 2:
        photo = np.pad(photo, ((0, photo.shape[0] % 2), (0, photo.shape[1] % 2), (0, 0)), mode="edge")
    wide = np.uint16 if photo.dtype == np.uint8 else np.uint32
    rows = np.add(photo[::2], photo[1::2], dtype=wide)
    total = rows[:, ::2] + rows[:, 1::2]
    return ((total + wide(2)) // wide(4)).astype(photo.dtype)


def _cubic_weights(t: Weights) -> list[Weights]:
    """Keys' kernel (a = -1/2) for the pixels at -1, 0, 1, 2 beside the fraction ``t``."""
    return [
        ((-0.5 * t + 1.0) * t - 0.5) * t,
        (1.5 * t - 2.5) * t * t + 1.0,
        ((-1.5 * t + 2.0) * t + 0.5) * t,
        (0.5 * t - 0.5) * t * t,
    ]


def _linear_weights(t: Weights) -> list[Weights]:
    """The pixels at 0, 1 beside the fraction ``t``; those at -1 and 2 do not count."""
    return [1 - t, t]


def _sample_level(
    photo: Photo,
    positions: NDArray[np.float32],
    where: NDArray[np.bool_],
    scale: float,
    out: Photo,
    weights: Callable[[Weights], list[Weights]],
) -> None:
    """Write into ``out[where]`` the photo, reduced by ``scale``, at ``positions * scale``."""
    height, width = photo.shape[:2]
    # Four channels in one word: one gather instead of three. Two rows and columns are repeated on every side.
    padded = np.zeros((height + 4, width + 4, 4), photo.dtype)
    padded[..., :3] = np.pad(photo, ((2, 2), (2, 2), (0, 0)), mode="edge")
    words = padded.view(np.uint32 if photo.dtype == np.uint8 else np.uint64).reshape(-1)
    flat_out = out.reshape(-1, 3)
    chosen = np.flatnonzero(where)
    for begin in range(0, len(chosen), _SAMPLED_AT_ONCE):
        index = chosen[begin : begin + _SAMPLED_AT_ONCE]
        xy = positions.reshape(-1, 2)[index].astype(np.float64) * scale - 0.5
        floor = np.floor(xy)
        fraction = (xy - floor).astype(np.float32)
        x, y = np.clip(floor.astype(np.int64) + 2, 1, (width + 1, height + 1)).T
        in_x, in_y = weights(fraction[:, :1]), weights(fraction[:, 1:])
        offset = 1 if len(in_x) == 4 else 0
        total = np.zeros((len(index), 4), np.float32)
        for j, weight_y in enumerate(in_y):
            line = np.zeros((len(index), 4), np.float32)
            base = (y + j - offset) * (width + 4) + x - offset
            for i, weight_x in enumerate(in_x):
                line += weight_x * words.take(base + i).view(photo.dtype).reshape(-1, 4)
            total += weight_y * line
        flat_out[index] = np.clip(np.rint(total[:, :3]), 0, _WHITE[photo.dtype]).astype(out.dtype)


def native_size(sheet: Sheet, flat: FlatMap, camera: Camera) -> float:
    """Page pixels per page unit at which the page has the photo's own pixel density.

    The density of a photo changes over the page, and with the direction where the sheet is seen at an angle. Of
    the two directions the denser counts; over the page it is the median.
    """
    pixels = camera.project(sheet.vertices)[sheet.triangles]
    page = flat.uv[sheet.triangles]
    edges_photo = np.stack([pixels[:, 1] - pixels[:, 0], pixels[:, 2] - pixels[:, 0]], axis=-1)
    edges_page = np.stack([page[:, 1] - page[:, 0], page[:, 2] - page[:, 0]], axis=-1)
    area = np.abs(np.linalg.det(edges_page))
    usable = np.isfinite(edges_photo).all(axis=(1, 2)) & (area > area.max() * _NO_AREA)
    jacobian = edges_photo[usable] @ np.linalg.inv(edges_page[usable])
    density = np.linalg.norm(jacobian, ord=2, axis=(1, 2))
    order = np.argsort(density)
    share = np.cumsum(area[usable][order])
    return float(density[order][np.searchsorted(share, share[-1] / 2)])


def photo_to_page(sheet: Sheet, flat: FlatMap, camera: Camera, step: int) -> NDArray[np.float32]:
    """The places of a photo's pixels on the page.

    Parameters
    ----------
    step : int
        Distance in pixels between two entries.

    Returns
    -------
    (ceil(h / step), ceil(w / step), 2) float32 array
        Entry ``[r, c]`` is for the photo's pixel position ``((c + 0.5) step, (r + 0.5) step)``: the u, v seen there in
        the flat map's unit, NaN outside the sheet.
    """
    pixels = camera.project(sheet.vertices) / step
    depth = camera.to_camera_frame(sheet.vertices)[:, 2]
    far_to_near = np.argsort(-depth[sheet.triangles].mean(axis=1), kind="stable")
    triangles = sheet.triangles[far_to_near]
    lookup = rasterize(pixels, triangles, (-(-camera.width // step), -(-camera.height // step)))
    return interpolate(lookup, triangles, flat.uv).astype(np.float32)
