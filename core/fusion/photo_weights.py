"""How much each photo counts at each place of the page."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from .agreed_light import Light
from .laid_prints import LaidPrints
from .photo_views import PhotoViews

Cells = NDArray[np.bool_]
Values = NDArray[np.float32]

# Values without a figure are choices; no measurement of them is recorded.
# A cell is coloured if its channels differ by this, logarithm of linear light. A photo counts by a power of its colour,
# where enough cells are coloured: one in black and white has little more than shares of 0.1.
_COLORED, _FEWEST_COLORED, _COLOR_POWER = 0.3, 50, 4
# Power of the detail relative to the sharpest photo's: where there is no print, and what print adds to it. Blank paper
# is better the more photos count.
_BLANK_POWER, _PRINT_POWER = 0.1, 3.0
_QUIET = 1e-4  # squared gradient of the logarithm of light: noise below this does not show
_MOST_PHOTOS = 4  # blended at one place: the noise halves
_LEAST = 0.1  # share of the largest weight below which a photo is left out
_SEAM = 1.0  # cells, standard deviation, over which weights are smoothed
# Cells along the paper's edge that are the reference's alone, and over which the others' share rises from none.
_OWN_CELLS, _RISE_CELLS = 2, 3


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


def photo_weights(views: PhotoViews, light: Light, laid: LaidPrints, reference: int) -> Values:
    """The share of each photo (n, h, w), at most four at one place.

    Where there is print, detail decides; on blank paper, noise does; along the paper's edge, the reference counts.

    Parameters
    ----------
    views : PhotoViews
    light : Light
    laid : LaidPrints
    reference : int
    """
    score, printed = laid.score, laid.printed
    quiet = (views.noise.min() + _QUIET) / (views.noise + _QUIET)
    relative = score / np.maximum(score.max(axis=0), 1e-12)
    # the small power on blank paper leaves hardly any of the score's own trust in the light
    weight = relative ** (_BLANK_POWER + _PRINT_POWER * printed) * (light.trust * laid.agreement * views.large_enough)
    weight *= quiet[:, None, None] ** (1 - printed)
    weight = np.stack([ndimage.gaussian_filter(each, _SEAM) for each in weight]) * (score > 0)
    least = _LEAST * weight.max(axis=0)
    if len(weight) > _MOST_PHOTOS:
        least = np.maximum(least, np.sort(weight, axis=0)[-_MOST_PHOTOS - 1])
    weight = np.maximum(weight - least, 0)  # continuous: a photo fades before it is left out
    weight = weight / np.maximum(weight.sum(axis=0), 1e-12)
    weight = _with_the_references_edge(weight, views, light, reference)
    return _everywhere(weight, views.page, light.well_seen(reference), reference)


def _with_the_references_edge(weight: Values, views: PhotoViews, light: Light, reference: int) -> Values:
    """Weights (n, h, w) that near the paper's edge pass to the reference, which defines it.

    Not where the reference does not show the page well.
    """
    depth = ndimage.distance_transform_edt(np.pad(views.page, 1))[1:-1, 1:-1]
    inside = np.clip((depth - _OWN_CELLS) / _RISE_CELLS, 0, 1).astype(np.float32)
    inside[~light.well_seen(reference)] = 1
    weight = weight * inside
    weight[reference] += 1 - inside
    return weight


def _everywhere(weight: Values, page: Cells, seen: Cells, reference: int) -> Values:
    """Give weights to cells that have none, at the page's edge or in no photo.

    The nearest cell that has weights decides: if it is ``seen`` well in the reference, which defines the paper's edge,
    the reference alone counts, and otherwise the same photos.
    """
    shown = weight.sum(axis=0) > 0
    own = np.zeros_like(weight)
    own[reference] = 1
    if not shown.any():
        return own * page
    nearest = tuple(ndimage.distance_transform_edt(~shown, return_distances=False, return_indices=True))
    return np.where(shown | ~page, weight, np.where(seen[nearest], own, weight[:, *nearest]))
