"""What each photo shows of the page, in coarse cells: colour, fine detail, and visibility."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..camera import Camera
from ..numeric.image import sample_bilinear
from ..sheet import FlatMap, Sheet
from ..watch import SILENT, Watch
from .page_cells import ReadPhoto, coarse_size, enlarge, log_brightness, visible_cells
from .warp import Photo, halve, page_lookup, photo_positions, reduction_level

CELL = 3  # pixels of the viewed page along a cell's side
# Of those pixels, standard deviations: detail between them is measured. Its wavelength, 4.5 pixels, is 2.3 mm on A4, as
# the strokes of letters of 10 points have it.
_FINEST, _COARSEST = 0.6, 1.5


@dataclass(frozen=True)
class PageViews:
    """A page of (h, w) cells as n photos show it.

    Attributes
    ----------
    color : (n, h, w, 3) float32 array
        Logarithm of brightness.
    brightest : (n, h, w) float32 array
        Brightness of the darkest channel of a cell's darkest pixel: 1 where the whole cell is burnt out.
    detail : (n, 3, h, w) float32 array
        Means of ``fx fx``, ``fy fy`` and ``fx fy``, f being the part of that logarithm as fine as letters' strokes:
        a photo that moved has lost it in one direction only.
    picture : (n, CELL h, CELL w) float32 array
        Logarithm of the mean channel's brightness.
    visible : (n, h, w) bool array
    page : (h, w) bool array
        Where the sheet is.
    """

    color: NDArray[np.float32]
    brightest: NDArray[np.float32]
    detail: NDArray[np.float32]
    picture: NDArray[np.float32]
    visible: NDArray[np.bool_]
    page: NDArray[np.bool_]


def view_page(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    watch: Watch = SILENT,
    before: PageViews | None = None,
) -> PageViews:
    """View the page in every photo, one after the other.

    Parameters
    ----------
    before : PageViews, optional
        The views of the first cameras, which are reused.

    Raises
    ------
    Cancelled
    """
    size = coarse_size(flat)
    lookup = page_lookup(sheet, flat, size)
    count, shape = len(cameras), (size[1], size[0])
    views = PageViews(
        np.zeros((count, *shape, 3), np.float32),
        np.zeros((count, *shape), np.float32),
        np.zeros((count, 3, *shape), np.float32),
        np.zeros((count, CELL * shape[0], CELL * shape[1]), np.float32),
        np.zeros((count, *shape), bool),
        lookup.triangle >= 0,
    )
    begin = 0 if before is None else len(before.visible)
    if before is not None:
        for part in ("color", "brightest", "detail", "picture", "visible"):
            getattr(views, part)[:begin] = getattr(before, part)
    for index, camera in enumerate(cameras[begin:], begin):
        watch.step((index - begin) / (count - begin), "Comparing the photos")
        position = photo_positions(sheet, lookup, camera)
        views.visible[index] = visible_cells(sheet, lookup, camera, position)
        if not views.visible[index].any():
            continue
        color, views.brightest[index], grey = _look(read_photo(index), position)
        views.color[index] = log_brightness(color)
        picture = views.picture[index] = log_brightness(grey)
        fine = ndimage.gaussian_filter(picture, _FINEST) - ndimage.gaussian_filter(picture, _COARSEST)
        across, down = np.gradient(fine, axis=1), np.gradient(fine, axis=0)
        pairs = ((across, across), (down, down), (across, down))
        views.detail[index] = [_blocks(a * b, np.add) / CELL**2 for a, b in pairs]
    return views


def _look(photo: Photo, position: NDArray[np.float32]) -> tuple[NDArray[np.float32], ...]:
    """Colour (h, w, 3) and darkest channel (h, w) of cells at ``position`` in the photo, and the grey page."""
    if not np.isfinite(position).any():
        shape = position.shape[:2]
        grey = np.zeros((CELL * shape[0], CELL * shape[1]), np.float32)
        return np.zeros((*shape, 3), np.float32), np.zeros(shape, np.float32), grey
    step = float(np.nanmedian(2 ** reduction_level(position))) / CELL
    level = max(0, round(np.log2(step)))
    scale = 2**level
    # Use whole blocks of the visible part, so a cell's mean covers about one cell.
    block = CELL * scale
    low = np.maximum(np.nanmin(position, axis=(0, 1)).astype(int) // block - 1, 0) * block
    high = (np.nanmax(position, axis=(0, 1)).astype(int) // block + 2) * block
    photo = photo[low[1] : high[1], low[0] : high[0]]
    for _ in range(level):
        photo = halve(photo)
    white = float(np.iinfo(photo.dtype).max)
    position = (np.nan_to_num(position) - low.astype(np.float32)) / np.float32(scale)
    at_cells = position / CELL
    total = _blocks(photo, np.add, np.uint32)
    color = sample_bilinear(total, at_cells) / np.float32(white * CELL**2)
    column, row = np.moveaxis(at_cells.astype(int), -1, 0)
    darkest = _blocks(np.minimum(np.minimum(photo[..., 0], photo[..., 1]), photo[..., 2]), np.minimum)
    darkest = darkest[row.clip(0, darkest.shape[0] - 1), column.clip(0, darkest.shape[1] - 1)]
    grey = photo[..., 0].astype(np.float32) + photo[..., 1] + photo[..., 2]
    # Between cells the positions are linear: a fold bends them by less than a page pixel.
    shape = (position.shape[0] * CELL, position.shape[1] * CELL)
    places = [enlarge(position[..., axis], shape) - np.float32(0.5) for axis in (1, 0)]
    page = ndimage.map_coordinates(grey, places, order=1, mode="nearest")
    return color, darkest.astype(np.float32) / np.float32(white), page / np.float32(3 * white)


def _blocks(picture: NDArray[Any], join: np.ufunc, dtype: Any = None) -> NDArray[Any]:
    """Blocks of `CELL` x `CELL` pixels; incomplete ones at the right and lower edge are dropped."""
    for axis in (0, 1):
        before, last = (slice(None),) * axis, picture.shape[axis] - CELL + 1
        parts = [picture[(*before, slice(k, last + k, CELL))] for k in range(CELL)]
        picture = parts[0] if dtype is None else parts[0].astype(dtype)
        for part in parts[1:]:
            picture = join(picture, part)
    return picture
