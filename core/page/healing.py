"""Heals the reference photo's page: replaces its blemishes from photos that show these regions better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..camera import Camera
from ..sheet import FlatMap, Sheet
from ..watch import SILENT, Watch
from .blemishes import Blemishes, find_blemishes
from .page_cells import LEAST_WEIGHT, ReadPhoto, between_cells, moved_by, smooth_known
from .page_light import membrane
from .page_views import CELL, PageViews, view_page
from .registration import FARTHEST, displacement
from .texture import PageTexture
from .warp import PageLookup, Photo, photo_positions, rasterize, sample

Cells = NDArray[np.bool_]
Values = NDArray[np.float32]
Window = tuple[slice, slice]

BURNT, UNLIKE = "burnt", "unlike"

# Number of other photos with which the reference is compared at first. Two of five may have blemishes of their
# own; each costs a fortieth of the plain page of 5 megapixels.
_COMPARED = 5
_LEFT_OVER = 0.05  # of the spoilt cells: if more remain unhealed, the other photos are viewed too
_FEWEST_CELLS = 20  # of a region that justify another photo
_SMALLEST_PART = 0.03  # of a region, likewise
# Largest displacement of print around a piece, in nine tenths of it, pixels of the page. Correctly aligned pieces
# mostly have 0.02 to 0.4, those on a wrong surface 1.2 to 5; pieces above the limit are not healed.
_MISALIGNED = 1.0
# Least correlation of that print: print displaced too far to be measured looks different. Eight pieces of seven scenes
# have 0.88 to 0.99.
_LIKE = 0.7
_FEATHER = 1.0  # cells, standard deviation
_LIGHT_SCALE = 4.0  # cells: the light of photos does not differ at finer scales
_AROUND = 14  # cells around a region in which print and light are compared: 2.6 windows of `registration`
_SPECKLES = 5  # cells: displaced print gives smaller regions
_DARK = np.log(0.2)  # brightness below which a difference says little about the light
_MOST_GAIN = 0.7  # logarithm, a factor of 2: a bound against runaways, not measured
_CUT_AT = 16  # photo pixels: cuts are at multiples of this, because the photo is halved


@dataclass(frozen=True)
class Blemish:
    """One kind of blemish of the reference's page.

    Attributes
    ----------
    kind : str
        One of `blemishes.KINDS`; or `BURNT`: burnt out in every photo that shows it; or `UNLIKE`: different in other
        photos, whose print is not aligned with the reference's there, so the surface may be wrong.
    share : float
        Of the page.
    healed_share : float
        Of the page, replaced from ``photos``; the rest stays as in the reference.
    photos : tuple of int
        The one that replaces most comes first.
    """

    kind: str
    share: float
    healed_share: float = 0.0
    photos: tuple[int, ...] = ()


@dataclass(frozen=True)
class _Patch:
    """The part taken from one photo, on a window of the cells (h, w)."""

    photo: int
    window: Window
    weight: Values
    gain: Values
    shift: Values


def heal_page(
    texture: PageTexture,
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    watch: Watch = SILENT,
) -> tuple[PageTexture, tuple[Blemish, ...]]:
    """Replace the parts of the reference's page spoilt by glare, blur and passing shadows.

    Parameters
    ----------
    texture : PageTexture
        The page from the reference photo alone; stays as it is.
    sheet, flat, cameras, read_photo, reference
        As for `render.render_page`.

    Returns
    -------
    PageTexture
        Pixels outside the healed regions are those of ``texture``; it is ``texture`` itself if nothing is healed.
    tuple of Blemish
        The kinds that were found.

    Raises
    ------
    Cancelled
    """
    order = _by_size(sheet, cameras, reference)
    ordered = [cameras[index] for index in order]

    def read(index: int) -> Photo:
        return read_photo(order[index])

    views = view_page(sheet, flat, ordered[: 1 + _COMPARED], read, watch.part(0, 0.4))
    blemishes = find_blemishes(views, 0)
    source = choose_sources(blemishes)
    left_over = (source[blemishes.spoilt] < 0).sum() > _LEFT_OVER * blemishes.spoilt.sum()
    if left_over and len(ordered) > 1 + _COMPARED:
        views = view_page(sheet, flat, ordered, read, watch.part(0.4, 0.6), views)
        blemishes = find_blemishes(views, 0)
        source = choose_sources(blemishes)
    step = watch.part(0.6, 0.8)
    patches, misaligned = _patches(source, views, blemishes, max(texture.photo.shape), step)
    found = [_blemish(kind, found & ~misaligned, source, views.page, order) for kind, found in blemishes.found.items()]
    for kind, cells in ((BURNT, blemishes.burnt), (UNLIKE, misaligned)):
        found.append(_blemish(kind, cells, source, views.page, order))
    if patches:
        patches = [replace(patch, photo=order[patch.photo]) for patch in patches]
        step = watch.part(0.8, 1)
        texture = _lay_over(texture, sheet, flat, cameras, read_photo, patches, views.page.shape, step)
    return texture, tuple(blemish for blemish in found if blemish.share > 0)


def _by_size(sheet: Sheet, cameras: Sequence[Camera], reference: int) -> list[int]:
    """Photos sorted by how much of the sheet they show and how large, after the reference."""
    middle = sheet.vertices.mean(axis=0)
    size = []
    for camera in cameras:
        pixels = camera.project(sheet.vertices)
        with np.errstate(invalid="ignore"):
            inside = ((pixels >= 0) & (pixels <= [camera.width, camera.height])).all(axis=1)
        size.append(inside.mean() ** 2 * camera.focal_length / np.linalg.norm(camera.center - middle))
    return [reference, *(int(k) for k in np.argsort(-np.array(size), kind="stable") if k != reference)]


def choose_sources(blemishes: Blemishes) -> NDArray[np.int64]:
    """The source photo of each spoilt cell, with as few photos per region as possible; -1 for none.

    Parameters
    ----------
    blemishes : Blemishes

    Returns
    -------
    (h, w) int array
    """
    source = np.full(blemishes.spoilt.shape, -1, np.int64)
    region, count = ndimage.label(blemishes.spoilt)
    value = blemishes.better * np.clip(blemishes.sharpness, 0, 1)
    for number, window in enumerate(ndimage.find_objects(region, count), 1):
        left = region[window] == number
        fewest = max(_FEWEST_CELLS, _SMALLEST_PART * left.sum())
        for _ in range(len(value)):
            best = int((value[:, *window] * left).sum(axis=(1, 2)).argmax())
            taken = left & blemishes.better[best][window]
            if taken.sum() < fewest:
                break
            source[window][taken] = best
            left &= ~taken
    return source


def _patches(
    source: NDArray[np.int64], views: PageViews, blemishes: Blemishes, longest: int, watch: Watch
) -> tuple[list[_Patch], Cells]:
    """Align each piece of another photo with the reference's print, and match it to its light.

    Returns
    -------
    list of _Patch
    (h, w) bool array
        Pieces that are not aligned with the reference's print; they are removed from ``source``.
    """
    laid, misaligned = [], np.zeros(source.shape, bool)
    blind = blemishes.found["glare"] | blemishes.found["shadow"]
    # Blurred print would match sharp print anywhere, and at the very edge the desk would match the desk. Within a piece
    # its photo knows the place of the print as well as the reference does; they only have to match around it.
    shows = ndimage.binary_erosion(views.page, iterations=2) & views.visible[0] & ~blemishes.spoilt
    photos = np.unique(source[source >= 0])
    for done, index in enumerate(photos):
        watch.step(done / len(photos), "Aligning the photos")
        region, count = ndimage.label(source == index, np.ones((3, 3)))
        for number, own in enumerate(ndimage.find_objects(region, count), 1):
            piece = region == number
            window = _widened(own, source.shape)
            shift, off = _displacement(views, index, shows & views.visible[index], blemishes.printed, piece, window)
            if off * longest / max(views.picture.shape[1:]) > _MISALIGNED:
                source[piece] = -1
                misaligned |= piece
            else:
                # The weight is one half at the piece's edge, which is outside the blemish by the fringe.
                weight = ndimage.gaussian_filter(piece[window].astype(np.float32), _FEATHER)
                weight *= views.visible[index][window]
                laid.append(_Patch(int(index), window, weight, _gain(views, blind, blemishes, index, window), shift))
    total = np.ones(source.shape, np.float32)
    together = np.zeros_like(total)
    for patch in laid:
        together[patch.window] += patch.weight
    np.maximum(total, together, out=total)
    return [replace(patch, weight=patch.weight / total[patch.window]) for patch in laid], misaligned


def _widened(window: tuple[slice, ...], shape: tuple[int, ...]) -> Window:
    rows, columns = (
        slice(max(part.start - _AROUND, 0), min(part.stop + _AROUND, length))
        for part, length in zip(window, shape, strict=True)
    )
    return rows, columns


def _displacement(
    views: PageViews, index: int, shows: Cells, printed: Cells, piece: Cells, window: Window
) -> tuple[Values, float]:
    """The displacement of a photo's print from the reference's in cells (h, w, 2), and the remaining one in pixels."""
    fine = (slice(window[0].start * CELL, window[0].stop * CELL), slice(window[1].start * CELL, window[1].stop * CELL))
    fixed, moving = views.picture[0][fine], views.picture[index][fine]
    known = np.repeat(np.repeat(shows[window], CELL, axis=0), CELL, axis=1)
    limit = FARTHEST * max(views.picture.shape[1:])
    moved = displacement(fixed, moving, known, limit)
    rows, columns = np.indices(fixed.shape, dtype=np.float32)
    laid = ndimage.map_coordinates(moving, [rows + moved[..., 1], columns + moved[..., 0]], order=1, mode="nearest")
    rest = np.hypot(*np.moveaxis(displacement(fixed, laid, known, np.inf, rounds=1), -1, 0))
    near = ndimage.binary_dilation(piece[window], iterations=_SPECKLES) & shows[window] & printed[window]
    at_cells = np.s_[CELL // 2 :: CELL, CELL // 2 :: CELL]
    off = float(np.percentile(rest[at_cells][near], 90)) if near.any() else 0.0
    there = known & np.repeat(np.repeat(near, CELL, axis=0), CELL, axis=1)
    if near.any() and _print_correlation(fixed, laid, there) < _LIKE:
        off = np.inf
    return membrane(moved[at_cells] / CELL, shows[window]), off


def _print_correlation(one: Values, other: Values, where: Cells) -> float:
    """Correlation of two pictures' print, -1 to 1."""
    first, second = (part - ndimage.gaussian_filter(part, 2 * CELL) for part in (one, other))
    return float(np.corrcoef(first[where], second[where])[0, 1])


