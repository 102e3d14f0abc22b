"""Is what a step found plausible? Gates between the steps catch absurd results before the next step uses them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..creases.creases import crease_figures
from ..flat.distortion import measure_strain
from ..numeric.polygon import filled_polygon
from ..numeric.triangles import areas
from ..sheet import FlatMap, Sheet
from ..sparse_model import FEWEST_VIEWS

# A fold by more degrees turns one of its sides away from the photo that the surface is seen in. Right ones: 14 to 80.
_LARGEST_FOLD = 150.0
# Least share of the sheet's area that lies within the frame of three photos. Measured on seven generated scenes and two
# real or rendered sets, as the limits below: right sheets 1.0, outlines around most of the photo 0.88 to 1.0.
_LEAST_IN_VIEW = 0.97
# Largest median stretch of the flat map. Measured: right sheets 0.00001 to 0.0022; outlines with a part too much or too
# little 0.00001 to 0.056, on tables with texture six of them from 0.010 on, across the step down to the table.
_MOST_STRETCH = 0.008
# Largest share of the page outside the paper's edge. Measured: right sheets at most 0.004; outlines with a part too
# much or too little 0.0 to 0.39, 18 of 23 of them from 0.065 on. A corner torn off, a tenth of the sides each, takes
# 0.005.
_MOST_WHITE = 0.06
# Beyond these no page is worth having: half of the sheet not in view, the stretch and the white of the worst outlines.
_HOPELESS_IN_VIEW, _HOPELESS_STRETCH, _HOPELESS_WHITE = 0.5, 0.05, 0.35

_WHITE_CELLS = 200


@dataclass(frozen=True)
class Refusal:
    """What a gate did not let through.

    Attributes
    ----------
    gate : str
        What was measured.
    figure, limit : float
        What came out, and what it may be; both NaN where a step failed by itself.
    hopeless : bool
        Whether a page is not worth making even where no other way is left.
    cause : str
        A sentence without its full stop.
    """

    gate: str
    figure: float
    limit: float
    hopeless: bool
    cause: str


def refuse_sheet(sheet: Sheet, cameras: Sequence[Camera]) -> Refusal | None:
    """Look at the sheet in space: finite, no folds that hide a part of it, no larger than what the photos show.

    Parameters
    ----------
    sheet : Sheet
    cameras : sequence of Camera
        Of all photos.

    Returns
    -------
    Refusal or None
        None where the sheet is plausible.
    """
    if not np.isfinite(sheet.vertices).all():
        return _not_finite("The surface")
    in_view, least = _share_in_view(sheet, cameras), _LEAST_IN_VIEW
    if in_view < least:
        cause = f"Of the sheet that was found {100 * (1 - in_view):.0f} % lies outside what three photos show"
        return Refusal("share of the sheet in view", in_view, least, in_view < _HOPELESS_IN_VIEW, cause)
    angles = np.abs([crease.fold_angle for crease in crease_figures(sheet)])
    fold = float(np.nanmax(angles, initial=0.0))
    if fold > _LARGEST_FOLD:
        cause = f"A crease that was found folds the sheet by {fold:.0f} degrees, onto itself"
        return Refusal("largest fold angle, degrees", fold, _LARGEST_FOLD, False, cause)
    return None


def refuse_flat(sheet: Sheet, uv: Array) -> Refusal | None:
    """Look at the flat map (V, 2) of a sheet: finite, and without the stretch that paper cannot have.

    Returns
    -------
    Refusal or None
        None where the map is plausible.
    """
    if not np.isfinite(uv).all():
        return _not_finite("The flat map")
    stretch = float(np.median(measure_strain(sheet.vertices, sheet.triangles, uv).stretch))
    if stretch > _MOST_STRETCH:
        cause = f"The surface that was found cannot be laid flat as paper can (it stretches by {100 * stretch:.1f} %)"
        return Refusal("median stretch", stretch, _MOST_STRETCH, stretch > _HOPELESS_STRETCH, cause)
    return None


def refuse_page(sheet: Sheet, flat: FlatMap) -> Refusal | None:
    """Look at the page: finite, and filled by the sheet.

    Returns
    -------
    Refusal or None
        None where the page is plausible.
    """
    size = np.array([flat.width, flat.height])
    if not (np.isfinite(flat.uv).all() and np.isfinite(size).all() and (size > 0).all()):
        return _not_finite("The page")
    scale = _WHITE_CELLS / size.max()
    columns, rows = np.maximum(np.round(size * scale).astype(int), 1)
    white = 1 - float(filled_polygon(flat.uv[sheet.boundary] * scale, (rows, columns)).mean())
    if white > _MOST_WHITE:
        cause = f"The outline that was found leaves {100 * white:.0f} % of the page white, as no sheet's does"
        return Refusal("share of the page outside the sheet", white, _MOST_WHITE, white > _HOPELESS_WHITE, cause)
    return None


def _not_finite(what: str) -> Refusal:
    return Refusal("finite", np.nan, np.nan, True, f"{what} that was found has no place in space")


def _share_in_view(sheet: Sheet, cameras: Sequence[Camera]) -> float:
    """Of the sheet's area, how much lies within the frame of three cameras."""
    centres = sheet.vertices[sheet.triangles].mean(axis=1)
    views = np.zeros(len(centres), np.int64)
    for camera in cameras:
        pixels = camera.project(centres)
        inside = np.isfinite(pixels).all(axis=1)
        inside[inside] = ((pixels[inside] > 0) & (pixels[inside] < [camera.width, camera.height])).all(axis=1)
        views += inside
    area = areas(sheet.vertices, sheet.triangles)
    return float(area[views >= min(FEWEST_VIEWS, len(cameras))].sum() / area.sum())
