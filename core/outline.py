"""Where the paper ends in a photo."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from .camera import Array, Camera
from .contour import Snapped, smooth_sides, snap, take_short_cuts, trace_mask
from .errors import StepFailed
from .image import Image, gradient_magnitude, linear_light, perceptual, shrink
from .paper_mask import Mask, Regions, paper_mask, regions_of, unlike_paper
from .polygon import filled_polygon, resample, signed_area
from .sheet_search import FoundSheet

_COARSE_SIDE = 800
# Width of the belt about the expected edge to either side, in parts of the sheet's side, and rounds of learning, from
# the first search to the last.
_BELTS = ((0.12, 2), (0.05, 4))
_LEAST_SHARE = 0.01
# Where the sheet nearly fills the photo, this strip along its border, pixels of the reduced photo, shows the table.
_STRIP = 4
_SPACING = 2.5
# half a window of smoothing, as a part of the whole outline
_WINDOW = 0.018
_FAINT = 2.5
# From this share of faint outline on the sheet is looked for beyond it, up to so many times its area: less than the
# two of a book's pages.
_FAINT_SHARE = 0.005
# From this share without any edge on, the outline is where the sheet was expected.
_NO_EDGE = 1.0
_GUESSED_SHARE = 0.3
_MOST_GROWTH = 1.7
_MOST_STEPS = 5
_SETTLED = 0.002
_FAINT_WORTH_TELLING = 0.06
# Below this probability another region may as well be the sheet.
_SURE_OF_SHEET = 0.75


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


def find_outline(photo: Image, camera: Camera, sheet: FoundSheet) -> Outline:
    """Follow the edge of a sheet that is about known, by colour difference from its surroundings and by edges.

    Parameters
    ----------
    photo : (h, w, 3) uint8 or uint16 array
    camera : Camera
        Of the photo.
    sheet : FoundSheet

    Raises
    ------
    StepFailed
        If the sheet does not show in the photo.
    """
    linear = linear_light(photo)
    frame = np.array([linear.shape[1], linear.shape[0]], float)
    about = camera.project(sheet.outline)
    if not np.isfinite(about).all() or abs(signed_area(np.clip(about, 0, frame))) < _LEAST_SHARE * frame.prod():
        raise StepFailed(
            f"{camera.name} hardly shows the sheet; choose another reference photo, or none (--reference, or Reference "
            "Photo in Blender)."
        )
    factor = max(1, round(max(linear.shape) / _COARSE_SIDE))
    lab = perceptual(shrink(linear, factor))
    regions = regions_of(lab)
    mask = _mask_near(regions, about / factor)
    first = _follow(linear, lab, mask, factor)
    if _faint(first).mean() > _FAINT_SHARE:
        # the sheet may go on where no edge is, beyond what was expected
        grown = _grown(regions, mask)
        second = _follow(linear, lab, grown, factor)
        if grown.sum() < _MOST_GROWTH * mask.sum() and _doubt(second) < _doubt(first) - _FAINT_SHARE:
            first = second
    if ((first.strength < _NO_EDGE) & ~first.at_frame).mean() > _GUESSED_SHARE:
        # where there is no edge, the next print would be taken for one
        expected = resample(np.clip(about, 0, frame), _SPACING)
        at_frame = ((expected < 1) | (expected > frame - 1)).any(axis=1)
        first = Snapped(expected, np.zeros(len(expected)), at_frame)
        confidence, notes = _judge(first, sheet.probability)
        return Outline(expected, confidence, notes)
    length = _SPACING * len(first.points)
    window = int(np.clip(_WINDOW * length / _SPACING, 6, 60))
    rough = smooth_sides(first.points, np.minimum(first.strength, 10) + 0.1, window)
    second = snap(linear, resample(rough, _SPACING), 4.0, 0.5, 0.05, in_linear_light=True)
    polygon = smooth_sides(second.points, np.minimum(second.strength, 10) + 0.1, window)
    polygon = np.clip(polygon, 0, frame)
    confidence, notes = _judge(first, sheet.probability)
    return Outline(polygon, confidence, notes)


def _mask_near(regions: Regions, about: Array) -> Mask:
    """The sheet's pixels, looked for in a belt about where its edge should be, and again in a narrower one."""
    mask = filled_polygon(about, regions.label.shape)
    widest = _BELTS[0][0] * np.sqrt(mask.sum())
    expected = np.clip(_depth_within(mask) / widest, -1, 1)
    for reach, rounds in _BELTS:
        width = max(reach * np.sqrt(mask.sum()), 3.0)
        depth = _depth_within(mask)
        inner, outer = depth > width, depth < -width
        if not outer.any():
            outer = unlike_paper(regions, inner, _along_frame(mask.shape) & (depth < 0))
        found = paper_mask(regions, inner, outer, expected, rounds)
        if not found.any():
            break
        mask = found
    return mask


