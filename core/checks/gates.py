"""Gates between the steps: they catch implausible results before the next step uses them."""

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

# A fold by more degrees turns one of its sides away from the reference photo. Correct folds: 14 to 80.
_LARGEST_FOLD = 150.0
# Least share of the sheet's area within the frame of three photos. Like the limits below, measured on seven generated
# scenes and two real or rendered sets: correct sheets 1.0, outlines around most of the photo 0.88 to 1.0.
_LEAST_IN_VIEW = 0.97
# Largest median stretch of the flat map. Measured: correct sheets 0.00001 to 0.0022; outlines with a part too much or
# too little 0.00001 to 0.056, six of them on textured tables, across the step down to the table, at least 0.010.
_MOST_STRETCH = 0.008
# Largest share of the page outside the paper's edge. Measured: correct sheets at most 0.004; outlines with a part too
# much or too little 0.0 to 0.39, 18 of 23 of them at least 0.065. A torn-off corner, a tenth of each side, takes 0.005.
_MOST_WHITE = 0.06
# Beyond these limits a page is useless: half of the sheet out of view, or the stretch or white share of the worst
# outlines.
_HOPELESS_IN_VIEW, _HOPELESS_STRETCH, _HOPELESS_WHITE = 0.5, 0.05, 0.35

# Cells along the page's longer side in which the white share is counted: one row of them is 0.005 of a square page.
_WHITE_CELLS = 200


@dataclass(frozen=True)
class Refusal:
    """A gate's refusal of a result.

    Attributes
    ----------
    gate : str
        What was measured.
    figure, limit : float
        The measured value and its limit; both NaN if the step itself failed.
    hopeless : bool
        Whether the page is not worth making even if there is no other way.
    cause : str
        A sentence without its full stop.
    """

    gate: str
    figure: float
    limit: float
    hopeless: bool
    cause: str


def refuse_sheet(sheet: Sheet, cameras: Sequence[Camera]) -> Refusal | None:
    """Check the sheet in space: finite, no folds that hide a part of it, no larger than what the photos show.

    Parameters
    ----------
    sheet : Sheet
    cameras : sequence of Camera
        Of all photos.

    Returns
    -------
    Refusal or None
        None if the sheet is plausible.
    """
    if not np.isfinite(sheet.vertices).all():
        return _not_finite("The surface")
    in_view, least = _share_in_view(sheet, cameras), _LEAST_IN_VIEW
    if in_view < least:
        cause = f"Three photos do not show {100 * (1 - in_view):.0f} % of the sheet that was found"
        return Refusal("share of the sheet in view", in_view, least, in_view < _HOPELESS_IN_VIEW, cause)
    angles = np.abs([crease.fold_angle for crease in crease_figures(sheet)])
    fold = float(np.nanmax(angles, initial=0.0))
    if fold > _LARGEST_FOLD:
        cause = f"A crease that was found folds the sheet by {fold:.0f} degrees, onto itself"
        return Refusal("largest fold angle, degrees", fold, _LARGEST_FOLD, False, cause)
    return None


def refuse_flat(sheet: Sheet, uv: Array) -> Refusal | None:
    """Check the flat map (V, 2) of a sheet: finite, and without stretch that paper cannot have.

    Returns
    -------
    Refusal or None
        None if the map is plausible.
    """
    if not np.isfinite(uv).all():
        return _not_finite("The flat map")
    stretch = float(np.median(measure_strain(sheet.vertices, sheet.triangles, uv).stretch))
    if stretch > _MOST_STRETCH:
        cause = f"The surface that was found cannot be laid flat as paper can (it stretches by {100 * stretch:.1f} %)"
        return Refusal("median stretch", stretch, _MOST_STRETCH, stretch > _HOPELESS_STRETCH, cause)
    return None


def refuse_page(sheet: Sheet, flat: FlatMap) -> Refusal | None:
    """Check the page: finite, and filled by the sheet.

    Returns
    -------
    Refusal or None
        None if the page is plausible.
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
    """The share of the sheet's area within the frame of three cameras."""
    centres = sheet.vertices[sheet.triangles].mean(axis=1)
    views = np.zeros(len(centres), np.int64)
    for camera in cameras:
        pixels = camera.project(centres)
        inside = np.isfinite(pixels).all(axis=1)
        inside[inside] = ((pixels[inside] > 0) & (pixels[inside] < [camera.width, camera.height])).all(axis=1)
        views += inside
    area = areas(sheet.vertices, sheet.triangles)
    return float(area[views >= min(FEWEST_VIEWS, len(cameras))].sum() / area.sum())
