"""How much each photo counts at each place of the page, and the light that the photos agree on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..numeric.image import gaussian_mean
from ..numeric.robust import MAD_TO_SIGMA
from ..page.page_cells import smooth_known
from .exposure import even_exposure
from .photo_views import PhotoViews

Cells = NDArray[np.bool_]
Values = NDArray[np.float32]

# Logarithm of linear light: a photo that differs by this from what most show, and by so many deviations of the photos
# from each other, has half of its weight: a shadow, a reflection, something passing. The sheen of paper differs by .1
# to .2 between the photos of a folded page.
_UNUSUAL, _DEVIATIONS = 0.25, 3.0
# Linear light: the sheen of dark print differs by more, so it does not count at all up to the first value.
_DIM, _BRIGHT = 0.05, 0.15
_STEEPNESS = 6  # power with which the weight falls
_HALF, _FRINGE, _FRINGE_WEIGHT = (
    0.5,
    2,
    0.1,
)  # cells around such a place, its soft edge, with this share of their weight
_LEAST_TRUST = 0.25  # weight with which a photo still defines the paper's edge
_LIGHT_SCALE = 1.5  # cells, standard deviation, over which that difference is averaged
# Area in a photo as a share of the largest in any: with the first it does not count at all, from the second on fully.
# Parts seen that much at a slant are smeared, and a slightly wrong surface shows what is beside or behind the paper.
_SMALLEST, _LARGE = 0.15, 0.35
_FEWEST_AGREE = 3  # photos that must show a cell to say which of them is unusual; of fewer, the reference is right
_BURNT_WEIGHT = 1e-3
_EDGE_CELLS = 3  # along the paper's edge, where other photos than the reference may show what is beside the paper
_BESIDE_CELLS = 16  # from the paper's edge: this near, the surface may be so wrong that a photo shows the table there
_OTHER_THING = 1.2  # difference of the logarithm of light that no paper in even light has
# Power of the detail relative to the sharpest photo's: where there is no print, and what print adds to it. Blank paper
# is better the more photos count.
_BLANK_POWER, _PRINT_POWER = 0.1, 3.0
# A cell is coloured if its channels differ by this, logarithm of linear light. A photo counts by a power of its colour,
# where enough cells are coloured: one in black and white has little more than shares of 0.1.
_COLORED, _FEWEST_COLORED, _COLOR_POWER = 0.3, 50, 4
_QUIET = 1e-4  # squared gradient of the logarithm of light: noise below this does not show
_MOST_PHOTOS = 4  # blended at one place: the noise halves
_LEAST = 0.1  # share of the largest weight below which a photo is left out
_SEAM = 1.0  # cells, standard deviation, over which weights are smoothed
# Gains: cells whose surroundings are even by this difference, and the standard deviation of their mean, cells.
_EVEN, _GAIN_SCALE, _LEAST_SHARE = 0.3, 5.0, 0.02
_MOST_GAIN = 1.5  # logarithm, a factor of 4.5: a bound against runaways, not measured


@dataclass(frozen=True)
class Light:
    """The light of n photos on a page of (h, w) cells.

    Attributes
    ----------
    visible : (n, h, w) bool array
        Where each photo shows the page, and not what is beside the paper.
    agreed : (h, w, 3) float32 array
        What most photos show at the reference's exposure, logarithm of linear light.
    gain : (n, h, w, 3) float32 array
        The factor on each photo's linear light that brings it there.
    trust : (n, h, w) float32 array
        0 to 1: how well a photo's light agrees with that of most.
    """

    visible: Cells
    agreed: Values
    gain: Values
    trust: Values


def agreed_light(views: PhotoViews, reference: int) -> Light:
    """The light that most photos agree on, whose reflections, moving shadows and passing things are gone."""
    even = even_exposure(views.color, views.visible, reference)
    visible = views.visible & ~_beside_paper(even, views.visible, views.page, reference)
    visible &= views.area > _SMALLEST * views.area.max(axis=0)
    few = visible[reference] & (visible.sum(axis=0) < _FEWEST_AGREE)
    agreed = np.where(few[..., None], even[reference], _median(even, visible))
    seen = visible.any(axis=0)
    off = np.where(visible[..., None], even - agreed, 0)
    smooth = np.stack([gaussian_mean(o, v, _LIGHT_SCALE)[0] for o, v in zip(off, visible, strict=True)])
    spread = MAD_TO_SIGMA * _median(np.abs(off), visible).max(axis=-1)
    brightness = np.exp(agreed.mean(axis=-1))
    bright = np.clip((brightness - _DIM) / (_BRIGHT - _DIM), 0, 1)
    unusual = np.maximum(_UNUSUAL, _DEVIATIONS * spread)
    trust = 1 / (1 + (bright * np.abs(smooth).max(axis=-1) / unusual) ** _STEEPNESS)
    odd = [ndimage.binary_dilation(t < _HALF, iterations=_FRINGE) for t in trust * visible + ~visible]
    trust = np.where(odd, _FRINGE_WEIGHT * trust, trust)
    trust[:, visible.sum(axis=0) < _FEWEST_AGREE] = 1
    trust = np.where(views.burnt, np.minimum(trust, _BURNT_WEIGHT), trust) * visible
    calm = seen & _calm(agreed.mean(axis=-1)) & ndimage.binary_erosion(views.page, iterations=_EDGE_CELLS)
    gain = np.empty_like(even)
    for index in range(len(gain)):
        known = (calm & visible[index]) * trust[index] * bright
        rest, _ = gaussian_mean(-off[index], known.astype(np.float32), _GAIN_SCALE, _LEAST_SHARE)
        gain[index] = np.exp(np.clip(even[index] - views.color[index] + rest, -_MOST_GAIN, _MOST_GAIN))
    return Light(visible, agreed, gain, trust.astype(np.float32))


def _calm(light: Values) -> Cells:
    """Cells without edges nearby, where print that is a little displaced or blurred does not look like light."""
    return np.asarray(ndimage.maximum_filter(light, 3) - ndimage.minimum_filter(light, 3) < _EVEN)


def _median(values: Values, visible: Cells) -> Values:
    """Median (h, w, c) over the photos that show a cell; 0 where none does."""
    count = visible.sum(axis=0)
    ordered = np.sort(np.where(visible[..., None], values, np.inf), axis=0)
    middle = [
        np.take_along_axis(ordered, np.maximum(k, 0)[None, ..., None], axis=0)[0]
        for k in ((count - 1) // 2, count // 2 - (count == 0))
    ]
    return np.where(count[..., None] > 0, (middle[0] + middle[1]) / 2, 0).astype(np.float32)


def quality(views: PhotoViews, light: Light) -> Values:
    """How well each photo (n, h, w) shows each cell: detail and light, 0 where it does not show it."""
    return views.detail * light.trust * light.visible * _colorfulness(views, light)[:, None, None] ** _COLOR_POWER


def _colorfulness(views: PhotoViews, light: Light) -> Values:
    """The share (n,) of the colour of the coloured parts of the page that each photo has: 0 for a grey one."""
    agreed = light.agreed - light.agreed.mean(axis=-1, keepdims=True)
    colored = np.linalg.norm(agreed, axis=-1) > _COLORED
    shares = []
    for color, visible in zip(views.color, light.visible, strict=True):
        where = colored & visible
        own = color - color.mean(axis=-1, keepdims=True)
        common = (own[where] * agreed[where]).sum(axis=-1) / np.maximum((agreed[where] ** 2).sum(axis=-1), 1e-12)
        shares.append(np.clip(np.median(common), 0, 1) if where.sum() >= _FEWEST_COLORED else 1.0)
    return np.array(shares, np.float32)


def large_enough(views: PhotoViews) -> Values:
    """0 to 1: whether each photo (n, h, w) shows a cell large enough beside the others."""
    share = views.area / np.maximum(views.area.max(axis=0), 1e-12)
    return np.clip((share - _SMALLEST) / (_LARGE - _SMALLEST), 0, 1)


def with_the_references_edge(weight: Values, views: PhotoViews, light: Light, reference: int) -> Values:
    """Weights (n, h, w) that near the paper's edge pass to the reference, which defines it.

    Not where the reference does not show the page well.
    """
    depth = ndimage.distance_transform_edt(np.pad(views.page, 1))[1:-1, 1:-1]
    inside = np.clip((depth - 2) / _EDGE_CELLS, 0, 1).astype(np.float32)
    inside[~sees_well(light, reference)] = 1
    weight = weight * inside
    weight[reference] += 1 - inside
    return weight


def sees_well(light: Light, photo: int) -> Cells:
    """Which cells (h, w) a photo shows in the light that most agree on."""
    return light.visible[photo] & (light.trust[photo] > _LEAST_TRUST)


def weights(score: Values, agreement: Values, printed: Values, noise: Values) -> Values:
    """The share of each photo (n, h, w), at most four at one place.

    Where there is print, detail decides; on blank paper, noise does.

    Parameters
    ----------
    score : (n, h, w) array
        As by `quality`.
    agreement : (n, h, w) array
        0 to 1: how well a photo's print lies on that of the photo that is best there.
    printed : (h, w) array
        0 to 1: how much print there is.
    noise : (n,) array
        As in `PhotoViews`.
    """
    quiet = (noise.min() + _QUIET) / (noise + _QUIET)
    relative = score / np.maximum(score.max(axis=0), 1e-12)
    weight = relative ** (_BLANK_POWER + _PRINT_POWER * printed) * agreement
    weight *= quiet[:, None, None] ** (1 - printed)
    weight = np.stack([ndimage.gaussian_filter(each, _SEAM) for each in weight]) * (score > 0)
    least = _LEAST * weight.max(axis=0)
    if len(weight) > _MOST_PHOTOS:
        least = np.maximum(least, np.sort(weight, axis=0)[-_MOST_PHOTOS - 1])
    weight = np.maximum(weight - least, 0)  # continuous: a photo fades before it is left out
    return weight / np.maximum(weight.sum(axis=0), 1e-12)


def _beside_paper(even: Values, visible: Cells, page: Cells, reference: int) -> Cells:
    """Which cells (n, h, w) of each photo, all at one exposure, show what is beside the paper.

    The paper's edge is where the reference has it. Such a cell differs from the reference's, is less like the paper
    farther inside, and is connected to the edge by others like it.
    """
    rim = page & ~ndimage.binary_erosion(page, iterations=2)  # of the outermost cells no photo is known
    inside = ndimage.binary_erosion(page, iterations=_BESIDE_CELLS)
    light = even.mean(axis=-1)
    typical = smooth_known(_median(light[..., None], visible)[..., 0], inside & visible.any(axis=0), _BESIDE_CELLS / 2)
    beside = np.zeros_like(visible)
    for index in range(len(visible)):
        both = visible[index] & visible[reference] & page & ~inside
        if index != reference and both.any():
            unlike = both & (np.abs(light[index] - light[reference]) > _OTHER_THING)
            unlike &= np.abs(light[index] - typical) > np.abs(light[reference] - typical)
            joined = ndimage.binary_propagation(rim & unlike, mask=unlike)
            beside[index] = ndimage.binary_dilation(joined, iterations=_EDGE_CELLS)
    return beside
