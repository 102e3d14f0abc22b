"""What each photo shows of the page, on coarse cells: colour, fine detail, and what it sees at all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from .camera import Camera
from .image import shrink
from .page_cells import ReadPhoto, brightness, enlarge, projected_area, visible_cells
from .sheet import FlatMap, Sheet
from .warp import Photo, halve, page_lookup, photo_positions, reduction_level, sample
from .watch import SILENT, Watch

CELLS = 192  # along the page's longer side
_CELL = 5  # pixels of the page that is looked at, along a cell's side
_FINEST, _COARSEST = 1.0, 2.5  # of those pixels: detail between them is measured, letters of running text have it
# Added to brightness before its logarithm: noise in the dark is no detail, and black print a little blacker no shadow.
_DARKEST = 0.05


@dataclass(frozen=True)
class PageViews:
    """A page of (h, w) cells as n photos show it.

    Attributes
    ----------
    color : (n, h, w, 3) float32 array
        Logarithm of brightness.
    detail : (n, 3, h, w) float32 array
        Means of ``fx fx``, ``fy fy`` and ``fx fy``, f being the part of that logarithm as fine as letters' strokes:
        a photo that moved has lost it in one direction only.
    visible : (n, h, w) bool array
    area : (n, h, w) float32 array
        Photo pixels per page area.
    page : (h, w) bool array
        Where the sheet is.
    """

    color: NDArray[np.float32]
    detail: NDArray[np.float32]
    visible: NDArray[np.bool_]
    area: NDArray[np.float32]
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
    shape = (len(cameras), size[1], size[0])
    views = PageViews(
        np.zeros((*shape, 3), np.float32),
        np.zeros((len(cameras), 3, *shape[1:]), np.float32),
        np.zeros(shape, bool),
        np.zeros(shape, np.float32),
        lookup.triangle >= 0,
    )
    for index, camera in enumerate(cameras):
        watch.step(index / len(cameras), "Comparing the photos")
        position = photo_positions(sheet, lookup, camera)
        views.visible[index] = visible_cells(sheet, lookup, camera, position)
        views.area[index] = projected_area(sheet, flat, lookup, camera)
        page = _page_of(read_photo(index), position)
        views.color[index] = log_brightness(shrink(page, _CELL))
        fine = log_brightness(page.mean(axis=2))
        fine = ndimage.gaussian_filter(fine, _FINEST) - ndimage.gaussian_filter(fine, _COARSEST)
        across, down = np.gradient(fine, axis=1), np.gradient(fine, axis=0)
        views.detail[index] = [shrink(a * b, _CELL) for a, b in ((across, across), (down, down), (across, down))]
    return views


def log_brightness(page: NDArray[np.float32]) -> NDArray[np.float32]:
    """Logarithm of brightness, in which a change of exposure or of light is a difference."""
    return np.log(page + np.float32(_DARKEST))


def _page_of(photo: Photo, position: NDArray[np.float32]) -> NDArray[np.float32]:
    """Brightness of the page at `_CELL` pixels to a cell, where cells lie in the photo at ``position``."""
    shape = (position.shape[0] * _CELL, position.shape[1] * _CELL)
    known = np.isfinite(position[..., 0])
    if not known.any():
        return np.zeros((*shape, 3), np.float32)
    # Between cells the positions are linear: what a fold bends them by is less than a page pixel.
    fine = np.stack([enlarge(position[..., axis], shape) for axis in (0, 1)], axis=-1)
    level = reduction_level(fine)
    scale = 1
    for _ in range(round(float(np.nanmedian(level))) if np.isfinite(level).any() else 0):
        photo = halve(photo)
        scale *= 2
    return brightness(sample(photo, fine / np.float32(scale), "linear"))
