"""The print of the page as one photo shows it: without the light, with the same contrast everywhere."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import gaussian_mean, sample_bilinear, shrink
from ..page.page_cells import enlarge, log_brightness, visible_cells
from ..page.photo_colors import Photo, halve, reduction_level
from ..page.raster import PageLookup, page_lookup
from ..page.warp import photo_positions
from ..sheet import FlatMap, Sheet

Picture = NDArray[np.float32]

# Page pixels along the side of a cell, on which positions, light and windows are worked out.
CELL = 5
# Standard deviations, page pixels: noise finer than the one is smoothed away; what is wider than the other is light.
# Those of the prototype of the tracks (`dense_tracks.py`), where the second was .6 % of the page's longer side.
_NOISE, _LIGHT = 1.0, 13.0
# Contrast is measured over this many times the width of light, as in that prototype.
_CONTRAST_OVER = 2
# Added to the contrast (logarithm of brightness) by which the print is divided: blank paper stays quiet. A choice.
_QUIET = 0.05
# Photo pixels around what is sampled, for the spline between pixels: a cubic spline's memory falls to a quarter with
# each.
_MARGIN = 8
_LEAST_KNOWN = 1e-3  # share of the surroundings, below which nothing is divided by it
# Print is measured around each cell, within a standard deviation (cells). From this variance on, of a contrast that is
# about 1 in text, the cell counts fully as printed. Choices.
_PRINT_AROUND, _PRINTED = 1.5, 0.15


@dataclass(frozen=True)
class PagePrint:
    """What one photo shows of a page of (H, W) pixels, in cells of `CELL` x `CELL`.

    Attributes
    ----------
    picture : (H, W) float32 array
        The print; 0 where the photo does not show the page.
    position : (H / CELL, W / CELL, 2) float32 array
        Where the cells' centres lie in the photo, distorted pixels; NaN outside of it.
    known : (H / CELL, W / CELL) bool array
        Which cells the photo shows.
    """

    picture: Picture
    position: NDArray[np.float32]
    known: NDArray[np.bool_]

    @cached_property
    def filtered(self) -> Picture:
        """The picture, (H, W), as `alignment.shifted` takes it for cubic splines."""
        return np.asarray(ndimage.spline_filter(self.picture, output=np.float32))

    def photo_pixels(self, page: Array) -> Array:
        """Distorted pixels (N, 2) in the photo of page pixels (N, 2), as the picture was taken from it."""
        return sample_bilinear(self.position, page / CELL).astype(float)


def print_cells(sheet: Sheet, flat: FlatMap, per_unit: float, side: tuple[int, int]) -> PageLookup:
    """The cells of a page.

    Parameters
    ----------
    sheet : Sheet
    flat : FlatMap
    per_unit : float
        Its pixels per page unit, such as `warp.native_size` of the reference photo.
    side : (int, int)
        Pixels of the page's longer side, at least and at most.
    """
    longest = max(flat.width, flat.height)
    per_unit = float(np.clip(per_unit * longest, *side)) / longest
    # an even number of cells each way, because prints are first aligned at half size
    columns, rows = (2 * max(round(length * per_unit / (2 * CELL)), 1) for length in (flat.width, flat.height))
    return page_lookup(sheet, flat, (columns, rows))


def page_print(sheet: Sheet, cells: PageLookup, camera: Camera, photo: Photo) -> PagePrint:
    """Look at the page in a photo.

    Parameters
    ----------
    sheet : Sheet
    cells : PageLookup
        The page's cells, see `CELL`.
    camera : Camera
    photo : (h, w, 3) uint8 or uint16 array
    """
    position = photo_positions(sheet, cells, camera)
    known = visible_cells(sheet, cells, camera, position)
    # A cell at the edge is half off the sheet.
    known &= ndimage.binary_erosion(cells.triangle >= 0, border_value=0)
    rows, columns = known.shape
    if not known.any():
        return PagePrint(np.zeros((rows * CELL, columns * CELL), np.float32), position, known)
    # beyond the sheet the nearest position, so that there is one between all cells
    outside = ~np.isfinite(position[..., 0])
    nearest = ndimage.distance_transform_edt(outside, return_distances=False, return_indices=True)
    position = position[tuple(nearest)]
    grey = _sampled(photo, position, known)
    return PagePrint(_without_light(log_brightness(np.maximum(grey, 0)), known), position, known)


def print_of_page(page: Photo, cells: PageLookup) -> PagePrint:
    """The print of a page image (h, w, 3), in the cells of the same page."""
    rows, columns = cells.triangle.shape
    cell = np.array([page.shape[1] / columns, page.shape[0] / rows])
    middle = np.stack(np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5), axis=-1) * cell
    known = ndimage.binary_erosion(cells.triangle >= 0, border_value=0)
    position = middle.astype(np.float32)
    grey = _sampled(page, position, known)
    return PagePrint(_without_light(log_brightness(np.maximum(grey, 0)), known), position, known)


def edges_of(print_: PagePrint) -> PagePrint:
    """The strength of the print's edges in place of the print: the same for dark on bright and bright on dark."""
    across, down = (np.gradient(print_.picture, axis=axis) for axis in (1, 0))
    return replace(print_, picture=_without_light(np.hypot(across, down), print_.known))


