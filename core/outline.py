"""Where the paper ends in a photo."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from .camera import Array, Camera
from .contour import Snapped, outward_normals, smooth_sides, snap, take_short_cuts, trace_mask
from .errors import StepFailed
from .image import Image, gradient_magnitude, linear_light, perceptual, sample_bilinear, shrink
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
# From this share of open outline on the sheet is looked for beyond it, up to so many times its area: less than the
# two of a book's pages.
_OPEN_SHARE = 0.005
# From this share without any edge on, the outline is where the sheet was expected.
_NO_EDGE = 1.0
_GUESSED_SHARE = 0.3
_MOST_GROWTH = 1.7
_MOST_STEPS = 5
_SETTLED = 0.002
_OPEN_WORTH_TELLING = 0.06
# Strip beside the outline, pixels of the reduced photo, in which it is looked whether paper goes on; how alike colours
# are then; and the shortest stretch that counts, a part of the outline. Of 49 right outlines of generated scenes 46
# have none, books that end at print .2 to .4 of their outline.
_BESIDE = (4.0, 12.0)
_ALIKE = 4.0
_SHORTEST_STRETCH = 0.01
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
    if first.open.mean() > _OPEN_SHARE:
        # the sheet may go on where no edge is, beyond what was expected
        nowhere = np.zeros(mask.shape, bool)
        for barred in (nowhere, _beside_edges(mask, first.edge.points / factor, first.open)):
            grown = _grown(regions, mask, barred)
            other = _follow(linear, lab, grown, factor)
            if grown.sum() < _MOST_GROWTH * mask.sum() and other.doubt < first.doubt - _OPEN_SHARE:
                first = other
    edge = first.edge
    if ((edge.strength < _NO_EDGE) & ~edge.at_frame).mean() > _GUESSED_SHARE:
        # where there is no edge, the next print would be taken for one
        expected = resample(np.clip(about, 0, frame), _SPACING)
        at_frame = ((expected < 1) | (expected > frame - 1)).any(axis=1)
        confidence, notes = _judge(at_frame, ~at_frame, sheet.probability)
        return Outline(expected, confidence, notes)
    window = int(np.clip(_WINDOW * len(edge.points), 6, 60))
    rough = smooth_sides(edge.points, np.minimum(edge.strength, 10) + 0.1, window)
    second = snap(linear, resample(rough, _SPACING), 4.0, 0.5, 0.05, in_linear_light=True)
    polygon = smooth_sides(second.points, np.minimum(second.strength, 10) + 0.1, window)
    polygon = np.clip(polygon, 0, frame)
    confidence, notes = _judge(edge.at_frame, first.open, sheet.probability)
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


def _grown(regions: Regions, mask: Mask, barred: Mask) -> Mask:
    """The mask as far as paper goes on beyond it but not into what is barred, or less of it, with nothing expected."""
    nothing = np.zeros(mask.shape)
    for _ in range(_MOST_STEPS):
        width = _BELTS[0][0] * np.sqrt(mask.sum())
        depth = _depth_within(mask)
        inner = depth > width
        # paper beyond the belt must not teach what the surroundings look like
        outer = unlike_paper(regions, inner, depth < -width) | barred
        found = paper_mask(regions, inner, outer, nothing, _BELTS[0][1])
        if not found.any() or (found ^ mask).sum() < _SETTLED * mask.sum():
            break
        mask = found
    return mask


def _beside_edges(mask: Mask, outline: Array, open_part: NDArray[np.bool_]) -> Mask:
    """What lies outside the mask and nearer to a clear part of its outline than to an open one.

    A book's page goes on beyond a line of print, but not beyond the gutter into the facing page.
    """
    if open_part.all():
        return np.zeros(mask.shape, bool)
    away = []
    for part in (~open_part, open_part):
        drawn = np.ones(mask.shape, bool)
        column, row = np.floor(outline[part]).astype(np.int64).T
        drawn[np.clip(row, 0, mask.shape[0] - 1), np.clip(column, 0, mask.shape[1] - 1)] = False
        away.append(ndimage.distance_transform_edt(drawn))
    return ~mask & (away[0] < away[1])


@dataclass(frozen=True)
class _Followed:
    """The edge about the border of a mask, in full pixels, and where it is open: no edge, or paper on both sides."""

    edge: Snapped
    open: NDArray[np.bool_]

    @property
    def doubt(self) -> float:
        """How little of the outline is an edge; to run along the photo's border is worse than to be open."""
        return float(self.open.mean() + 2 * self.edge.at_frame.mean())


def _follow(linear: NDArray[np.float32], lab: NDArray[np.float32], mask: Mask, factor: int) -> _Followed:
    coarse = ndimage.gaussian_filter1d(resample(trace_mask(mask) * factor, factor), 3.0, axis=0, mode="wrap")
    first = snap(linear, resample(coarse, _SPACING), 4.0 * factor, 1.0, 0.15, in_linear_light=False)
    shorter = factor * take_short_cuts(resample(first.points / factor, 1.0), gradient_magnitude(lab, 1.0))
    edge = snap(linear, resample(shorter, _SPACING), 2.0 * factor, 1.0, 0.15, in_linear_light=False)
    faint = edge.strength < _FAINT
    return _Followed(edge, (faint | _goes_on(lab, mask, edge.points / factor)) & ~edge.at_frame)


def _goes_on(lab: NDArray[np.float32], mask: Mask, outline: Array) -> NDArray[np.bool_]:
    """Where along an outline paper goes on beyond it: outside it looks as it does inside, or as most of the sheet.

    An outline that follows a line of print is strong, but no edge of the paper. Where most of the outline is so, the
    table looks like paper, and nothing is known.
    """
    normals = outward_normals(outline, 4.0)
    weighted = lab * np.array([1.0, 2.0, 2.0], np.float32)
    offsets = np.arange(*_BESIDE)[None, :, None] * normals[:, None]
    inside, outside = (
        np.median(sample_bilinear(weighted, outline[:, None] + side * offsets), axis=1) for side in (-1, 1)
    )
    within = _depth_within(mask) > _BESIDE[1]
    if not within.any():
        return np.zeros(len(outline), bool)
    paper = np.median(weighted[within], axis=0)
    alike = np.minimum(np.linalg.norm(outside - inside, axis=1), np.linalg.norm(outside - paper, axis=1)) < _ALIKE
    stretch = max(round(_SHORTEST_STRETCH * len(outline)), 1)
    alike = ndimage.percentile_filter(alike.astype(np.uint8), 50, size=2 * stretch + 1, mode="wrap") > 0
    return alike if alike.mean() < 0.5 else np.zeros(len(outline), bool)


def _depth_within(mask: Mask) -> Array:
    """Distance from the mask's edge, pixels, positive within; a mask that leaves the photo has no edge there."""
    inner = ndimage.distance_transform_edt(np.pad(mask, 1, mode="edge"))[1:-1, 1:-1]
    return np.asarray(inner - ndimage.distance_transform_edt(~mask))


def _judge(near_frame: NDArray[np.bool_], weak: NDArray[np.bool_], probability: float) -> tuple[float, tuple[str, ...]]:
    notes = []
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
    if weak.mean() > _OPEN_WORTH_TELLING:
        notes.append(
            f"Along {weak.mean():.0%} of its outline the paper hardly differs from what lies beside it; "
            "look at the outline there."
        )
    sure = min(probability / _SURE_OF_SHEET, 1.0)
    return float(np.clip(sure - 3 * near_frame.mean() - 1.5 * weak.mean(), 0, 1)), tuple(notes)
