"""The page image from the photos: from the reference photo alone, or from the best one for each region."""

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
from .page_cells import ReadPhoto, brightness, enlarge, projected_area, shifted, smooth_known, visible_cells
from .registration import displacement
from .warp import PageLookup, Photo, page_lookup, photo_positions, sample

_CELLS = 192  # of the coarse page on which photos are chosen, along its longer side
_BLOCK = 8  # photo pixels whose sharpness is averaged
_SMALLEST_REGION = 0.005  # of the page
_LIGHT_SCALE = 0.015  # of the page's longer side: differences of light wider than this are evened out
_SHARPNESS_SCALE = 0.04
_LEAST_WEIGHT = 1 / 64
_EDGE_CELLS = 2  # along the paper's edge what lies beside the paper may show: its light is not the page's
_BESIDE_CELLS = 6  # from the paper's edge: as far in the surface may be so wrong that a photo shows the desk there
_OTHER_THING = 0.7  # difference of the logarithm of light that no paper in even light has
_ALIGNED_AT = 1000  # pixels of the page's longer side at which photos are laid on each other
_FARTHEST = 0.008  # of the page's longer side: print that lies farther off is not the same print
_NO_PRINT = 1e-5  # squared gradient below which only noise is seen; there the area alone decides


@dataclass(frozen=True)
class TextureSettings:
    """How the page image is made.

    Attributes
    ----------
    source : str
        ``"reference"``: from the reference photo alone, whose colours stay untouched. ``"best"``: each region from
        the photo that shows most of it, by projected area times sharpness, with the light evened between photos.
    sampling : str
        ``"bicubic"`` or ``"linear"``, see `warp.sample`.
    """

    source: str = "reference"
    sampling: str = "bicubic"


@dataclass(frozen=True)
class PageTexture:
    """The page image and where it comes from.

    Attributes
    ----------
    image : (H, W, 3) array
        Of the reference photo's type; white where no photo shows the page.
    photo : (H, W) int16 array
        Which photo each pixel is from (the one with the most weight where two are blended), -1 for none.
    position : (H, W, 2) float32 array
        Where in that photo, distorted pixels; NaN for none.
    blank_share : float
        Share of the page's pixels that are in no photo or outside the mesh.
    """

    image: Photo
    photo: NDArray[np.int16]
    position: NDArray[np.float32]
    blank_share: float


def render_page(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    size_px: tuple[int, int],
    settings: TextureSettings = TextureSettings(),
    watch: Watch = SILENT,
) -> PageTexture:
    """Make the page image.

    Parameters
    ----------
    sheet : Sheet
    flat : FlatMap
    cameras : sequence of Camera
    read_photo : callable
        ``read_photo(index)`` gives the pixels (h, w, 3), uint8 or uint16, of ``cameras[index]``. Photos are asked for
        one by one and not kept.
    reference : int
        Index of the reference photo.
    size_px : (width, height)
        Of the page image.

    Raises
    ------
    Cancelled
    """
    if settings.source not in ("reference", "best"):
        raise ValueError(f"source must be 'reference' or 'best', not {settings.source!r}")
    lookup = page_lookup(sheet, flat, size_px)
    watch.step(0.1, "Sampling the photo")
    if settings.source == "reference" or len(cameras) == 1:
        position = photo_positions(sheet, lookup, cameras[reference])
        image = sample(read_photo(reference), position, settings.sampling)
        covered = np.isfinite(position[..., 0])
        photo = np.where(covered, reference, -1).astype(np.int16)
        return PageTexture(image, photo, position, float(1 - covered.mean()))
    plan = _plan(sheet, flat, cameras, read_photo, reference, max(size_px), watch.part(0.1, 0.5))
    return _compose(sheet, lookup, cameras, read_photo, plan, settings.sampling, watch.part(0.5, 1))


@dataclass(frozen=True)
class _Plan:
    """On the coarse page (h, w): how much of each photo is taken, from where, and by what it is multiplied.

    Attributes
    ----------
    weight : (n, h, w) float32 array
    gain : (n, h, w, 3) float32 array
    shift : (n, h, w, 2) float32 array
        By how much the photo's print lies beside the reference's, in widths and heights of the page.
    """

    weight: NDArray[np.float32]
    gain: NDArray[np.float32]
    shift: NDArray[np.float32]


