"""What each photo shows of the page, in cells: its print, its light, and how much detail it holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..camera import Camera
from ..numeric.image import linear_light, sample_bilinear
from ..numeric.threads import in_threads
from ..page.page_cells import ReadPhoto, projected_area, smooth_known
from ..page.photo_colors import Photo, halve, reduction_level
from ..page.raster import PageLookup
from ..sheet import FlatMap, Sheet
from ..tracks.page_print import PagePrint, page_print, print_cells
from ..watch import SILENT, Watch

Values = NDArray[np.float32]

# Values without a figure are choices; no measurement of them is recorded.
# Pixels of the longer side of the page on which photos are compared: their own, within these limits. At 1600 pixels
# photos are aligned to a tenth of a pixel of a page of 300 dpi.
_SIDE = (600, 1600)
_BLOCK = 8  # photo pixels whose detail is averaged
_DARK = 0.02  # linear light below which noise counts as detail, and the light cannot be compared
_BURNT = 0.93  # linear light of the darkest channel above which nothing can be distinguished: 247 of 255
_DETAIL_SCALE = 0.02  # of the page's longer side, over which detail is averaged
# Of the sheet's blocks: the detail of blank paper, which is noise; of blocks of 64 pixels a tenth have 0.8 of the mean.
_NOISE_QUANTILE, _NOISE_OF_QUANTILE = 0.1, 1.25
_NO_PRINT = 2e-4  # mean squared gradient of the logarithm of light: with less there is no print

# Area in a photo as a share of the largest in any: with the first it does not count at all, from the second on fully.
# Parts seen that much at a slant are smeared, and a slightly wrong surface shows what is beside or behind the paper.
_SMALLEST, _LARGE = 0.15, 0.35


@dataclass(frozen=True)
class PhotoViews:
    """What n photos show of a page of (h, w) cells.

    Attributes
    ----------
    prints : tuple of PagePrint
    color : (n, h, w, 3) float32 array
        Logarithm of linear light.
    burnt : (n, h, w) bool array
        Where all channels are at their upper end.
    area : (n, h, w) float32 array
        Photo pixels per area of the page.
    noise : (n,) float32 array
        Detail per photo pixel where there is no print, less than which none counts.
    detail : (n, h, w) float32 array
        Detail per area of the page: squared gradient of the logarithm of light, less that of noise. Where there is no
        print, photos of the same resolution have the same.
    page : (h, w) bool array
        Where the sheet is.
    """

    prints: tuple[PagePrint, ...]
    color: NDArray[np.float32]
    burnt: NDArray[np.bool_]
    area: NDArray[np.float32]
    noise: NDArray[np.float32]
    detail: NDArray[np.float32]
    page: NDArray[np.bool_]

    @property
    def visible(self) -> NDArray[np.bool_]:
        """Which cells (n, h, w) each photo shows."""
        return np.stack([print_.known for print_ in self.prints])

    @property
    def large_enough(self) -> NDArray[np.float32]:
        """0 to 1 (n, h, w): whether each photo shows a cell large enough beside the others."""
        share = self.area / np.maximum(self.area.max(axis=0), 1e-12)
        return np.clip((share - _SMALLEST) / (_LARGE - _SMALLEST), 0, 1)


def view_cells(sheet: Sheet, flat: FlatMap, per_unit: float) -> PageLookup:
    """The cells of a page in which photos are compared; it has ``per_unit`` pixels per page unit."""
    return print_cells(sheet, flat, per_unit, _SIDE)


def view_photos(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    cells: PageLookup,
    threads: int = 1,
    watch: Watch = SILENT,
) -> PhotoViews:
    """Look at the page, whose cells are those of `view_cells`, in every photo.

    Raises
    ------
    Cancelled
    """

    def look(item: tuple[Camera, Photo]) -> tuple[PagePrint, Values, Values, float, Values]:
        camera, photo = item
        print_ = page_print(sheet, cells, camera, photo)
        area = projected_area(sheet, flat, cells, camera)
        noise, detail = _noise_and_detail(photo, print_)
        return print_, _color(photo, print_), area, noise, detail * area

    looks = []
    photos = ((camera, read_photo(index)) for index, camera in enumerate(cameras))
    for each in in_threads(look, photos, threads):
        looks.append(each)
        watch.step(len(looks) / len(cameras), "Looking at the page in all photos")
    prints, color, area, noise, detail = zip(*looks, strict=True)
    return PhotoViews(
        prints,
        np.log(np.maximum(color, _DARK)),
        np.min(color, axis=-1) > _BURNT,
        np.stack(area),
        np.array(noise, np.float32),
        np.stack(detail),
        cells.triangle >= 0,
    )


def _color(photo: Photo, print_: PagePrint) -> NDArray[np.float32]:
    """Linear light (h, w, 3) of the cells in a photo; 0 where it does not show them."""
    if not print_.known.any():
        return np.zeros((*print_.known.shape, 3), np.float32)
    level = max(0, round(float(np.median(reduction_level(print_.position)[print_.known]))))
    for _ in range(level):
        photo = halve(photo)
    color = sample_bilinear(linear_light(photo), np.nan_to_num(print_.position) / 2**level)
    return np.where(print_.known[..., None], color, 0).astype(np.float32)


def _noise_and_detail(photo: Photo, print_: PagePrint) -> tuple[float, Values]:
    """The detail of noise, and that (h, w) around the cells in a photo less that of noise, both per photo pixel."""
    if not print_.known.any():
        return 0.0, np.zeros(print_.known.shape, np.float32)
    column, row = np.moveaxis(np.nan_to_num(print_.position / _BLOCK).astype(int), -1, 0)
    top, left = row[print_.known].min(), column[print_.known].min()
    bottom, right = row[print_.known].max() + 1, column[print_.known].max() + 1
    blocks = _gradient_energy(photo[top * _BLOCK : bottom * _BLOCK, left * _BLOCK : right * _BLOCK, 1])
    row, column = (row - top).clip(0, len(blocks) - 1), (column - left).clip(0, blocks.shape[1] - 1)
    energy = np.where(print_.known, blocks[row, column], 0)
    noise = _NOISE_OF_QUANTILE * float(np.quantile(energy[print_.known], _NOISE_QUANTILE))
    energy = np.maximum(energy - np.float32(noise), 0)
    return noise, smooth_known(energy, print_.known, _DETAIL_SCALE * max(energy.shape)) + np.float32(_NO_PRINT)


def _gradient_energy(channel: NDArray[np.unsignedinteger]) -> NDArray[np.float32]:
    """Mean squared gradient of the logarithm of linear light (h, w) in each block."""
    levels = np.arange(np.iinfo(channel.dtype).max + 1, dtype=channel.dtype)
    table = np.log(linear_light(levels[:, None])[:, 0, 0] + np.float32(_DARK))
    rows, columns = (length // _BLOCK for length in channel.shape)
    if min(rows, columns) == 0:
        return np.zeros((1, 1), np.float32)
    energy = np.empty((rows, columns), np.float32)
    for row in range(rows):
        light = table[channel[row * _BLOCK : (row + 1) * _BLOCK, : columns * _BLOCK]]
        square = np.zeros_like(light)
        square[:, 1:-1] = (light[:, 2:] - light[:, :-2]) ** 2
        square[1:-1] += (light[2:] - light[:-2]) ** 2
        energy[row] = square.reshape(_BLOCK, columns, _BLOCK).mean(axis=(0, 2)) / 4
    return energy
