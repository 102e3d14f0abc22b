"""Places of the print, each found in several photos to a few hundredths of a pixel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import sample_bilinear, shrink, whole_blocks
from ..page.page_cells import ReadPhoto, enlarge
from ..page.warp import native_size, page_lookup
from ..sheet import FlatMap, Sheet
from ..sparse_model import FEWEST_VIEWS
from ..watch import SILENT, Watch
from .alignment import Fit, Template, shifted
from .page_print import CELL, PagePrint, Picture, page_print

# Pixels of the page's longer side: the reference photo's own, within these limits. With 1600 instead of 2200 a rendered
# form is off by .0117 instead of .0107 %, set IV by .83 instead of .75 px, in 0.6 of the time.
_SIDE = (1000, 2200)
# Rounds of alignment to the reference photo, at half size, and to the mean of all photos.
_ROUNDS_HALF, _ROUNDS_MEAN = 5, 2
# The farthest shift to believe, as a part of the page's longer side: half the distance of two lines of text. A shift of
# this part of it was cut off there.
_FARTHEST, _CUT_OFF = 0.012, 0.95
# A photo counts in the mean from the one correlation on, and fully from the other on; never quite nothing.
_POOR, _GOOD, _LEAST_TRUST = 0.6, 0.9, 0.02
_LEAST_WEIGHT = 1e-4
# An observation is kept with at least this correlation and share of the window, and at most this expected deviation and
# step of one more round, page pixels. Chosen, not tuned.
_CORRELATION, _SHARE, _DEVIATION, _REST = 0.75, 0.85, 0.15, 0.25
# Cells between two places, how far a place may lie from its cell's centre, and the window in which the middle of the
# print is taken, standard deviation: all in cells.
_SPACING, _OFF_CENTER, _AROUND = 2, 1.5, 1.0


def dense_tracks(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
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
    native = native_size(sheet, flat, cameras[reference]) * max(flat.width, flat.height)
    per_unit = float(np.clip(native, *_SIDE)) / max(flat.width, flat.height)
    columns, rows = (2 * max(round(side * per_unit / (2 * CELL)), 1) for side in (flat.width, flat.height))
    cells = page_lookup(sheet, flat, (columns, rows))
    prints = []
    for index, camera in enumerate(cameras):
        watch.step(0.3 * index / len(cameras), "Looking at the print in all photos")
        prints.append(page_print(sheet, cells, camera, read_photo(index)))
    shifts = _aligned(prints, reference, watch.part(0.3, 1))
    mean = _mean(prints, shifts, Template(prints[reference].picture, prints[reference].known))
    limit = _FARTHEST * CELL * max(rows, columns)
    places, at = _places(mean)
    observed = np.full((len(places), len(prints), 2), np.nan)
    for index, print_ in enumerate(prints):
        if not print_.known.any():
            continue
        filtered = ndimage.spline_filter(print_.picture)
        shift = mean.align(filtered, print_.known, shifts[index], limit, _ROUNDS_MEAN, order=3)
        fit = mean.fit(shifted(filtered, shift, 3), print_.known)
        moved = sample_bilinear(shift, places / CELL)
        good = _clear(fit, print_.known & mean.known)[at] & (np.linalg.norm(moved, axis=1) < _CUT_OFF * limit)
        observed[good, index] = print_.photo_pixels(places[good] + moved[good])
    return observed[np.isfinite(observed[..., 0]).sum(axis=1) >= FEWEST_VIEWS]


def _aligned(prints: Sequence[PagePrint], reference: int, watch: Watch) -> list[Picture]:
    """Shifts (h, w, 2) of all photos onto the reference photo, to half a pixel."""
    fixed = Template(*_half(prints[reference]))
    limit = _FARTHEST * max(fixed.picture.shape)
    shifts = []
    for index, print_ in enumerate(prints):
        watch.step(index / len(prints), "Laying the photos on each other")
        shift = np.zeros((*print_.known.shape, 2), np.float32)
        if index != reference and print_.known.any():
            moving, known = _half(print_)
            coarse = fixed.align(moving, known, np.zeros((*known.shape, 2), np.float32), limit, _ROUNDS_HALF, order=1)
            shift = 2 * enlarge(coarse, print_.known.shape)
        shifts.append(shift)
    return shifts


def _half(print_: PagePrint) -> tuple[Picture, NDArray[np.bool_]]:
    """The print at half size, and its cells."""
    return shrink(print_.picture, 2), whole_blocks(print_.known, 2)


def _mean(prints: Sequence[PagePrint], shifts: Sequence[Picture], fixed: Template) -> Template:
    """The mean print of all photos, which count by how well they lie on the template."""
    shape = fixed.picture.shape
    total, weights = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    for print_, shift in zip(prints, shifts, strict=True):
        if not print_.known.any():
            continue
        moved = shifted(ndimage.spline_filter(print_.picture), shift, 3)
        fit = fixed.fit(moved, print_.known)
        # where the template shows nothing, the photo is taken at its word
        correlation = np.where(fixed.known, fit.correlation, _POOR)
        trust = np.clip((correlation - _POOR) / (_GOOD - _POOR), _LEAST_TRUST, 1) ** 2 * print_.known
        weight = enlarge(trust.astype(np.float32), shape)
        total += weight * moved
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
        & (fit.rest < _REST)
    )