def _plan(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    longest: int,
    watch: Watch,
) -> _Plan:
    cell = max(flat.width, flat.height) / _CELLS
    size = (max(2, round(flat.width / cell)), max(2, round(flat.height / cell)))
    lookup = page_lookup(sheet, flat, size)
    shape = (len(cameras), size[1], size[0])
    visible = np.zeros(shape, bool)
    score = np.zeros(shape, np.float32)
    color = np.zeros((*shape, 3), np.float32)
    for index, camera in enumerate(cameras):
        watch.step(0.6 * index / len(cameras), "Choosing the best photo for each region")
        photo = read_photo(index)
        position = photo_positions(sheet, lookup, camera)
        visible[index] = visible_cells(sheet, lookup, camera, position)
        color[index] = np.log(np.maximum(brightness(sample(photo, position)), 0.01))
        sharpness = _at_blocks(_gradient_energy(photo), position)
        sharpness = smooth_known(sharpness, visible[index], _SHARPNESS_SCALE * _CELLS) + _NO_PRINT
        score[index] = projected_area(sheet, flat, lookup, camera) * sharpness
    page = lookup.triangle >= 0
    visible &= ~_beside_paper(color, visible, reference, page)
    nowhere = ~visible.any(axis=0) & page
    visible[reference] |= nowhere
    label = choose_regions(score, visible)
    weight = np.stack([ndimage.gaussian_filter((label == k).astype(np.float32), 1.0) for k in range(len(cameras))])
    weight *= visible
    weight /= np.maximum(weight.sum(axis=0), 1e-6)
    inner = ndimage.binary_erosion(page, iterations=_EDGE_CELLS)
    gain = _even_light(color, visible & inner, reference)
    shift = _align(sheet, flat, cameras, read_photo, reference, weight, longest, watch.part(0.6, 1))
    return _Plan(weight, gain, shift)


def _align(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    weight: NDArray[np.float32],
    longest: int,
    watch: Watch,
) -> NDArray[np.float32]:
    """How far the print of each photo (n, h, w, 2) lies beside the reference's; see `_Plan.shift`.

    The surface is never exact: a point of it that lies a little too high comes from a little beside in each photo.
    """
    shift = np.zeros((*weight.shape, 2), np.float32)
    longest = min(longest, _ALIGNED_AT)
    scale = longest / max(flat.width, flat.height)
    size = (max(2, round(flat.width * scale)), max(2, round(flat.height * scale)))
    lookup = page_lookup(sheet, flat, size)
    # At the very edge the desk would be laid on the desk.
    inner = ndimage.binary_erosion(lookup.triangle >= 0, iterations=max(1, round(_EDGE_CELLS * longest / _CELLS)))

    def page_of(index: int) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        position = photo_positions(sheet, lookup, cameras[index])
        page = np.log(brightness(sample(read_photo(index), position)).mean(axis=2) + 0.05)
        return page, np.isfinite(position[..., 0]) & inner

    used = [k for k in range(len(cameras)) if k != reference and weight[k].max() > _LEAST_WEIGHT]
    if not used:
        return shift
    fixed, fixed_known = page_of(reference)
    for done, index in enumerate(used):
        watch.step(done / len(used), "Laying the photos on each other")
        moving, known = page_of(index)
        moved = displacement(fixed, moving, known & fixed_known, _FARTHEST * longest)
        zoom = (weight.shape[1] / size[1], weight.shape[2] / size[0])
        for axis in (0, 1):
            coarse = ndimage.zoom(moved[..., axis] / size[axis], zoom, order=1, grid_mode=True, mode="nearest")
            shift[index, ..., axis] = coarse
    return shift


