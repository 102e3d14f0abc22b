"""Where the paper ends in a photo."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from .camera import Array
from .contour import Snapped, smooth_sides, snap, take_short_cuts, trace_mask
from .errors import StepFailed
from .gutter import facing_page
from .image import Image, gradient_magnitude, linear_light, perceptual, shrink
from .paper_mask import paper_mask
from .polygon import inside_polygon, resample
from .reference_view import prominence
from .sparse_model import SparseModel
from .support_plane import height_above_desk

_COARSE_SIDE = 800
_MIN_VIEWS = 3
_MIN_SEEDS = 20
_CLEAR_OF_DESK = 5.0
_SPACING = 2.5
# half a window of smoothing, as a part of the whole outline
_WINDOW = 0.018
_FAINT = 2.5


@dataclass(frozen=True)
class Outline:
    """The paper's edge in one photo.

    Attributes
    ----------
    polygon : (K, 2) array
        Distorted pixels of the photo, closed (the first point is not repeated), clockwise on screen.
    confidence : float
        0 (a guess) to 1 (a clear edge all around).
    notes : tuple of str
        A sentence for each thing that is unsure.
    """

    polygon: Array
    confidence: float
    notes: tuple[str, ...]


def find_outline(photo: Image, model: SparseModel, reference: int) -> Outline:
    """Find the sheet in a photo by colour difference from its surroundings, edges, and the 3D points seen on it.

    Parameters
    ----------
    photo : (h, w, 3) uint8 or uint16 array
        The photo of ``model.cameras[reference]``.
    model : SparseModel
    reference : int
        Index into ``model.cameras``.

    Raises
    ------
    StepFailed
        If too few points are seen in the photo to know where the sheet is.
    """
    seen = (model.observed_camera == reference) & (model.views_per_point() >= _MIN_VIEWS)[model.observed_point]
    if seen.sum() < _MIN_SEEDS:
        raise StepFailed(
            "Too few 3D points are seen in the reference photo to find the sheet in it; choose another reference photo "
            "or give the outline by hand."
        )
    linear = linear_light(photo)
    factor = max(1, round(max(linear.shape) / _COARSE_SIDE))
    lab = perceptual(shrink(linear, factor))
    on_sheet, on_facing_page = _seeds(model, reference, seen)
    mask = paper_mask(lab, on_sheet / factor, on_facing_page / factor)
    coarse = ndimage.gaussian_filter1d(resample(trace_mask(mask) * factor, factor), 3.0, axis=0, mode="wrap")
    first = snap(linear, resample(coarse, _SPACING), 4.0 * factor, 1.0, 0.15, in_linear_light=False)
    shorter = factor * take_short_cuts(resample(first.points / factor, 1.0), gradient_magnitude(lab, 1.0))
    first = snap(linear, resample(shorter, _SPACING), 2.0 * factor, 1.0, 0.15, in_linear_light=False)
    length = _SPACING * len(first.points)
    window = int(np.clip(_WINDOW * length / _SPACING, 6, 60))
    rough = smooth_sides(first.points, np.minimum(first.strength, 10) + 0.1, window)
    second = snap(linear, resample(rough, _SPACING), 4.0, 0.5, 0.05, in_linear_light=True)
    polygon = smooth_sides(second.points, np.minimum(second.strength, 10) + 0.1, window)
    frame = np.array([linear.shape[1], linear.shape[0]], float)
    polygon = np.clip(polygon, 0, frame)
    confidence, notes = _judge(polygon, first, on_sheet, len(on_facing_page) > 0)
    return Outline(polygon, confidence, notes)


def _judge(polygon: Array, edge: Snapped, on_sheet: Array, has_facing_page: bool) -> tuple[float, tuple[str, ...]]:
    notes = []
    near_frame = edge.at_frame
    weak = (edge.strength < _FAINT) & ~near_frame
    stray = 1 - float(inside_polygon(on_sheet, polygon).mean())
    if near_frame.mean() > 0.9:
        notes.append(
            "The whole photo is taken for the sheet, for hardly anything at its border differs from the paper; "
            "if the sheet ends within it, give the outline by hand."
        )
    elif near_frame.mean() > 0.01:
        notes.append(
            f"The sheet reaches the border of the photo along {near_frame.mean():.0%} of its outline; "
            "a photo that shows it whole serves better."
        )
    if weak.mean() > 0.03:
        notes.append(
            f"Along {weak.mean():.0%} of its outline the paper hardly differs from what lies beside it; "
            "look at the outline there."
        )
    if stray > 0.02:
        notes.append(f"{stray:.0%} of the points taken to lie on the sheet fall outside its outline; look at it.")
    if has_facing_page:
        notes.append("A facing page, which most photos cut off, was left out at the gutter.")
    return float(np.clip(1 - 3 * near_frame.mean() - 1.5 * weak.mean() - 5 * stray, 0, 1)), tuple(notes)


def _seeds(model: SparseModel, reference: int, seen: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Pixels (K, 2) of the points that most likely lie on the sheet, and of those on a facing page.

    Of the sheet those ``seen`` in the reference photo; of the facing page also those that lie outside it.
    """
    weight = prominence(model)
    height = height_above_desk(model, weight)
    if height is not None:
        weight = np.where(height > _CLEAR_OF_DESK, weight, 0.0)
    facing = facing_page(model, weight)
    point = model.observed_point[seen]
    likely = (weight[point] > 0.3 * np.quantile(weight[point], 0.9)) & ~facing[point]
    pixels = model.observed_pixel[seen]
    camera = model.cameras[reference]
    beyond = camera.project(model.points[facing])
    beyond = beyond[((beyond < 0) | (beyond > [camera.width, camera.height])).any(axis=1)]
    return pixels[likely], np.concatenate([pixels[facing[point]], beyond])