def _blemish(kind: str, cells: Cells, source: NDArray[np.int64], page: Cells, photo_of: Sequence[int]) -> Blemish:
    photos, healed = np.unique(source[cells & (source >= 0)], return_counts=True)
    order = np.argsort(-healed, kind="stable")
    total = float(page.sum())
    return Blemish(kind, cells.sum() / total, healed.sum() / total, tuple(photo_of[k] for k in photos[order]))


def _gain(views: PageViews, blind: Cells, blemishes: Blemishes, index: int, window: Window) -> Values:
    """The factor on a photo's brightness (h, w, 3), in a window of the cells, that matches it to the reference's light.

    The light is compared where the reference is neither glaring nor shaded, and interpolated as a membrane elsewhere: a
    healed region has no step at its edges.
    """
    dark = views.color[0].mean(axis=-1) < _DARK
    known = ndimage.binary_erosion(views.page, iterations=3) & ~dark & views.visible[0]
    known &= ~ndimage.binary_dilation(blind, iterations=2)
    compared = (known & blemishes.better[index])[window]
    if not compared.any():
        return np.ones((*compared.shape, 3), np.float32)
    difference = (views.color[0] - views.color[index])[window]
    difference = ndimage.median_filter(difference, (_SPECKLES, _SPECKLES, 1))
    light = smooth_known(difference, compared, _LIGHT_SCALE)
    gain = membrane(light, ndimage.binary_dilation(compared, iterations=2))
    return np.exp(np.clip(gain, -_MOST_GAIN, _MOST_GAIN))


