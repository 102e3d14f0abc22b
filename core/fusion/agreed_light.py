"""The light that the photos agree on, which photos differ from it, and where."""

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

# Values without a figure are choices; no measurement of them is recorded.
_FEWEST_AGREE = 3  # photos that must show a cell to say which of them is unusual; of fewer, the reference is right
# Logarithm of linear light: a photo that differs by this from what most show, and by this many deviations of the photos
# from each other, has half of its weight: a shadow, a reflection, something passing. The sheen of paper differs by .1
# to .2 between the photos of a folded page.
_UNUSUAL, _DEVIATIONS = 0.25, 3.0
_LIGHT_SCALE = 1.5  # cells, standard deviation, over which that difference is averaged
# Linear light: the sheen of dark print differs by more, so it does not count at all up to the first value, unless the
# photo itself is brighter than sheen.
_DIM, _BRIGHT = 0.05, 0.15
_SHEEN, _BRIGHTER_THAN_SHEEN = 0.15, 0.3
_STEEPNESS = 6  # power with which the weight falls
# Below this weight a place is unusual; its soft edge, this many cells wide, keeps this share of its weight.
_HALF, _FRINGE, _FRINGE_WEIGHT = 0.5, 2, 0.1
_BURNT_WEIGHT = 1e-3
_LEAST_TRUST = 0.25  # weight with which a photo still shows a place well
_EDGE_CELLS = 3  # along the paper's edge, where other photos than the reference may show what is beside the paper
_BESIDE_CELLS = 16  # from the paper's edge: this near, the surface may be so wrong that a photo shows the table there
_OTHER_THING = 1.2  # difference of the logarithm of light that no paper in even light has
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

    def well_seen(self, photo: int) -> Cells:
        """Which cells (h, w) a photo shows in the light that most agree on."""
        return self.visible[photo] & (self.trust[photo] > _LEAST_TRUST)


def agreed_light(views: PhotoViews, reference: int) -> Light:
    """The light that most photos agree on, whose reflections, moving shadows and passing things are gone."""
    even = even_exposure(views.color, views.visible, reference)
    visible = views.visible & ~_beside_paper(even, views.visible, views.page, reference)
    visible &= views.large_enough > 0
    few = visible[reference] & (visible.sum(axis=0) < _FEWEST_AGREE)
    agreed = np.where(few[..., None], even[reference], median_of_known(even, visible))
    seen = visible.any(axis=0)
    off = np.where(visible[..., None], even - agreed, 0)
    smooth = np.stack([gaussian_mean(o, v, _LIGHT_SCALE)[0] for o, v in zip(off, visible, strict=True)])
    spread = MAD_TO_SIGMA * median_of_known(np.abs(off), visible).max(axis=-1)
    brightness = np.exp(agreed.mean(axis=-1))
    bright = np.clip((brightness - _DIM) / (_BRIGHT - _DIM), 0, 1)
    shining = np.clip((np.exp(even.mean(axis=-1)) - _SHEEN) / (_BRIGHTER_THAN_SHEEN - _SHEEN), 0, 1)
    unusual = np.maximum(_UNUSUAL, _DEVIATIONS * spread)
    trust = 1 / (1 + (np.maximum(bright, shining) * np.abs(smooth).max(axis=-1) / unusual) ** _STEEPNESS)
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


def _beside_paper(even: Values, visible: Cells, page: Cells, reference: int) -> Cells:
    """Which cells (n, h, w) of each photo, all at one exposure, show what is beside the paper.

    The paper's edge is where the reference has it. Such a cell differs from the reference's, is less like the paper
    farther inside, and is connected to the edge by others like it.
    """
    rim = page & ~ndimage.binary_erosion(page, iterations=2)  # of the outermost cells no photo is known
    inside = ndimage.binary_erosion(page, iterations=_BESIDE_CELLS)
    light = even.mean(axis=-1)
    typical = smooth_known(
        median_of_known(light[..., None], visible)[..., 0], inside & visible.any(axis=0), _BESIDE_CELLS / 2
    )
    beside = np.zeros_like(visible)
    for index in range(len(visible)):
        both = visible[index] & visible[reference] & page & ~inside
        if index != reference and both.any():
            unlike = both & (np.abs(light[index] - light[reference]) > _OTHER_THING)
            unlike &= np.abs(light[index] - typical) > np.abs(light[reference] - typical)
            joined = ndimage.binary_propagation(rim & unlike, mask=unlike)
            beside[index] = ndimage.binary_dilation(joined, iterations=_EDGE_CELLS)
    return beside


def _calm(light: Values) -> Cells:
    """Cells without edges nearby, where print that is a little displaced or blurred does not look like light."""
    return np.asarray(ndimage.maximum_filter(light, 3) - ndimage.minimum_filter(light, 3) < _EVEN)


def median_of_known(values: Values, visible: Cells) -> Values:
    """Median (h, w, c) over the photos that show a cell; 0 where none does."""
    count = visible.sum(axis=0)
    ordered = np.sort(np.where(visible[..., None], values, np.inf), axis=0)
    middle = [
        np.take_along_axis(ordered, np.maximum(k, 0)[None, ..., None], axis=0)[0]
        for k in ((count - 1) // 2, count // 2 - (count == 0))
    ]
    return np.where(count[..., None] > 0, (middle[0] + middle[1]) / 2, 0).astype(np.float32)
