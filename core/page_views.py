"""What each photo shows of the page, on coarse cells: colour, fine detail, and what it sees at all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from .camera import Camera
from .image import shrink
from .page_cells import ReadPhoto, brightness, enlarge, visible_cells
from .sheet import FlatMap, Sheet
from .warp import Photo, halve, page_lookup, photo_positions, reduction_level, sample
from .watch import SILENT, Watch

CELLS = 192  # along the page's longer side
CELL = 3  # pixels of the page that is looked at, along a cell's side
# Of those pixels, standard deviations: detail between them is measured. Its wavelength, 4.5 pixels, is 2.3 mm on A4, as
# the strokes of letters of 10 points have it.
_FINEST, _COARSEST = 0.6, 1.5
# Added to brightness before its logarithm: noise in the dark is no detail, and black print a little blacker no shadow.
_DARKEST = 0.05


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
    sheet: Sheet, flat: FlatMap, cameras: Sequence[Camera], read_photo: ReadPhoto, watch: Watch = SILENT
) -> PageViews:
    """Look at the page in every photo, one after the other.

    Raises
    ------
    Cancelled
    """
    cell = max(flat.width, flat.height) / CELLS
    size = (max(2, round(flat.width / cell)), max(2, round(flat.height / cell)))
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
    for index, camera in enumerate(cameras):
        watch.step(index / count, "Comparing the photos")
        position = photo_positions(sheet, lookup, camera)
        views.visible[index] = visible_cells(sheet, lookup, camera, position)
        if not views.visible[index].any():
            continue
        page = _page_of(read_photo(index), position)
        views.color[index] = log_brightness(shrink(page, CELL))
        views.brightest[index] = page.reshape(shape[0], CELL, shape[1], -1).min(axis=(1, 3))
        picture = views.picture[index] = log_brightness(page.mean(axis=2))
        fine = ndimage.gaussian_filter(picture, _FINEST) - ndimage.gaussian_filter(picture, _COARSEST)
        across, down = np.gradient(fine, axis=1), np.gradient(fine, axis=0)
        views.detail[index] = [shrink(a * b, CELL) for a, b in ((across, across), (down, down), (across, down))]
    return views


def log_brightness(page: NDArray[np.float32]) -> NDArray[np.float32]:
    """Logarithm of brightness, in which a change of exposure or of light is a difference."""
    return np.log(page + np.float32(_DARKEST))


def _page_of(photo: Photo, position: NDArray[np.float32]) -> NDArray[np.float32]:
    """Brightness of the page at `CELL` pixels to a cell, where cells lie in the photo at ``position``."""
    shape = (position.shape[0] * CELL, position.shape[1] * CELL)
    # Between cells the positions are linear: what a fold bends them by is less than a page pixel.
    fine = np.stack([enlarge(position[..., axis], shape) for axis in (0, 1)], axis=-1)
    if not np.isfinite(fine).any():
        return np.zeros((*shape, 3), np.float32)
    level = round(float(np.nanmedian(reduction_level(fine))))
    scale = 2**level
    low = np.maximum(np.nanmin(fine, axis=(0, 1)).astype(int) // scale - 1, 0) * scale
    high = np.nanmax(fine, axis=(0, 1)).astype(int) + 2 * scale
    photo = photo[low[1] : high[1], low[0] : high[0]]
    for _ in range(level):
        photo = halve(photo)
    return brightness(sample(photo, (fine - low.astype(np.float32)) / np.float32(scale), "linear"))