def _lay_over(
    texture: PageTexture,
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    patches: list[_Patch],
    cells: tuple[int, ...],
    watch: Watch,
) -> PageTexture:
    """The page blended with each patch by its weight, in the reference's light and aligned with its print."""
    shape = texture.photo.shape
    image, photo_index, position = texture.image.copy(), texture.photo.copy(), texture.position.copy()
    white = np.iinfo(image.dtype).max
    corners = flat.uv * [shape[1] / flat.width, shape[0] / flat.height]
    per_cell = shape[0] / cells[0], shape[1] / cells[1]
    added = np.zeros((*shape, 3), np.float32)
    total = np.zeros(shape, np.float32)
    most = np.full(shape, 0.5, np.float32)
    photos = sorted({patch.photo for patch in patches})
    for done, index in enumerate(photos):
        watch.step(done / len(photos), "Healing the page from other photos")
        photo = read_photo(index)
        for patch in (each for each in patches if each.photo == index):
            rows, columns = _pixels(patch, per_cell)
            size = (columns.stop - columns.start, rows.stop - rows.start)
            lookup = rasterize(corners - [columns.start, rows.start], sheet.triangles, size)
            at = [
                (np.arange(part.start, part.stop) + 0.5) / step - 0.5 - own.start
                for part, step, own in zip((rows, columns), per_cell, patch.window, strict=True)
            ]
            share = between_cells(patch.weight, *at)
            # Two more pixels on each side, because the slopes of the positions come from neighbours.
            used = ndimage.binary_dilation(share > LEAST_WEIGHT, iterations=2)
            needed = PageLookup(np.where(used, lookup.triangle, np.int32(-1)), lookup.barycentric)
            moved = between_cells(patch.shift, *at) * np.array(per_cell[::-1], np.float32)
            there = moved_by(photo_positions(sheet, needed, cameras[index]), moved)
            here = (share > LEAST_WEIGHT) & np.isfinite(there[..., 0]) & (texture.photo[rows, columns] >= 0)
            there[~here] = np.nan
            pixels = _sample(photo, there)[here] * np.float32(white / np.iinfo(photo.dtype).max)
            light = between_cells(patch.gain, *at)[here]
            added[rows, columns][here] += share[here, None] * np.minimum(pixels * light, white)
            total[rows, columns][here] += share[here]
            better = here & (share >= most[rows, columns])
            most[rows, columns][better] = share[better]
            photo_index[rows, columns][better] = index
            position[rows, columns][better] = there[better]
    changed = total > 0
    mixed = image[changed] * (1 - total[changed, None]) + added[changed]
    image[changed] = np.rint(np.clip(mixed, 0, white)).astype(image.dtype)
    return replace(texture, image=image, photo=photo_index, position=position)


def _pixels(patch: _Patch, per_cell: tuple[float, float]) -> Window:
    """Rows and columns of the page that a patch covers."""
    used = np.argwhere(ndimage.binary_dilation(patch.weight > LEAST_WEIGHT, iterations=2))
    low, high = used.min(axis=0), used.max(axis=0) + 1
    rows, columns = (
        slice(int((part.start + a) * step), int(np.ceil((part.start + b) * step)))
        for part, a, b, step in zip(patch.window, low, high, per_cell, strict=True)
    )
    return rows, columns


def _sample(photo: Photo, position: NDArray[np.float32]) -> Photo:
    """`warp.sample` of only the visible part of the photo, which saves reducing the rest."""
    if not np.isfinite(position).any():
        return sample(photo, position)
    low = np.maximum(np.nanmin(position, axis=(0, 1)).astype(int) // _CUT_AT - 1, 0) * _CUT_AT
    high = np.nanmax(position, axis=(0, 1)).astype(int) + 2 * _CUT_AT
    return sample(photo[low[1] : high[1], low[0] : high[0]], position - low.astype(np.float32))
