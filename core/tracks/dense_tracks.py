"""Places of the print, each found in several photos to a few hundredths of a pixel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import sample_bilinear, shrink
from ..numeric.threads import in_threads
from ..page.page_cells import ReadPhoto, enlarge
from ..page.photo_colors import Photo
from ..page.warp import native_size
from ..sheet import FlatMap, Sheet
from ..sparse_model import FEWEST_VIEWS
from ..watch import SILENT, Watch
from .alignment import FARTHEST, Fit, Template, align_prints, shifted
from .page_print import CELL, PagePrint, Picture, page_print, print_cells

# The page's longer side has the reference photo's own pixels, but at most this many. With 1600 instead of 2200 a
# rendered form is off by .0117 instead of .0107 %, set IV by .83 instead of .75 px, in 0.6 of the time.
_LONGEST_SIDE = 2200
# Rounds of alignment to the mean of all photos; one more follows for places that are kept. A choice.
_ROUNDS_MEAN = 1
_CUT_OFF = 0.95  # of the farthest shift: one of this length was cut off there
_LEAST_TRUST = 0.02  # of a photo in the mean: where the template shows nothing, it is all that counts
_LEAST_WEIGHT = 1e-4  # of all photos together in a cell of the mean: with less there is nothing to follow
# An observation is kept with at least this correlation and share of the window, and at most this expected deviation and
# last step, page pixels: those of the prototype that brought the points of two rendered sheets from .0315 and .0192 to
# .0020 and .0032 % of the page's height off the true surface (median). Never varied.
_CORRELATION, _SHARE, _DEVIATION, _REST = 0.75, 0.85, 0.15, 0.25
# Cells between two places, how far a place may lie from its cell's centre, and the window in which the middle of the
# print is taken, standard deviation: all in cells. Every second cell is ten page pixels, as in that prototype.
_SPACING, _OFF_CENTER, _AROUND = 2, 1.5, 1.0


def dense_tracks(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    least_side: int,
    threads: int = 1,
    watch: Watch = SILENT,
) -> Array:
    """Lay the page of every photo on the others' and follow its print from photo to photo.

    The sheet and its flat map need to be right to a hundredth of the page. All photos are laid on the reference photo,
    and then on the mean of all, which is sharper and shows what the reference photo does not.

    Parameters
    ----------
    sheet : Sheet
    flat : FlatMap
    cameras : sequence of Camera
    read_photo : callable
        Gives the pixels of the photo with an index.
    reference : int
    least_side : int
        Pixels of the page's longer side, at least.
    threads : int
        How many photos are looked at at once.
    watch : Watch

    Returns
    -------
    (N, C, 2) array
        Where each of N places of the page lies in each of C photos, distorted pixels; NaN where a photo does not show
        it clearly.

    Raises
    ------
    Cancelled
    """
    cells = print_cells(sheet, flat, native_size(sheet, flat, cameras[reference]), (least_side, _LONGEST_SIDE))

    def look(item: tuple[Camera, Photo]) -> PagePrint:
        return page_print(sheet, cells, *item)

    photos = ((camera, read_photo(index)) for index, camera in enumerate(cameras))
    prints: list[PagePrint] = []
    for print_ in in_threads(look, photos, threads):
        prints.append(print_)
        watch.step(0.3 * len(prints) / len(cameras), "Looking at the print in all photos")
    shifts = align_prints(prints, reference, threads, watch.part(0.3, 0.6))
    watch.step(0.6, "Laying the photos on their mean")
    mean = _mean(prints, shifts, Template(prints[reference].picture, prints[reference].known), threads)
    limit = FARTHEST * CELL * max(cells.triangle.shape)
    places, at = _places(mean)

    def follow(item: tuple[PagePrint, Picture]) -> Array:
        return _followed(mean, *item, places, at, limit)

    observed = np.full((len(places), len(prints), 2), np.nan)
    for index, found in enumerate(in_threads(follow, zip(prints, shifts, strict=True), threads)):
        observed[:, index] = found
        watch.step(0.7 + 0.3 * (index + 1) / len(cameras), "Following the print through all photos")
    return observed[np.isfinite(observed[..., 0]).sum(axis=1) >= FEWEST_VIEWS]


def _followed(
    mean: Template, print_: PagePrint, shift: Picture, places: Array, at: tuple[NDArray[np.int64], ...], limit: float
) -> Array:
    """Where places (N, 2) of the mean print, in cells ``at``, lie in a photo (N, 2); NaN where that is not clear."""
    observed = np.full((len(places), 2), np.nan)
    if not print_.known.any():
        return observed
    shift = mean.align(print_.filtered, print_.known, shift, limit, _ROUNDS_MEAN, order=3)
    fit = mean.fit(shifted(print_.filtered, shift, 3), print_.known)
    moved = sample_bilinear(shift, places / CELL) + fit.step[at]
    good = _clear(fit, print_.known & mean.known)[at] & (np.linalg.norm(moved, axis=1) < _CUT_OFF * limit)
    observed[good] = print_.photo_pixels(places[good] + moved[good])
    return observed


def _mean(prints: Sequence[PagePrint], shifts: Sequence[Picture], fixed: Template, threads: int) -> Template:
    """The mean print of all photos, which count by how well they lie on the template."""
    shape = fixed.picture.shape

    def weighed(item: tuple[PagePrint, Picture]) -> tuple[Picture, Picture]:
        print_, shift = item
        moved = shifted(print_.filtered, shift, 3)
        fit = fixed.fit(moved, print_.known)
        trust = np.maximum(np.where(fixed.known, fit.trust, 0), _LEAST_TRUST) ** 2 * print_.known
        weight = enlarge(trust.astype(np.float32), shape)
        return weight * moved, weight

    total, weights = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    shown = [item for item in zip(prints, shifts, strict=True) if item[0].known.any()]
    for part, weight in in_threads(weighed, shown, threads):
        total += part
        weights += weight
    known = shrink(weights, CELL) > _LEAST_WEIGHT
    return Template(total / np.maximum(weights, np.float32(_LEAST_WEIGHT)), known)


def _places(template: Template) -> tuple[Array, tuple[NDArray[np.int64], ...]]:
    """Page pixels (N, 2) in the middle of the print of every few cells, and those cells."""
    energy = template.across**2 + template.down**2
    row, column = (np.arange(length).astype(np.float32) + np.float32(0.5) for length in energy.shape)
    total = _around(energy) + 1e-12
    center = np.stack([_around(energy * column) / total, _around(energy * row[:, None]) / total], axis=-1)
    cells = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in total.shape[::-1])), axis=-1) * CELL
    usable = template.known & (np.abs(center - cells).max(axis=-1) < _OFF_CENTER * CELL)
    chosen = np.zeros_like(usable)
    chosen[_SPACING // 2 :: _SPACING, _SPACING // 2 :: _SPACING] = True
    at = np.nonzero(usable & chosen)
    return center[at].astype(float), at


def _around(pixels: Picture) -> Picture:
    return np.asarray(ndimage.gaussian_filter(shrink(pixels, CELL), _AROUND))


def _clear(fit: Fit, known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return np.asarray(
        known
        & (fit.correlation > _CORRELATION)
        & (fit.share > _SHARE)
        & (fit.deviation < _DEVIATION)
        & (np.linalg.norm(fit.step, axis=-1) < _REST)
    )
