"""Blend the page image from several photos."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..camera import Camera
from ..sheet import Sheet
from ..watch import SILENT, Watch
from .page_cells import LEAST_WEIGHT, ReadPhoto, enlarge, shifted
from .texture import PageTexture
from .warp import PageLookup, photo_positions, sample


@dataclass(frozen=True)
class Blend:
    """On the coarse page (h, w): the share of each of n photos, its displacement, and the factor on its brightness.

    Attributes
    ----------
    weight : (n, h, w) float32 array
    gain : (n, h, w, 3) float32 array
    shift : (n, h, w, 2) float32 array
        Displacement of the photo's print from the reference's, in widths and heights of the page.
    """

    weight: NDArray[np.float32]
    gain: NDArray[np.float32]
    shift: NDArray[np.float32]


def blend_photos(
    sheet: Sheet,
    lookup: PageLookup,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    blend: Blend,
    watch: Watch = SILENT,
) -> PageTexture:
    """Make the page image from the photos that have a share in it, read one after the other.

    Parameters
    ----------
    sheet : Sheet
    lookup : PageLookup
        Of the page image's pixels.
    cameras : sequence of Camera
    read_photo : callable
        As for `render.render_page`.
    blend : Blend
    watch : Watch

    Raises
    ------
    Cancelled
    """
    shape = lookup.triangle.shape
    total = np.zeros((*shape, 3), np.float32)
    weight_sum = np.zeros(shape, np.float32)
    most = np.zeros(shape, np.float32)
    photo_index = np.full(shape, -1, np.int16)
    position_of_best = np.full((*shape, 2), np.nan, np.float32)
    used = [index for index in range(len(cameras)) if blend.weight[index].max() > LEAST_WEIGHT]
    dtype: np.dtype[np.unsignedinteger] = np.dtype(np.uint8)
    for done, index in enumerate(used):
        watch.step(done / len(used), "Blending the photos")
        weight = enlarge(blend.weight[index], shape)
        weight[weight <= LEAST_WEIGHT] = 0
        needed = PageLookup(np.where(weight > 0, lookup.triangle, np.int32(-1)), lookup.barycentric)
        position = shifted(photo_positions(sheet, needed, cameras[index]), blend.shift[index])
        photo = read_photo(index)
        dtype = max(dtype, photo.dtype)
        weight[~np.isfinite(position[..., 0])] = 0
        warped = sample(photo, position)
        scale = np.float32(1 / np.iinfo(photo.dtype).max)
        for channel in range(3):
            gain = enlarge(blend.gain[index, ..., channel], shape)
            total[..., channel] += warped[..., channel] * scale * gain * weight
        weight_sum += weight
        better = weight > most
        most[better] = weight[better]
        photo_index[better] = index
        position_of_best[better] = position[better]
    covered = weight_sum > 0
    white = np.iinfo(dtype).max
    total /= np.where(covered, weight_sum, 1)[..., None]
    total[~covered] = 1
    image = np.rint(np.clip(total, 0, 1, out=total) * white).astype(dtype)
    return PageTexture(image, photo_index, position_of_best, float(1 - covered.mean()))
