"""Choose the photo for each region of the page: the one that shows it largest and sharpest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..camera import Camera
from ..sheet import FlatMap, Sheet
from ..watch import SILENT, Watch
from .page_cells import (
    CELLS,
    EDGE_CELLS,
    ReadPhoto,
    brightness,
    coarse_size,
    log_brightness,
    projected_area,
    smooth_known,
    visible_cells,
)
from .warp import Photo, page_lookup, photo_positions, sample

# The values below are choices; no measurement of them is recorded.
_BLOCK = 8  # photo pixels whose sharpness is averaged
_ROWS_AT_ONCE = 32  # blocks: a band of a photo fits into the processor's cache
_BLACKEST = 0.01  # brightness, 0 to 1, below which the light cannot be compared
_SHARPNESS_SCALE = 0.04  # of the page's longer side, over which sharpness is averaged
_NO_PRINT = 1e-5  # squared gradient below which only noise is seen; there the area alone decides
_SMALLEST_REGION = 0.005  # of the page
_BESIDE_CELLS = 6  # from the paper's edge: this near, the surface may be so wrong that a photo shows the table there
# Regions: how much the logarithm of a photo's score counts, and how much the photos chosen around a cell within this
# standard deviation (cells), which is applied so many times. Not seeing a cell outweighs both.
_SCORE_WEIGHT, _AROUND_WEIGHT, _AROUND, _ROUNDS, _UNSEEN = 4, 8, 3.0, 15, -1e3
_SEAM = 1.0  # cells, standard deviation, over which one photo passes into another
_OTHER_THING = 0.7  # difference of the logarithm of light that no paper in even light has


@dataclass(frozen=True)
class CellViews:
    """What n photos show of a page of (h, w) coarse cells.

    Attributes
    ----------
    color : (n, h, w, 3) float32 array
        Logarithm of brightness.
    visible : (n, h, w) bool array
        Which cells a photo shows; each cell of the page is visible in the reference at least.
    score : (n, h, w) float32 array
        Projected area times sharpness.
    page : (h, w) bool array
        Where the sheet is.
    """

    color: NDArray[np.float32]
    visible: NDArray[np.bool_]
    score: NDArray[np.float32]
    page: NDArray[np.bool_]


def view_cells(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    watch: Watch = SILENT,
) -> CellViews:
    """Look at the coarse page in every photo, one after the other.

    Parameters
    ----------
    sheet : Sheet
    flat : FlatMap
    cameras : sequence of Camera
    read_photo : callable
        As for `render.render_page`.
    reference : int
        Index of the reference photo.
    watch : Watch

    Raises
    ------
    Cancelled
    """
    size = coarse_size(flat)
    lookup = page_lookup(sheet, flat, size)
    shape = (len(cameras), size[1], size[0])
    visible = np.zeros(shape, bool)
    score = np.zeros(shape, np.float32)
    color = np.zeros((*shape, 3), np.float32)
    for index, camera in enumerate(cameras):
        watch.step(index / len(cameras), "Choosing the best photo for each region")
        photo = read_photo(index)
        position = photo_positions(sheet, lookup, camera)
        visible[index] = visible_cells(sheet, lookup, camera, position)
        color[index] = np.log(np.maximum(brightness(sample(photo, position)), _BLACKEST))
        sharpness = _at_blocks(_gradient_energy(photo), position)
        sharpness = smooth_known(sharpness, visible[index], _SHARPNESS_SCALE * CELLS) + _NO_PRINT
        score[index] = projected_area(sheet, flat, lookup, camera) * sharpness
    page = lookup.triangle >= 0
    visible &= ~_beside_paper(color, visible, reference, page)
    nowhere = ~visible.any(axis=0) & page
    visible[reference] |= nowhere
    return CellViews(color, visible, score, page)


def photo_weights(views: CellViews) -> NDArray[np.float32]:
    """The share of each photo (n, h, w) at each cell: all of one, or some of two where they meet."""
    label = choose_regions(views.score, views.visible)
    photos = range(len(views.score))
    weight = np.stack([ndimage.gaussian_filter((label == k).astype(np.float32), _SEAM) for k in photos])
    weight *= views.visible
    weight /= np.maximum(weight.sum(axis=0), 1e-6)
    return weight


def choose_regions(score: NDArray[np.float32], visible: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Give each cell the photo of the best score, in large regions.

    Parameters
    ----------
    score : (n, h, w) array
        Positive where a photo shows the cell well.
    visible : (n, h, w) bool array

    Returns
    -------
    (h, w) int array
        A photo that sees the cell; -1 where none does.
    """
    cost: Array = np.where(visible, np.log(np.maximum(score, 1e-12)), _UNSEEN)
    cost -= cost.max(axis=0)
    belief = _softmax(_SCORE_WEIGHT * cost)
    for _ in range(_ROUNDS):
        around = np.stack([ndimage.gaussian_filter(part, _AROUND) for part in belief])
        belief = _softmax(_SCORE_WEIGHT * cost + _AROUND_WEIGHT * around)
    label = np.where(visible.any(axis=0), belief.argmax(axis=0), -1)
    return _without_islands(label, visible)