def printed_share(picture: Picture, known: NDArray[np.bool_]) -> Picture:
    """How much print there is in each cell of a picture (H, W), (h, w), 0 to 1."""
    variance, _ = gaussian_mean(shrink(picture**2, CELL), known, _PRINT_AROUND, _LEAST_KNOWN)
    return np.clip(variance / _PRINTED, 0, 1)


def _sampled(photo: Photo, position: NDArray[np.float32], known: NDArray[np.bool_]) -> Picture:
    """Brightness (H, W), 0 to 1, at positions (h, w, 2) of cells."""
    low = np.maximum(np.floor(position[known].min(axis=0)).astype(int) - _MARGIN, 0)
    high = np.ceil(position[known].max(axis=0)).astype(int) + _MARGIN
    photo = photo[low[1] : high[1], low[0] : high[0]]
    level = max(0, round(float(np.median(reduction_level(position)[known])) - np.log2(CELL)))
    for _ in range(level):
        photo = halve(photo)
    grey = photo.mean(axis=2, dtype=np.float32) / np.float32(np.iinfo(photo.dtype).max)
    shape = position.shape[0] * CELL, position.shape[1] * CELL
    inside = (position - low.astype(np.float32)) / np.float32(2**level)
    at = np.stack([enlarge(inside[..., axis], shape) - np.float32(0.5) for axis in (1, 0)])
    return np.asarray(ndimage.map_coordinates(grey, at, order=3, mode="nearest"))


def _without_light(picture: Picture, known: NDArray[np.bool_]) -> Picture:
    """The picture less its mean around each place, by its contrast around there."""
    shape, weight = picture.shape, known.astype(np.float32)
    share = np.maximum(ndimage.gaussian_filter(weight, _LIGHT / CELL), _LEAST_KNOWN)
    mean = ndimage.gaussian_filter(shrink(picture, CELL) * weight, _LIGHT / CELL) / share
    detail = ndimage.gaussian_filter(picture, _NOISE) - enlarge(mean, shape)
    wide = np.maximum(ndimage.gaussian_filter(weight, _CONTRAST_OVER * _LIGHT / CELL), _LEAST_KNOWN)
    square = ndimage.gaussian_filter(shrink(detail**2, CELL) * weight, _CONTRAST_OVER * _LIGHT / CELL)
    contrast = np.sqrt(square / wide)
    return detail / (enlarge(contrast, shape) + np.float32(_QUIET)) * at_pixels(known)


def at_pixels(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """A mask of cells as one of pixels."""
    return np.repeat(np.repeat(cells, CELL, axis=0), CELL, axis=1)