def _along_frame(shape: tuple[int, ...]) -> Mask:
    strip = np.ones(shape, bool)
    strip[_STRIP:-_STRIP, _STRIP:-_STRIP] = False
    return strip


def _grown(regions: Regions, mask: Mask) -> Mask:
    """The mask as far as paper goes on beyond it, or less of it, with nothing expected."""
    nothing = np.zeros(mask.shape)
    for _ in range(_MOST_STEPS):
        width = _BELTS[0][0] * np.sqrt(mask.sum())
        depth = _depth_within(mask)
        inner = depth > width
        # paper beyond the belt must not teach what the surroundings look like
        found = paper_mask(regions, inner, unlike_paper(regions, inner, depth < -width), nothing, _BELTS[0][1])
        if not found.any() or (found ^ mask).sum() < _SETTLED * mask.sum():
            break
        mask = found
    return mask


def _follow(linear: NDArray[np.float32], lab: NDArray[np.float32], mask: Mask, factor: int) -> Snapped:
    """The edge about the border of a mask, in full pixels."""
    coarse = ndimage.gaussian_filter1d(resample(trace_mask(mask) * factor, factor), 3.0, axis=0, mode="wrap")
    first = snap(linear, resample(coarse, _SPACING), 4.0 * factor, 1.0, 0.15, in_linear_light=False)
    shorter = factor * take_short_cuts(resample(first.points / factor, 1.0), gradient_magnitude(lab, 1.0))
    return snap(linear, resample(shorter, _SPACING), 2.0 * factor, 1.0, 0.15, in_linear_light=False)


def _faint(edge: Snapped) -> NDArray[np.bool_]:
    return (edge.strength < _FAINT) & ~edge.at_frame


def _doubt(edge: Snapped) -> float:
    """How little of the outline is an edge; to run along the photo's border is worse than to be faint."""
    return float(_faint(edge).mean() + 2 * edge.at_frame.mean())


def _depth_within(mask: Mask) -> Array:
    """Distance from the mask's edge, pixels, positive within; a mask that leaves the photo has no edge there."""
    inner = ndimage.distance_transform_edt(np.pad(mask, 1, mode="edge"))[1:-1, 1:-1]
    return np.asarray(inner - ndimage.distance_transform_edt(~mask))


def _judge(edge: Snapped, probability: float) -> tuple[float, tuple[str, ...]]:
    notes = []
    near_frame = edge.at_frame
    weak = _faint(edge)
    if probability < _SURE_OF_SHEET:
        notes.append(
            "It is not sure which part of the photos is the sheet; look at the outline, and give it by hand if it is "
            "another one (--outline, or Edit Outline in Blender)."
        )
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
    if weak.mean() > _FAINT_WORTH_TELLING:
        notes.append(
            f"Along {weak.mean():.0%} of its outline the paper hardly differs from what lies beside it; "
            "look at the outline there."
        )
    sure = min(probability / _SURE_OF_SHEET, 1.0)
    return float(np.clip(sure - 3 * near_frame.mean() - 1.5 * weak.mean(), 0, 1)), tuple(notes)
