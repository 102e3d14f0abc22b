"""The light within a few pixels of a crease, where paper bends in a curve and the model has an edge."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array, Indices
from ..numeric.image import Image, linear_light
from ..sheet import FlatMap, Sheet
from .blank_paper import LIT

Values = NDArray[np.float32]

# Values without a figure are choices; no measurement of them is recorded.
# Page's longer side: letter paper folded by hand bends within 0.005 of it on either side of the crease.
_REACH = 0.01
_FADED = 0.3  # of the reach, at its end, over which the correction fades out
_ALONG = 0.003  # page's longer side: length of a bin along the crease
_SMOOTH = (0.2, 0.03)  # page's longer side, standard deviations along the crease, from coarse to fine
_ACROSS = 0.0006  # page's longer side, standard deviation across it, where a printed rule may hide the paper
# Logarithm of light. Bins are even if their neighbours along the crease differ by less than the first; they are paper
# if they differ by less than the second from the brightest of their distance from the crease. At the end of the reach,
# where the model is right, a side that differs from it by more than the second is not paper.
_EVEN, _SAME = 0.06, 0.05
# A correction that would be darker is a printed line along the crease; brighter than the model, there is only paper.
_DARKEST = 0.2
_FEWEST = 0.08  # share of the bins at one distance that must be paper
_FEW = 0.02  # of the surroundings: what fewer bins say fades
_ROWS = 256  # of the page image at once
_SAMPLING = 0.7  # pixels between the places that find the pixels of a band; more would miss some


@dataclass(frozen=True)
class CreaseLight:
    """The light beside creases, as a multiple of the model's.

    Attributes
    ----------
    pixels : (N,) int array
        Numbers of the page image's pixels, row by row, increasing.
    factor : (N, 3) float32 array
        Linear light there, divided by the model's.
    """

    pixels: Indices
    factor: Values

    def correct(self, light: Values, first_row: int) -> None:
        """Correct, in place, the model's linear light (rows, W, 3) on the page image's rows from ``first_row`` on."""
        rows, width, _ = light.shape
        start, stop = np.searchsorted(self.pixels, [first_row * width, (first_row + rows) * width])
        light.reshape(-1, 3)[self.pixels[start:stop] - first_row * width] *= self.factor[start:stop]


def light_beside_creases(
    image: Image, sheet: Sheet, flat: FlatMap, light_on_rows: Callable[[slice], Values]
) -> CreaseLight:
    """Find the light beside each crease from the blank paper along it.

    Light changes slowly along a crease, however fast it changes across. So blank paper anywhere along the crease shows
    how bright it is under print at the same distance.

    Parameters
    ----------
    image : (H, W, 3) uint8 or uint16 array
        The page in sRGB.
    sheet : Sheet
    flat : FlatMap
    light_on_rows : callable
        Takes a slice of rows; returns the model's linear light of blank paper there (rows, W, 3), NaN off the sheet.
    """
    height, width = image.shape[:2]
    longer = max(height, width)
    scale = np.array([width / flat.width, height / flat.height])
    bands = [_band(flat.uv[ridge] * scale, _REACH * longer, (height, width)) for ridge in sheet.ridges]
    bands = [band for band in bands if len(band.pixels)]
    if not bands:
        return CreaseLight(np.zeros(0, np.int64), np.zeros((0, 3), np.float32))
    number = np.repeat(np.arange(len(bands)), [len(band.pixels) for band in bands])
    pixels, along, across = (
        np.concatenate(parts) for parts in zip(*((b.pixels, b.along, b.across) for b in bands), strict=True)
    )
    # where bands overlap, the nearest crease counts
    order = np.lexsort((np.abs(across), pixels))
    order = order[np.diff(pixels[order], prepend=-1) > 0]
    pixels, along, across, number = pixels[order], along[order], across[order], number[order]
    rest = _rest(image, pixels, light_on_rows)
    light = np.zeros((len(pixels), 3), np.float32)
    for index in range(len(bands)):
        own = np.flatnonzero((number == index) & np.isfinite(rest[:, 0]))
        if len(own):
            light[own] = _correction(along[own], across[own], rest[own], longer)
    return CreaseLight(pixels, np.exp(light))


@dataclass(frozen=True)
class _Band:
    """The pixels beside a crease: their numbers, and their places along it and across it, pixels."""

    pixels: Indices
    along: Values
    across: Values


def _band(line: Array, reach: float, shape: tuple[int, int]) -> _Band:
    """The pixels of an image of this shape within ``reach`` of a line (K, 2)."""
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    parts = []
    for start, end, length, before in zip(line, line[1:], lengths, starts, strict=False):
        if length == 0:
            continue
        tangent = (end - start) / length
        normal = np.array([-tangent[1], tangent[0]])
        t, d = np.meshgrid(np.arange(0, length + _SAMPLING, _SAMPLING), np.arange(-reach, reach, _SAMPLING))
        places = start + t[..., None] * tangent + d[..., None] * normal
        columns, rows = np.floor(places).astype(int).reshape(-1, 2).T
        inside = (rows >= 0) & (rows < shape[0]) & (columns >= 0) & (columns < shape[1])
        pixels = np.unique(rows[inside] * shape[1] + columns[inside])
        centres = np.stack([pixels % shape[1], pixels // shape[1]], axis=1) + 0.5 - start
        parts.append(np.stack([pixels, before + centres @ tangent, centres @ normal]))
    pixels, along, across = np.concatenate([np.zeros((3, 0)), *parts], axis=1)
    return _Band(pixels.astype(np.int64), along.astype(np.float32), across.astype(np.float32))


def _rest(image: Image, pixels: Indices, light_on_rows: Callable[[slice], Values]) -> Values:
    """Logarithm of the light of the pixels less the model's (N, 3); NaN off the sheet."""
    width = image.shape[1]
    rest = np.empty((len(pixels), 3), np.float32)
    rows = pixels // width
    for first in np.unique(rows // _ROWS) * _ROWS:
        start, stop = np.searchsorted(rows, [first, first + _ROWS])
        block = slice(first, min(first + _ROWS, len(image)))
        place = pixels[start:stop] - first * width
        measured = linear_light(image[block].reshape(-1, 3)[None, place])[0]
        rest[start:stop] = np.log(np.maximum(measured, LIT) / light_on_rows(block).reshape(-1, 3)[place])
    return rest


def _correction(along: Values, across: Values, rest: Values, longer: int) -> Values:
    """What to add to the model's logarithm of light at places beside one crease (N, 3)."""
    reach = _REACH * longer
    step = max(_ALONG * longer, 1.0)
    first = along.min()
    bins = (int((along.max() - first) / step) + 1, 2 * int(np.ceil(reach)))
    i, j = ((along - first) / step).astype(int), np.clip(np.floor(across).astype(int) + bins[1] // 2, 0, bins[1] - 1)
    cell = i * bins[1] + j
    count = np.bincount(cell, minlength=bins[0] * bins[1]).reshape(bins)
    total = [np.bincount(cell, channel, bins[0] * bins[1]).reshape(bins) for channel in rest.T]
    mean = np.stack(total, axis=-1) / np.maximum(count, 1)[..., None]
    paper = _paper(mean.mean(axis=-1), count > 0)
    light = np.zeros(mean.shape)
    for share in _SMOOTH:
        light += _smooth_along(np.where(paper[..., None], mean - light, 0), paper, share * longer / step)
    for side in (slice(0, bins[1] // 2), slice(bins[1] // 2, None)):
        light[:, side] = _smooth_across(light[:, side], paper[:, side].any(axis=0), _ACROSS * longer)
    faded = np.clip((reach - np.abs(across)) / (_FADED * reach), 0, 1)
    return np.asarray(faded[:, None] * light[i, j], np.float32)


def _paper(light: Array, seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which bins (S, D) of what the model leaves of the light are blank paper."""
    most = ndimage.maximum_filter1d(np.where(seen, light, -np.inf), 3, axis=0)
    least = ndimage.minimum_filter1d(np.where(seen, light, np.inf), 3, axis=0)
    even = seen & (most - least < _EVEN)
    half, ends = light.shape[1] // 2, max(round(_FADED * light.shape[1] / 2), 1)
    # what is dark at the end of the reach is print, and may reach up to the crease
    for side, end in ((slice(0, half), slice(0, ends)), (slice(half, None), slice(-ends, None))):
        far = np.where(even[:, end], light[:, end], -np.inf).max(axis=1)
        even[:, side] &= (np.abs(far) < _SAME)[:, None]
    level = np.zeros(light.shape[1])
    above = even.copy()
    for _ in range(3):
        level = (light * above).sum(axis=0) / np.maximum(above.sum(axis=0), 1)
        above = even & (light >= level)
    paper = even & (light > level - _SAME)
    paper &= (paper.sum(axis=0) > _FEWEST * len(light)) & (level > -_DARKEST)
    return np.asarray(paper)


def _smooth_along(values: Array, paper: NDArray[np.bool_], sigma: float) -> Array:
    """Mean of values (S, D, 3) over the paper along the crease, by a Gaussian."""
    weight = ndimage.gaussian_filter1d(paper.astype(float), sigma, axis=0, mode="constant")
    total = ndimage.gaussian_filter1d(values, sigma, axis=0, mode="constant")
    return np.asarray(total / (weight + _FEW)[..., None])


def _smooth_across(light: Array, shown: NDArray[np.bool_], sigma: float) -> Array:
    """Mean of light (S, D, 3) on one side of the crease over the distances at which paper is shown, by a Gaussian."""
    weight = ndimage.gaussian_filter1d(shown.astype(float), sigma, mode="constant")
    total = ndimage.gaussian_filter1d(light * shown[:, None], sigma, axis=1, mode="constant")
    return np.asarray(total / np.where(weight > 0, weight, 1)[:, None])