def _beside_paper(
    color: NDArray[np.float32], visible: NDArray[np.bool_], reference: int, page: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Which cells (n, h, w) of each photo show what lies beside the paper.

    The paper's edge is where the reference has it. A cell beside it is unlike the reference's and joined to the edge
    by such cells.
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
            beside[index] = ndimage.binary_dilation(joined, iterations=_EDGE_CELLS)
    return beside


def _gradient_energy(photo: Photo) -> NDArray[np.float32]:
    """Mean squared gradient of the logarithm of brightness in each block of the photo."""
    height, width = (length // _BLOCK * _BLOCK for length in photo.shape[:2])
    if min(height, width) == 0:
        return np.zeros((1, 1), np.float32)
    energy = np.zeros((height // _BLOCK, width // _BLOCK), np.float32)
    band = _BLOCK * 32
    for top in range(0, height, band):
        rows = photo[top : min(top + band, height), :width]
        # Tempered in the dark, so that noise does not count as sharpness there.
        light = np.log(brightness(rows).mean(axis=2) + 0.05)
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
    cost: Array = np.where(visible, np.log(np.maximum(score, 1e-12)), -1e3)
    cost -= cost.max(axis=0)
    belief = _softmax(4.0 * cost)
    for _ in range(15):
        around = np.stack([ndimage.gaussian_filter(part, 3.0) for part in belief])
        belief = _softmax(4 * cost + 8 * around)
    label = np.where(visible.any(axis=0), belief.argmax(axis=0), -1)
    return _without_islands(label, visible)


def _softmax(values: Array) -> Array:
    powers = np.exp(values - values.max(axis=0))
    return powers / powers.sum(axis=0)


def _without_islands(label: NDArray[np.int64], visible: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Small regions go to the photo beside them, if it sees them."""
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


def _even_light(color: NDArray[np.float32], visible: NDArray[np.bool_], reference: int) -> NDArray[np.float32]:
    """What each photo (n, h, w, 3) is multiplied by so that all show the page in the same light.

    That light is the median of the photos at the reference's exposure: a glare or a shadow in one of them is gone.
    """
    sigma = _LIGHT_SCALE * _CELLS
    light = np.stack([smooth_known(c, v, sigma) if v.any() else c for c, v in zip(color, visible, strict=True)])
    levelled = np.full_like(light, np.nan)
    for index, seen in enumerate(visible):
        both = seen & visible[reference]
        if seen.any():
            exposure = np.median((light[index] - light[reference])[both if both.any() else seen], axis=0)
            levelled[index] = np.where(seen[..., None], light[index] - exposure, np.nan)
    seen_at_all = visible.any(axis=0)
    target = np.zeros(light.shape[1:], np.float32)
    target[seen_at_all] = np.nanmedian(levelled[:, seen_at_all], axis=0)
    target = smooth_known(target, seen_at_all, sigma / 2)
    return np.exp(np.clip(target - light, -1.5, 1.5))


def _compose(
    sheet: Sheet,
    lookup: PageLookup,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    plan: _Plan,
    sampling: str,
    watch: Watch,
) -> PageTexture:
    shape = lookup.triangle.shape
    total = np.zeros((*shape, 3), np.float32)
    weight_sum = np.zeros(shape, np.float32)
    most = np.zeros(shape, np.float32)
    photo_index = np.full(shape, -1, np.int16)
    position_of_best = np.full((*shape, 2), np.nan, np.float32)
    used = [index for index in range(len(cameras)) if plan.weight[index].max() > _LEAST_WEIGHT]
    dtype: np.dtype[np.unsignedinteger] = np.dtype(np.uint8)
    for done, index in enumerate(used):
        watch.step(done / len(used), "Blending the photos")
        weight = enlarge(plan.weight[index], shape)
        weight[weight <= _LEAST_WEIGHT] = 0
        needed = PageLookup(np.where(weight > 0, lookup.triangle, np.int32(-1)), lookup.barycentric)
        position = shifted(photo_positions(sheet, needed, cameras[index]), plan.shift[index])
        photo = read_photo(index)
        dtype = max(dtype, photo.dtype)
        weight[~np.isfinite(position[..., 0])] = 0
        warped = sample(photo, position, sampling)
        scale = np.float32(1 / np.iinfo(photo.dtype).max)
        for channel in range(3):
            gain = enlarge(plan.gain[index, ..., channel], shape)
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