def _softmax(values: Array) -> Array:
    powers = np.exp(values - values.max(axis=0))
    return powers / powers.sum(axis=0)


def _without_islands(label: NDArray[np.int64], visible: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Give small regions to the photo beside them, if it sees them."""
    large = np.zeros(label.shape, bool)
    for photo in range(len(visible)):
        region, count = ndimage.label(label == photo)
        size = np.bincount(region.ravel(), minlength=count + 1)
        size[0] = 0
        large |= size[region] >= _SMALLEST_REGION * label.size
    if not large.any():
        return label
    nearest = ndimage.distance_transform_edt(~large, return_distances=False, return_indices=True)
    beside = label[tuple(nearest)]
    sees = np.take_along_axis(visible, beside[None], axis=0)[0]
    return np.where(~large & sees & (label >= 0), beside, label)


def _beside_paper(
    color: NDArray[np.float32], visible: NDArray[np.bool_], reference: int, page: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Which cells (n, h, w) of each photo show the table beside the paper.

    The paper's edge is where the reference has it. Such a cell differs from the reference's and is connected to the
    edge by others like it.
    """
    rim = page & ~ndimage.binary_erosion(page)
    near = page & ~ndimage.binary_erosion(page, iterations=_BESIDE_CELLS)
    beside = np.zeros_like(visible)
    for index, seen in enumerate(visible):
        both = seen & visible[reference]
        if index != reference and both.any():
            difference = (color[index] - color[reference]).mean(axis=-1)
            unlike = both & near & (np.abs(difference - np.median(difference[both])) > _OTHER_THING)
            joined = ndimage.binary_propagation(rim & unlike, mask=unlike)
            beside[index] = ndimage.binary_dilation(joined, iterations=EDGE_CELLS)
    return beside


def _gradient_energy(photo: Photo) -> NDArray[np.float32]:
    """Mean squared gradient of the logarithm of brightness in each block of the photo."""
    height, width = (length // _BLOCK * _BLOCK for length in photo.shape[:2])
    if min(height, width) == 0:
        return np.zeros((1, 1), np.float32)
    energy = np.zeros((height // _BLOCK, width // _BLOCK), np.float32)
    band = _BLOCK * _ROWS_AT_ONCE
    for top in range(0, height, band):
        rows = photo[top : min(top + band, height), :width]
        light = log_brightness(brightness(rows).mean(axis=2))
        square = np.zeros_like(light)
        for axis in (0, 1):
            square += np.gradient(light, axis=axis) ** 2
        blocks = square.reshape(len(rows) // _BLOCK, _BLOCK, -1, _BLOCK).mean(axis=(1, 3))
        energy[top // _BLOCK : top // _BLOCK + len(blocks)] = blocks
    return energy


def _at_blocks(blocks: NDArray[np.float32], position: NDArray[np.float32]) -> NDArray[np.float32]:
    """The value of the block under each position; 0 where it is not finite."""
    column, row = np.moveaxis(np.nan_to_num(position / _BLOCK).astype(int), -1, 0)
    value = blocks[row.clip(0, blocks.shape[0] - 1), column.clip(0, blocks.shape[1] - 1)]
    return np.where(np.isfinite(position[..., 0]), value, 0)
