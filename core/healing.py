"""The reference photo's page, with what is wrong in it taken from the photos that show it better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.linalg import spsolve

from .blemishes import KINDS, Blemishes, find_blemishes
from .camera import Camera
from .page_cells import ReadPhoto, enlarge, shifted, smooth_known
from .page_views import PageViews, view_page
from .sheet import FlatMap, Sheet
from .texture import PageTexture, align
from .warp import PageLookup, page_lookup, photo_positions, sample
from .watch import SILENT, Watch

Cells = NDArray[np.bool_]
Values = NDArray[np.float32]

_FEWEST_CELLS = 20  # of a region that are worth another photo
_SMALLEST_PART = 0.03  # of a region, likewise
_ALIGNED_AT = 640  # pixels of the page's longer side at which photos are laid on the reference's print
_FEATHER = 1.0  # cells
_LEAST_WEIGHT = 1 / 64
_LIGHT_SCALE = 4.0  # cells: light between photos differs no finer
_SPECKLES = 5  # cells: print that lies beside itself is smaller
_DARK = np.log(0.2)  # brightness below which a difference says little of the light
_MOST_GAIN = 0.7


@dataclass(frozen=True)
class Blemish:
    """One kind of blemish of the reference's page.

    Attributes
    ----------
    kind : str
        One of `blemishes.KINDS`.
    share : float
        Of the page.
    healed_share : float
        Of the page, taken from ``photos``; the rest is as the reference has it.
    photos : tuple of int
        The one that most was taken from comes first.
    """

    kind: str
    share: float
    healed_share: float
    photos: tuple[int, ...]


def heal_page(
    texture: PageTexture,
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    watch: Watch = SILENT,
) -> tuple[PageTexture, tuple[Blemish, ...]]:
    """Replace what glare, blur and passing shadows spoil in the reference's page.

    Parameters
    ----------
    texture : PageTexture
        The page from the reference photo alone; stays as it is.
    sheet, flat, cameras, read_photo, reference
        As for `texture.render_page`.

    Returns
    -------
    PageTexture
        Pixels outside the healed regions are those of ``texture``.
    tuple of Blemish
        The kinds that were found.

    Raises
    ------
    Cancelled
    """
    views = view_page(sheet, flat, cameras, read_photo, watch.part(0, 0.5))
    blemishes = find_blemishes(views, reference)
    spoilt = np.any([blemishes.found[kind] for kind in KINDS], axis=0)
    if not spoilt.any():
        return texture, ()
    source = choose_sources(spoilt, blemishes)
    told = tuple(
        _told(kind, blemishes.found[kind], source, views.page) for kind in KINDS if blemishes.found[kind].any()
    )
    weight = _weights(source, views)
    gain = _gains(views, blemishes, reference, weight)
    unlike = blemishes.found["glare"] | blemishes.found["shadow"]
    step = watch.part(0.5, 0.8)
    longest = min(_ALIGNED_AT, max(texture.photo.shape))
    shift = align(sheet, flat, cameras, read_photo, reference, weight, longest, step, unlike)
    healed = _lay_over(texture, sheet, flat, cameras, read_photo, (weight, gain, shift), watch.part(0.8, 1))
    return healed, told


def choose_sources(spoilt: Cells, blemishes: Blemishes) -> NDArray[np.int64]:
    """The photo that each spoilt cell is taken from, as few photos to a region as there can be; -1 for none.

    Parameters
    ----------
    spoilt : (h, w) bool array
    blemishes : Blemishes

    Returns
    -------
    (h, w) int array
    """
    source = np.full(spoilt.shape, -1, np.int64)
    region, count = ndimage.label(spoilt)
    value = blemishes.better * np.clip(blemishes.sharpness, 0, 1)
    for number in range(1, count + 1):
        left = region == number
        fewest = max(_FEWEST_CELLS, _SMALLEST_PART * left.sum())
        for _ in range(len(value)):
            usable = value * left
            best = int(usable.sum(axis=(1, 2)).argmax())
            taken = left & blemishes.better[best]
            if taken.sum() < fewest:
                break
            source[taken] = best
            left &= ~taken
    return source


def _told(kind: str, found: Cells, source: NDArray[np.int64], page: Cells) -> Blemish:
    photos, cells = np.unique(source[found & (source >= 0)], return_counts=True)
    order = np.argsort(-cells, kind="stable")
    total = float(page.sum())
    return Blemish(kind, found.sum() / total, cells.sum() / total, tuple(int(k) for k in photos[order]))


def _weights(source: NDArray[np.int64], views: PageViews) -> Values:
    """How much of each photo (n, h, w) is taken: all within its regions, fading around them."""
    weight = np.zeros(views.visible.shape, np.float32)
    for index in np.unique(source[source >= 0]):
        # Half of the weight is reached at the region's edge, which lies outside of the blemish by the fringe.
        own = ndimage.gaussian_filter((source == index).astype(np.float32), _FEATHER)
        weight[index] = own * views.visible[index]
    return weight / np.maximum(weight.sum(axis=0), 1)


def _gains(views: PageViews, blemishes: Blemishes, reference: int, weight: Values) -> Values:
    """What brightness of each photo (n, h, w, 3) is multiplied by to lie in the reference's light.

    The light is compared where the reference is not glaring or shaded, and bridges the rest as a membrane does: at the
    edges of a healed region there is no step.
    """
    gain = np.zeros((*weight.shape, 3), np.float32)
    dark = views.color[reference].mean(axis=-1) < _DARK
    known = ndimage.binary_erosion(views.page, iterations=3) & ~dark & views.visible[reference]
    known &= ~ndimage.binary_dilation(blemishes.found["glare"] | blemishes.found["shadow"], iterations=2)
    for index in np.flatnonzero(weight.max(axis=(1, 2)) > _LEAST_WEIGHT):
        compared = known & blemishes.better[index]
        if not compared.any():
            continue
        difference = views.color[reference] - views.color[index]
        difference = ndimage.median_filter(difference, (_SPECKLES, _SPECKLES, 1))
        light = smooth_known(difference, compared, _LIGHT_SCALE)
        near = ndimage.binary_dilation(compared, iterations=2)
        gain[index] = np.clip(np.stack([membrane(light[..., c], near) for c in range(3)], -1), -_MOST_GAIN, _MOST_GAIN)
    return np.exp(gain)


def membrane(values: Values, known: Cells) -> Values:
    """The values (h, w) where known, and elsewhere those of a membrane held there: each the mean of its neighbours."""
    if known.all() or not known.any():
        return values
    number = np.full(known.shape, -1)
    number[~known] = np.arange((~known).sum())
    rows, columns, entries = [], [], []
    right = np.zeros(int((~known).sum()))
    degree = np.zeros_like(right)
    for one, other in (
        ((slice(None), slice(None, -1)), (slice(None), slice(1, None))),
        ((slice(None, -1), slice(None)), (slice(1, None), slice(None))),
    ):
        for a, b in ((one, other), (other, one)):
            mine, theirs, held = number[a].ravel(), number[b].ravel(), values[b].ravel()
            open_here = mine >= 0
            np.add.at(degree, mine[open_here], 1)
            free = open_here & (theirs >= 0)
            rows.append(mine[free])
            columns.append(theirs[free])
            entries.append(np.full(int(free.sum()), -1.0))
            fixed = open_here & (theirs < 0)
            np.add.at(right, mine[fixed], held[fixed])
    size = len(right)
    matrix = sparse.coo_array((np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))), (size, size))
    out = values.copy()
    out[~known] = spsolve((matrix + sparse.diags_array(degree)).tocsc(), right)
    return out


def _lay_over(
    texture: PageTexture,
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    plan: tuple[Values, Values, Values],
    watch: Watch,
) -> PageTexture:
    """The page with each photo laid over it by its weight, in the reference's light and on its print."""
    shape = texture.photo.shape
    lookup = page_lookup(sheet, flat, (shape[1], shape[0]))
    image, photo_index, position = texture.image.copy(), texture.photo.copy(), texture.position.copy()
    white = np.iinfo(image.dtype).max
    used = np.flatnonzero(plan[0].max(axis=(1, 2)) > _LEAST_WEIGHT)
    added = np.zeros((*shape, 3), np.float32)
    total = np.zeros(shape, np.float32)
    most = np.full(shape, 0.5, np.float32)
    for done, index in enumerate(used):
        watch.step(done / len(used), "Healing the page from other photos")
        weight, gain, shift = (part[index] for part in plan)
        share = enlarge(weight, shape)
        share[(share <= _LEAST_WEIGHT) | (texture.photo < 0)] = 0
        needed = PageLookup(np.where(share > 0, lookup.triangle, np.int32(-1)), lookup.barycentric)
        there = shifted(photo_positions(sheet, needed, cameras[index]), shift)
        here = (share > 0) & np.isfinite(there[..., 0])
        there[~here] = np.nan
        photo = read_photo(int(index))
        pixels = sample(photo, there)[here] * np.float32(white / np.iinfo(photo.dtype).max)
        light = np.stack([enlarge(gain[..., channel], shape)[here] for channel in range(3)], axis=-1)
        added[here] += share[here, None] * np.minimum(pixels * light, white)
        total[here] += share[here]
        better = here & (share >= most)
        most[better] = share[better]
        photo_index[better] = index
        position[better] = there[better]
    changed = total > 0
    mixed = image[changed] * (1 - total[changed, None]) + added[changed]
    image[changed] = np.rint(np.clip(mixed, 0, white)).astype(image.dtype)
    return replace(texture, image=image, photo=photo_index, position=position)
