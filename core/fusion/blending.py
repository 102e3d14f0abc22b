"""Blend the page image from several photos."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..camera import Camera
from ..numeric.image import encoded, linear_light
from ..numeric.threads import in_threads
from ..page.page_cells import ReadPhoto, enlarge
from ..page.photo_colors import Photo, sample
from ..page.raster import PageLookup
from ..page.texture import PageTexture
from ..page.warp import photo_positions
from ..sheet import Sheet
from ..watch import SILENT, Watch

Values = NDArray[np.float32]

# Values without a figure are choices; no measurement of them is recorded.
_LEAST_WEIGHT = 1 / 64  # of a photo among those blended: with less it has no share
_ROWS = 256  # of the page image that are blended at once


@dataclass(frozen=True)
class Layers:
    """What n photos give to the page image, on cells (h, w).

    Attributes
    ----------
    sheet : Sheet
    lookup : PageLookup
        Of the page image's pixels.
    weight : (n, h, w) float32 array
        The share of each photo.
    gain : (n, h, w, 3) float32 array
        The factor on its linear light.
    moves : sequence of n (h, w, 2) float32 arrays
        What is added to places in it, pixels.
    """

    sheet: Sheet
    lookup: PageLookup
    weight: Values
    gain: Values
    moves: Sequence[Values]

    def used(self) -> list[int]:
        """The photos that have a share."""
        return [index for index, weight in enumerate(self.weight) if weight.max() > _LEAST_WEIGHT]

    def bands(self, index: int) -> list[slice]:
        """Bands of rows of the page image in which a photo has a share."""
        height = self.lookup.triangle.shape[0]
        per_cell = height / self.weight.shape[1]
        rows = np.flatnonzero(self.weight[index].max(axis=1) > _LEAST_WEIGHT)
        begin = max(int((rows[0] - 1) * per_cell), 0)
        end = min(int(np.ceil((rows[-1] + 2) * per_cell)), height)
        return [slice(top, min(top + _ROWS, end)) for top in range(begin, end, _ROWS)]

    def layer(self, index: int, camera: Camera, photo: Photo, rows: slice) -> tuple[Values, Values, Values]:
        """Weight (H, W), places (H, W, 2) and linear light (H, W, 3) of one photo on a band of rows."""
        shape = self.lookup.triangle.shape
        weight = enlarge(self.weight[index], shape, rows)
        weight[weight <= _LEAST_WEIGHT] = 0
        needed = np.where(weight > 0, self.lookup.triangle[rows], np.int32(-1))
        there = photo_positions(self.sheet, PageLookup(needed, self.lookup.barycentric[rows]), camera)
        there += enlarge(self.moves[index], shape, rows)
        weight[~np.isfinite(there[..., 0])] = 0
        return weight, there, linear_light(sample(photo, there)) * enlarge(self.gain[index], shape, rows)


def blend(
    layers: Layers, cameras: Sequence[Camera], read_photo: ReadPhoto, threads: int = 1, watch: Watch = SILENT
) -> PageTexture:
    """The page image: the mean of the photos' linear light, each read once, and only one of them in memory.

    Raises
    ------
    Cancelled
    """
    shape = layers.lookup.triangle.shape
    total = np.zeros((*shape, 3), np.float32)
    weights, most = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    photo_index = np.full(shape, -1, np.int16)
    position = np.full((*shape, 2), np.nan, np.float32)
    dtype: np.dtype[np.unsignedinteger] = np.dtype(np.uint8)
    used = layers.used()
    for done, index in enumerate(used):
        watch.step(done / len(used), "Blending the photos")
        photo = read_photo(index)
        dtype = max(dtype, photo.dtype)

        def add(rows: slice, index: int = index, photo: Photo = photo) -> None:
            weight, there, light = layers.layer(index, cameras[index], photo, rows)
            total[rows] += weight[..., None] * light
            weights[rows] += weight
            better = weight > most[rows]
            most[rows][better] = weight[better]
            photo_index[rows][better] = index
            position[rows][better] = there[better]

        for _ in in_threads(add, layers.bands(index), threads):
            pass
    covered = weights > 0
    image = np.empty((*shape, 3), dtype)
    for top in range(0, shape[0], _ROWS):
        rows = slice(top, top + _ROWS)
        light = total[rows] / np.where(covered[rows], weights[rows], 1)[..., None]
        light[~covered[rows]] = 1
        image[rows] = encoded(light, dtype)
    return PageTexture(image, photo_index, position, float(1 - covered.mean()))
