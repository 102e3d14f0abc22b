"""Where the reference photo shows the page worse than the other photos do: glare, blur, passing shadows and things."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from .page_views import PageViews

Cells = NDArray[np.bool_]
Values = NDArray[np.float32]

KINDS = ("glare", "blur", "shadow")

# Differences are those of logarithms of brightness, sizes are cells (1/192 of the page's longer side). On the sheets
# without blemishes, measured and rendered, 99.9 % of the cells differ by less than 0.09.
_BRIGHTER = 0.2
_DARKER = 0.25
_GROWN_TO = 0.5  # of these, for the fringes of what is found
_DEVIATIONS = 3.0  # of the other photos among each other, for print that lies beside itself
_BURNT = 0.95  # brightness, mean of the channels, from which on little is told apart
# Of the whole scale, in the channel that is darker: in the dark, gloss and white balance change saturated inks by any
# factor (a blue cover by 0.3 in its red channel).
_VISIBLY = 0.1
# Share of detail in its weakest direction. Readable sheets keep 0.65 and more everywhere, a column of text doubled by
# motion has 0.12 to 0.26.
_BLURRED = 0.3
_GROWN_BLUR = 0.5
_NOISE = 1e-4  # mean squared gradient, as blank paper has it
_PRINT = 4e-4  # the faintest text has more
_DETAIL_SCALE = 2.0
_WORD_SCALE = 1.5
_LEAST_CONTRAST = 0.1
_LETTER_GAP = 5  # lines of text and their margins belong together
_SMALLEST = {"glare": 0.002, "blur": 0.01, "shadow": 0.004}  # of the page
_EDGE = 3  # along the paper's edge other photos may show what lies beside it
_FRINGE = 2
_FEWEST_OTHERS = 2  # photos that must see a cell to say that the reference is wrong there
_ROUNDS = 20
_USUAL_DIFFERENCE = 0.1


@dataclass(frozen=True)
class Blemishes:
    """What is wrong with the reference's page, and which photos are better.

    Attributes
    ----------
    found : dict of (h, w) bool arrays
        For each of `KINDS`; no cell has two.
    better : (n, h, w) bool array
        Which photos show a cell in the light that most agree on, and sharply.
    sharpness : (n, h, w) float32 array
        Detail of each photo in proportion to that of the second sharpest, in its weakest direction.
    """

    found: dict[str, Cells]
    better: Cells
    sharpness: Values


def find_blemishes(views: PageViews, reference: int) -> Blemishes:
    """Compare the reference's page with those of the other photos.

    What it shows otherwise than the others agree on is its own: a reflection is brighter and hides print, a shadow or a
    hand is darker. Where fewer than two other photos see the page, nothing is said.
    """
    others = np.arange(len(views.color)) != reference
    judged = views.visible[reference] & (views.visible[others].sum(axis=0) >= _FEWEST_OTHERS)
    color = exposure(views.color, views.visible, reference)
    if not judged.any():
        nothing = np.zeros(judged.shape, bool)
        return Blemishes(
            dict.fromkeys(KINDS, nothing), np.zeros_like(views.visible), np.zeros(color.shape[:3], np.float32)
        )
    consensus, spread = _agreed(color[others], views.visible[others])
    brighter, darker = _beyond(color[reference], consensus, spread)
    second = _second_sharpest(views, others)
    sharpness = np.stack([_least(_directional(part), second) for part in views.detail])
    sharpness /= _contrast_left(views, others)
    printed = second.max(axis=0) > _PRINT
    inner = judged & ndimage.binary_erosion(views.page, iterations=_EDGE)

    burnt = np.exp(views.color[reference]).mean(axis=-1) >= _BURNT
    found = {}
    found["glare"] = _grown(inner & (brighter > _BRIGHTER) & burnt, judged & (brighter > _GROWN_TO * _BRIGHTER))
    found["shadow"] = _grown(inner & (darker > _DARKER), judged & (darker > _GROWN_TO * _DARKER))
    found["blur"] = _grown(
        inner & printed & (sharpness[reference] < _BLURRED), judged & printed & (sharpness[reference] < _GROWN_BLUR)
    )
    taken = np.zeros(judged.shape, bool)
    for kind in ("glare", "shadow", "blur"):
        gap = _LETTER_GAP if kind == "blur" else _FRINGE
        found[kind] = _regions(found[kind] & ~taken, gap, _SMALLEST[kind] * views.page.sum()) & views.page & ~taken
        if kind == "blur":
            found[kind] &= inner  # margins are blank, and other photos may show what lies beside them
        taken |= found[kind]

    usual = np.abs(color - consensus).max(axis=-1) < np.maximum(_GROWN_TO * _DARKER, _DEVIATIONS * spread.max(axis=-1))
    sharp = ~printed | (sharpness > 0.5)
    better = np.stack([ndimage.uniform_filter(each.astype(np.float32), 7) > 0.6 for each in usual & sharp])
    better &= views.visible
    better[reference] = False
    return Blemishes(found, better, sharpness)


def _agreed(color: Values, visible: Cells) -> tuple[Values, Values]:
    """Median (h, w, 3) of the photos that see a cell, and their standard deviation by the median deviation."""
    seen = visible.any(axis=0)
    known = np.where(visible[..., None], color, np.nan)[:, seen]
    consensus, spread = np.zeros(color.shape[1:], np.float32), np.zeros(color.shape[1:], np.float32)
    consensus[seen] = np.nanmedian(known, axis=0)
    spread[seen] = 1.4826 * np.nanmedian(np.abs(known - consensus[seen]), axis=0)
    return consensus, spread


def _beyond(color: Values, consensus: Values, spread: Values) -> tuple[Values, Values]:
    """How much brighter (h, w), and darker in any channel, than all that is agreed on around a cell.

    Print that lies a cell beside itself is no difference; nor is one that the others have among each other.
    """
    around = (3, 3, 1)
    brighter = (color - ndimage.maximum_filter(consensus, around)).min(axis=-1)
    least = ndimage.minimum_filter(consensus, around)
    darker = np.where(np.exp(least) - np.exp(color) > _VISIBLY, least - color, 0).max(axis=-1)
    usual = _DEVIATIONS * spread.mean(axis=-1)
    return np.where(brighter > usual, brighter, 0), np.where(darker > usual, darker, 0)


def _directional(detail: Values) -> Values:
    """Mean squared gradient (4, h, w) along, across and both ways slantwise."""
    xx, yy, xy = (ndimage.gaussian_filter(part, _DETAIL_SCALE) for part in detail)
    return np.stack([xx, (xx + yy) / 2 + xy, yy, (xx + yy) / 2 - xy])


def _second_sharpest(views: PageViews, others: Cells) -> Values:
    """Detail (4, h, w) in the second sharpest of the other photos: the sharpest may have something lying there."""
    seen = np.where(views.visible[others][:, None], np.stack([_directional(d) for d in views.detail[others]]), 0)
    return np.sort(seen, axis=0)[-2] if len(seen) > 1 else np.zeros_like(seen[0])


def _least(detail: Values, second: Values) -> Values:
    """The share of detail in the direction in which the least is left, of those with print."""
    share = (detail + _NOISE) / (second + _NOISE)
    return np.where(second > _PRINT, share, np.inf).min(axis=0)


def _contrast_left(views: PageViews, others: Cells) -> Values:
    """The share of contrast (n, h, w) that each photo has left at the size of words: light takes it, blur does not."""
    light = views.color.mean(axis=-1)
    words = light - np.stack([ndimage.gaussian_filter(each, _WORD_SCALE) for each in light])
    contrast = np.stack([ndimage.gaussian_filter(each**2, _DETAIL_SCALE) for each in words])
    usual = np.median(contrast[others], axis=0)
    return np.clip((contrast + _NOISE) / (usual + _NOISE), _LEAST_CONTRAST, 1)


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


def exposure(color: Values, visible: Cells, reference: int) -> Values:
    """Bring all photos to the reference's exposure.

    A plane over the page for each photo and channel, for the light of lamp and lens falls off slowly; what differs by
    more has little weight, so that a shadow on less than half of the page leaves it alone.

    Parameters
    ----------
    color : (n, h, w, 3) array
        Logarithm of brightness.
    visible : (n, h, w) bool array
    reference : int

    Returns
    -------
    (n, h, w, 3) float32 array
        ``color`` less each photo's plane.
    """
    rows, columns = np.indices(color.shape[1:3]) / max(color.shape[1:3]) - 0.5
    terms = np.stack([np.ones_like(rows), columns, rows], axis=-1)
    matched = color.copy()
    for index in range(len(color)):
        both = visible[index] & visible[reference]
        if index == reference or not both.any():
            continue
        known = terms[both]
        for channel in range(3):
            difference = (color[index, ..., channel] - color[reference, ..., channel])[both].astype(float)
            plane = np.array([np.median(difference), 0.0, 0.0])
            for _ in range(_ROUNDS):
                weight = (1 + ((difference - known @ plane) / _USUAL_DIFFERENCE) ** 2) ** -2
                normal = (known * weight[:, None]).T @ known + 1e-6 * weight.sum() * np.eye(3)
                plane = np.linalg.solve(normal, (known * weight[:, None]).T @ difference)
            matched[index, ..., channel] -= (terms @ plane).astype(np.float32)
    return matched
