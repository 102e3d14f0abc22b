"""Black and white from grey: which pixels are ink, by the paper and the strokes around each.

A level for the whole page loses what is fainter than half of the darkest ink: hairlines, which blur makes grey, and
grey print. So strokes are compared with what is around them. Their blur is undone first, as far as noise allows; each
stroke then ends at half of its own darkness; and what does not stand out from the noise of the paper nearby is paper.
Areas wider than a stroke are ink if they are darker than half of black ink.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..numeric.image import Image, linear_light
from ..page.page_cells import enlarge_rows

# The light of the paper: this quantile in each of this many cells along the page's longer side, of this many pixels or
# a multiple; the largest of the square of cells around, made smooth; nowhere below this share of the page's brightest
# paper, so dark areas stay dark.
_PAPER_QUANTILE, _PAPER_CELLS, _PAPER_CELL, _PAPER_AROUND, _PAPER_SMOOTH = 0.85, 60, 16, 5, 1.5
_DARKEST_PAPER = 0.4
_BRIGHTEST, _LEAST_LIGHT = 0.95, 1e-3  # quantile that is the brightest paper, and linear light that paper has at least
# The figures below are tuned on drawn pages (Didot, Latin Modern and others from 6.5 to 11 pt at 100 to 300 dpi, black
# to light grey, hairlines of .05 to .2 mm), with blur and noise: the fewest lost strokes, wrong pixels and specks; the
# least contrasts are higher than these pages need, because paper, folds and dirt of real photos have some.
# Density is the share of the paper's light that is missing; black ink has 0.95.
# Scale of the curvature that undoes blur (pixels), and how much of it: to find strokes, and to find where they end.
_CLEAR, _SHARP = (0.85, 1.0), (1.0, 1.5)
_SECOND = ((2, 0), (1, 1), (0, 2))  # derivatives down and across the page
_OTHER_WAY = 0.2  # weight of the curvature along a stroke
_SOLID = 0.5  # density from which on any area is ink, but for the narrow spaces between strokes
_SURELY_SOLID = 0.7  # density from which on there is no such space
_WIDEST_STROKE, _FEWEST = 0.01, 7  # share of the page's longer side, and pixels at least: 3 mm on A4
_SMOOTH = 0.6  # pixels: against noise, before what is wider than a stroke is found
_MOST_GAIN = 3.0  # of contrast, by undoing blur: beside the edge of an area it would make a stroke of nothing
_HALF, _REACH = 0.5, 2  # a stroke ends at this share of the darkest within this many pixels, but
_MOST_HALF = 0.4  # at no more than this density
_FAINTEST = 0.1  # density of the faintest stroke, without any noise
_NOISE_CELL, _NOISE_AROUND, _NOISE_RANK = 32, 5, 25  # pixels; cells around; percentile of these that have no print
# Quantiles of a cell's contrast from which its noise is estimated, and how many standard deviations of a normal
# distribution lie between them; the lower half is cut off where the paper is white.
_MIDDLE, _UPPER, _BETWEEN = 0.5, 0.8, 0.84
_ABOVE_NOISE = 2.5  # standard deviations of noise, above which a pixel may be a stroke's
_MOST_NOISE = 0.25  # density: where there is more in all cells around, it is print
_EVIDENCE = 9.0  # sum over a stroke's pixels of their density by the least that may be a stroke's; specks have less
_DARKEST_PIXEL = 0.12  # density that a stroke reaches somewhere; folds of set IV leave 0.06 to 0.15, beside print
_ROWS = 1024  # of the page image at once


def find_ink(grey: Image) -> NDArray[np.bool_]:
    """Which pixels (H, W) of a page are ink.

    Parameters
    ----------
    grey : (H, W) uint8 or uint16 array
        The page with the tone curve of sRGB, in any light that changes slowly.
    """
    height, width = grey.shape
    paper, per_cell = _paper_light(grey)
    contrast = np.empty(grey.shape, np.float32)
    ink, inside, dark = (np.empty(grey.shape, bool) for _ in range(3))
    wide = max(_FEWEST, round(_WIDEST_STROKE * max(grey.shape))) | 1
    for rows, around, inner in _bands(height, 2 * wide):
        density = 1 - linear_light(grey[around])[..., 0] / enlarge_rows(paper, per_cell, around, width)
        smooth = ndimage.gaussian_filter(density, _SMOOTH, mode="nearest")
        areas = ndimage.grey_opening(smooth, (wide, wide), mode="nearest")
        clear, sharp = (density + share * _ridge(density, sigma) for sigma, share in (_CLEAR, _SHARP))
        beyond = np.minimum(clear - areas, _MOST_GAIN * (smooth - areas))
        darkest = ndimage.maximum_filter(clear - areas, 2 * _REACH + 1, mode="nearest")
        contrast[rows] = beyond[inner]
        dark[rows] = (smooth - areas > _DARKEST_PIXEL)[inner]
        inside[rows] = (sharp - areas > np.minimum(_HALF * darkest, _MOST_HALF))[inner]
        ink[rows] = ((np.minimum(clear, sharp) > _SOLID) | (density > _SURELY_SOLID))[inner]
    return ink | _strokes(contrast, inside, dark)


def _ridge(density: NDArray[np.float32], sigma: float) -> NDArray[np.float32]:
    """How much the density curves down across a stroke, at a scale in pixels.

    The Laplacian adds up the curvature of both directions. A thin join between bold strokes is dark across itself, but
    light from stroke to stroke, and would vanish: the second direction counts less.
    """
    down, mixed, across = (ndimage.gaussian_filter(density, sigma, order, mode="nearest") for order in _SECOND)
    middle, apart = (down + across) / 2, np.hypot((down - across) / 2, mixed)
    return (apart - middle) - _OTHER_WAY * (apart + middle)


def _strokes(contrast: NDArray[np.float32], inside: NDArray[np.bool_], dark: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """What stands out from the noise, without specks, traces of folds, and dark edges of the page.

    Parameters
    ----------
    contrast : (H, W) array
        Density beyond that of areas wider than a stroke; changed.
    inside : (H, W) bool array
        Where a stroke would not end.
    dark : (H, W) bool array
        What each stroke has somewhere.
    """
    least = _least_contrast(contrast)
    height, width = contrast.shape
    for rows, _, _ in _bands(height, 0):
        contrast[rows] /= enlarge_rows(least, _NOISE_CELL, rows, width)
    candidates = inside & (contrast > 1)
    part, count = ndimage.label(candidates, np.ones((3, 3)))
    enough = np.bincount(part[candidates], contrast[candidates], minlength=count + 1) > _EVIDENCE
    reaches = np.zeros(count + 1, bool)
    reaches[part[dark & candidates]] = True
    for edge in (part[0], part[-1], part[:, 0], part[:, -1]):
        reaches[edge] = False
    return np.asarray((enough & reaches)[part])


def _paper_light(grey: Image) -> tuple[NDArray[np.float32], int]:
    """Linear light of the paper in each cell of the page, and pixels along a cell's side."""
    step = max(1, max(grey.shape) // (_PAPER_CELLS * _PAPER_CELL))  # fewer pixels serve
    level = np.quantile(_cells(grey[::step, ::step], _PAPER_CELL), _PAPER_QUANTILE, axis=-1)
    light = linear_light(level.round().astype(grey.dtype))[..., 0]
    light = ndimage.maximum_filter(light, _PAPER_AROUND, mode="nearest")
    light = ndimage.gaussian_filter(light, _PAPER_SMOOTH, mode="nearest")
    darkest = max(_DARKEST_PAPER * float(np.quantile(light, _BRIGHTEST)), _LEAST_LIGHT)
    return np.maximum(light, np.float32(darkest)), _PAPER_CELL * step


def _least_contrast(contrast: NDArray[np.float32]) -> NDArray[np.float32]:
    """The contrast of the faintest stroke in each cell of the page, from the noise of the paper nearby."""
    middle, upper = np.quantile(_cells(contrast[::2, ::2], _NOISE_CELL // 2), [_MIDDLE, _UPPER], axis=-1)
    noise = (upper - middle) / _BETWEEN
    quiet = (ndimage.percentile_filter(each, _NOISE_RANK, _NOISE_AROUND, mode="nearest") for each in (middle, noise))
    level, noise = quiet
    return np.clip(level + _ABOVE_NOISE * noise, _FAINTEST, _MOST_NOISE).astype(np.float32)


def _cells(values: NDArray[Any], side: int) -> NDArray[Any]:
    """Values (H, W) as cells (h, w, side * side), the last ones filled up by reflection."""
    values = np.pad(values, [(0, -length % side) for length in values.shape], mode="symmetric")
    rows, columns = (length // side for length in values.shape)
    return values.reshape(rows, side, columns, side).swapaxes(1, 2).reshape(rows, columns, side * side)


def _bands(height: int, beyond: int) -> list[tuple[slice, slice, slice]]:
    """Bands of a page's rows: their rows, these and some beyond, and which of the latter the rows are."""
    bands = []
    for top in range(0, height, _ROWS):
        bottom, first = min(top + _ROWS, height), max(top - beyond, 0)
        around = slice(first, min(bottom + beyond, height))
        bands.append((slice(top, bottom), around, slice(top - first, bottom - first)))
    return bands
