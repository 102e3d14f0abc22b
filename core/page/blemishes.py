"""Finds where the reference photo shows the page worse than other photos: glare, blur, passing shadows and objects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..numeric.robust import MAD_TO_SIGMA
from .page_cells import smooth_known
from .page_light import even_exposure
from .page_views import PageViews

Cells = NDArray[np.bool_]
Values = NDArray[np.float32]

KINDS = ("glare", "blur", "shadow")

# Differences are of logarithms of brightness (sRGB values, 0 to 1), sizes in cells (1/192 of the page's longer side).
# Measured on 24 generated scenes (benchmarks/tabletops/blemished.py, seeds 4000 to 4023), whose surfaces are off by
# 0.15 % of the page, each clean and with reflections, shadows, hands and motion; values without a figure were chosen.
_BRIGHTER = 0.2  # than any of the 3 x 3 cells around: the edge of an object or a reflection
_DARKER = 0.25  # likewise; white text displaced by a line has up to 0.33, but is no shadow overall
# Darker than the others overall, over `_SHADE_SCALE`. 99.8 % of the cells of four clean scenes are within 0.033 on pale
# places, within 0.13 on dark ones. On the paper's photos, 0.1 still classified as shaded 3 and 4 % of sheets on which
# only the light differs, so a shadow that takes less than about a quarter of the light stays.
_SHADED = 0.15
_SHINING = 0.07  # white paper has 0.13 up to burnt out
_BRIGHTENED = 0.25  # brightness, 0 to 1, that a veil adds: with 0.08 a clean dark page with a sheen counted as glare
_GROWN_TO = 0.05  # regions grow to this limit, to include their soft edge
_SHADE_SCALE = 2.0  # cells, standard deviation
_BESIDE = 5  # largest displacement of pictures
_PALE = np.log(0.5)  # brightness above which a cell shows the light: on darker print a photo's gloss changes more
_DEVIATIONS = 3.0  # of the other photos among each other, for displaced print
_LIGHT_DEVIATIONS = 1.5  # the same for smoothed light, in which two of five photos may have their own shadows
_BURNT = 0.97  # brightness above which nothing can be distinguished: 247 of 255, by choice
_VEILED = 0.4  # remaining share of the detail under a reflection
# Share of detail in its weakest direction. 99 % of printed cells of 14 sharp references keep 0.28 and more; motion by 7
# to 14 pixels leaves 0.02 to 0.2.
_BLURRED = 0.25
_GROWN_BLUR = 0.5  # as `_BLURRED`: regions of blur grow to this limit
_HAZE = 0.5  # of the contrast at the size of words: with less detail, blur took it, not light
_CLEARER = 1.5  # times the others' contrast: then they have a reflection, and the reference has no shadow
_NOISE = 3e-5  # mean squared gradient: blank paper has 1e-6 to 4e-5
_PRINT = 2e-4  # mean squared gradient: small text has 4e-4 to 1e-3
_DETAIL_SCALE = 2.0  # cells, standard deviation, over which detail is averaged
_WORD_SCALE = 1.5  # cells, standard deviation: about the size of words
_LETTER_GAP = 5  # lines of text and their margins belong together
_SMALLEST = {"glare": 0.002, "blur": 0.01, "shadow": 0.004}  # of the page: 1 cm, two lines of text, a finger
_DEEP = 8  # from the paper's edge, at least at one place: nearer, two clean scenes showed the desk in other photos
_EDGE = 3  # likewise everywhere, for blur
_FRINGE = 2  # cells by which regions of glare and shadow are joined and smoothed
# A photo is better at a cell if it is so at this share of the cells in a square of this side around it.
_BETTER_SHARE, _BETTER_AROUND = 0.6, 7
_FEWEST_OTHERS = 2  # photos that must see a cell to say that the reference is wrong there


@dataclass(frozen=True)
class Blemishes:
    """The blemishes of the reference's page, and the photos that are better.

    Attributes
    ----------
    found : dict of (h, w) bool arrays
        For each of `KINDS`; no cell has two.
    burnt : (h, w) bool array
        Burnt out in every photo that shows it, next to paper that is not.
    better : (n, h, w) bool array
        Which photos show a cell sharply and in the light on which most agree.
    sharpness : (n, h, w) float32 array
        Detail of each photo relative to that of the second sharpest, in its weakest direction.
    printed : (h, w) bool array
        Where the other photos show print.
    """

    found: dict[str, Cells]
    burnt: Cells
    better: Cells
    sharpness: Values
    printed: Cells

    @property
    def spoilt(self) -> Cells:
        """Where any kind is (h, w)."""
        return np.asarray(np.any([self.found[kind] for kind in KINDS], axis=0))


def find_blemishes(views: PageViews, reference: int) -> Blemishes:
    """Compare the reference's page with those of the other photos.

    Where it differs from what the others agree on, the difference is its own: a reflection is brighter and hides print,
    a shadow or a hand is darker. Where fewer than two other photos see the page, only burnt-out regions are found.
    """
    others = np.arange(len(views.color)) != reference
    judged = views.visible[reference] & (views.visible[others].sum(axis=0) >= _FEWEST_OTHERS)
    burnt = _burnt_in_all(views, reference)
    if not judged.any():
        nothing = np.zeros(judged.shape, bool)
        return Blemishes(
            dict.fromkeys(KINDS, nothing),
            burnt,
            np.zeros_like(views.visible),
            np.zeros(views.visible.shape, np.float32),
            nothing,
        )
    color = even_exposure(views.color, views.visible, reference)
    consensus, spread = _agreed(color[others], views.visible[others])
    brighter, darker = _beyond(color[reference], consensus, spread)
    overall = smooth_known((color[reference] - consensus).mean(axis=-1), judged, _SHADE_SCALE)
    overall[np.abs(overall) < _LIGHT_DEVIATIONS * smooth_known(spread.mean(axis=-1), judged, _SHADE_SCALE)] = 0
    second = _second_sharpest(views, others)
    detail = np.stack([_least(_directional(part), second) for part in views.detail])
    printed = second.max(axis=0) > _PRINT
    inner = judged & ndimage.binary_erosion(views.page, iterations=_EDGE)
    deep = judged & ndimage.binary_erosion(views.page, iterations=_DEEP)

    saturated = np.exp(views.color[reference]).max(axis=-1) >= _BURNT
    veiled = printed & (detail[reference] < _VEILED)
    pale = np.where(views.visible[others], color[others].mean(axis=-1), np.inf).min(axis=0) > _PALE
    found = {}
    shining, veiling, shaded = _beyond_light(color[reference], consensus, judged)
    contrast = _contrast(views, others, reference)
    hazy = detail[reference] > _HAZE * contrast
    shaded &= (overall < 0) & (contrast < _CLEARER)
    found["glare"] = _grown(
        deep & (overall > 0) & ((shining & saturated) | (veiling & veiled)),
        judged & ((brighter > _BRIGHTER) | (overall > _GROWN_TO)),
    )
    found["shadow"] = _grown(
        deep & shaded & ((darker > _DARKER) | pale), judged & ((darker > _DARKER) | (overall < -_GROWN_TO))
    )
    dull = judged & printed & ~hazy
    found["blur"] = _grown(deep & dull & (detail[reference] < _BLURRED), dull & (detail[reference] < _GROWN_BLUR))
    taken = np.zeros(judged.shape, bool)
    for kind in ("glare", "shadow", "blur"):
        gap = _LETTER_GAP if kind == "blur" else _FRINGE
        found[kind] = _regions(found[kind] & ~taken, gap, _SMALLEST[kind] * views.page.sum()) & views.page & ~taken
        if kind == "blur":
            found[kind] &= inner  # margins are blank, and other photos may show what is beside them
        taken |= found[kind]

    usual = np.abs(color - consensus).max(axis=-1) < np.maximum(_DARKER / 2, _DEVIATIONS * spread.max(axis=-1))
    sharp = ~printed | (detail > _GROWN_BLUR)
    better = np.stack(
        [ndimage.uniform_filter(each.astype(np.float32), _BETTER_AROUND) > _BETTER_SHARE for each in usual & sharp]
    )
    better &= views.visible
    better[reference] = False
    return Blemishes(found, burnt & ~taken, better, detail, printed)


def _burnt_in_all(views: PageViews, reference: int) -> Cells:
    """Cells that are burnt out in every photo that shows them, in regions next to paper that is not."""
    seen = views.visible[reference]
    everywhere = seen & (np.where(views.visible, views.brightest, 1).min(axis=0) >= _BURNT)
    return _regions(everywhere, 1, _SMALLEST["glare"] * views.page.sum()) & seen if everywhere.any() else everywhere


def _agreed(color: Values, visible: Cells) -> tuple[Values, Values]:
    """Median (h, w, 3) of the photos that see a cell, and the standard deviation that their median deviation means."""
    consensus = _median(color, visible)
    return consensus, MAD_TO_SIGMA * _median(np.abs(color - consensus), visible)


def _median(values: Values, visible: Cells) -> Values:
    """Median of the visible values over the first axis; 0 where none is visible."""
    count = visible.sum(axis=0)
    ordered = np.sort(np.where(visible[..., None], values, np.inf), axis=0)
    middle = [
        np.take_along_axis(ordered, np.maximum(k, 0)[None, ..., None], axis=0)[0]
        for k in ((count - 1) // 2, count // 2 - (count == 0))
    ]
    return np.where(count[..., None] > 0, (middle[0] + middle[1]) / 2, 0).astype(np.float32)


def _beyond(color: Values, consensus: Values, spread: Values) -> tuple[Values, Values]:
    """How much brighter (h, w), and darker in any channel, than all agreed values around a cell.

    Print displaced by a cell does not count as a difference; nor do differences among the other photos.
    """
    around = (3, 3, 1)
    brighter = (color - ndimage.maximum_filter(consensus, around)).min(axis=-1)
    darker = (ndimage.minimum_filter(consensus, around) - color).max(axis=-1)
    usual = _DEVIATIONS * spread.mean(axis=-1)
    return np.where(brighter > usual, brighter, 0), np.where(darker > usual, darker, 0)


def _beyond_light(color: Values, consensus: Values, judged: Cells) -> tuple[Cells, Cells, Cells]:
    """Where the reference's light is more, much more, and less than all agreed values nearby.

    Nearby, because other photos' pictures are slightly displaced.
    """
    own, agreed = (smooth_known(part.mean(axis=-1), judged, _SHADE_SCALE) for part in (color, consensus))
    most, least = ndimage.maximum_filter(agreed, _BESIDE), ndimage.minimum_filter(agreed, _BESIDE)
    return own - most > _SHINING, np.exp(own) - np.exp(most) > _BRIGHTENED, own - least < -_SHADED


def _directional(detail: Values) -> Values:
    """Mean squared gradient (4, h, w) along, across and in both diagonal directions."""
    xx, yy, xy = (ndimage.gaussian_filter(part, _DETAIL_SCALE) for part in detail)
    return np.stack([xx, (xx + yy) / 2 + xy, yy, (xx + yy) / 2 - xy])


def _second_sharpest(views: PageViews, others: Cells) -> Values:
    """Detail (4, h, w) in the second sharpest of the other photos: the sharpest may show an object there."""
    seen = np.where(views.visible[others][:, None], np.stack([_directional(d) for d in views.detail[others]]), 0)
    return np.sort(seen, axis=0)[-2] if len(seen) > 1 else np.zeros_like(seen[0])


def _least(detail: Values, second: Values) -> Values:
    """The share of detail in the direction with the least, among those with print."""
    share = (detail + _NOISE) / (second + _NOISE)
    return np.where(second > _PRINT, share, np.inf).min(axis=0)


def _contrast(views: PageViews, others: Cells, reference: int) -> Values:
    """The reference's contrast at the size of words (h, w) relative to the others': light reduces it, blur does not."""
    light = views.color.mean(axis=-1)
    words = light - np.stack([ndimage.gaussian_filter(each, _WORD_SCALE) for each in light])
    contrast = np.stack([ndimage.gaussian_filter(each**2, _DETAIL_SCALE) for each in words])
    return (contrast[reference] + _NOISE) / (np.median(contrast[others], axis=0) + _NOISE)


def _grown(certain: Cells, likely: Cells) -> Cells:
    return ndimage.binary_propagation(certain, mask=likely | certain)


def _regions(mask: Cells, gap: int, smallest: float) -> Cells:
    """Closed regions of at least ``smallest`` cells, without gaps and with their fringe."""
    padded = np.pad(mask, gap + 1)
    disk = np.hypot(*np.indices((2 * gap + 1, 2 * gap + 1)) - gap) <= gap + 0.5
    closed = ndimage.binary_fill_holes(ndimage.binary_closing(padded, disk))
    region, count = ndimage.label(ndimage.binary_opening(closed, iterations=1))
    large = np.bincount(region.ravel(), minlength=count + 1) >= smallest
    large[0] = False
    kept = ndimage.binary_dilation(large[region], iterations=_FRINGE)
    inside = slice(gap + 1, -gap - 1)
    return np.asarray(kept[inside, inside])
