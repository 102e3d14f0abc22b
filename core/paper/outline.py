"""Find the paper's edge in a photo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..camera import Camera
from ..errors import StepFailed
from ..numeric.image import Image, linear_light
from ..numeric.morphology import Mask, dilated, eroded
from ..numeric.polygon import filled_polygon, resample, signed_area
from ..numeric.simple_polygon import without_loops
from ..numeric.threads import in_threads
from .followed_edge import SPACING, FollowedEdge, ReducedPhoto
from .notches import cut_at_notches
from .outline_judgement import SAME, Judgement, Signs, signs_of
from .paper_mask import Regions, paper_mask, regions_of, unlike_paper
from .sheet_search import FoundSheet, in_common
from .smooth_contour import smooth_sides
from .snapped_contour import snap
from .straight_side import StraightSide, straight_side

# Values without a figure are choices; no measurement of them is recorded.
# Width of the belt around the expected edge to either side, as a part of the sheet's side, and rounds of learning, for
# the first search and the last.
_BELTS = ((0.12, 2), (0.05, 4))
_NARROWEST_BELT = 3.0  # pixels of the reduced photo
# Of the photo's area: a sheet that covers less is hardly shown.
_LEAST_SHARE = 0.01
# If the sheet nearly fills the photo, this strip along its border, pixels of the reduced photo, shows the table.
_STRIP = 4
# Length of the parabolas that smooth the outline, as a part of it, and their fewest and most points.
_WINDOW, _FEWEST, _MOST = 0.018, 6, 60
# A point of the outline counts by the colour step of its edge, up to the first value and at least with the second.
_FULL_STEP, _LEAST_TRUST = 10, 0.1
# The last search for the edge: reach and step, pixels of the photo, and stiffness.
_LAST_SEARCH = (4.0, 0.5, 0.05)
# Above this share of open outline, the sheet is also looked for beyond it, up to this many times its area: less than
# the two pages of an open book. It grows in this many steps at most, and is done when it changes by less than this
# part.
_OPEN_SHARE = 0.005
_MOST_GROWTH = 1.7
_MOST_STEPS = 5
_SETTLED = 0.002
# Masks whose difference is nowhere thicker than twice this lead to the same edge, pixels of the reduced photo.
_THIN = 1.0
# Whether paper goes on beyond an edge is asked wherever the hypotheses do not agree on the sheet.
_NO_AGREEMENT = 0.0
# Below this colour step there is no edge. Above this share of outline without one, the outline is where the sheet was
# expected.
_NO_EDGE = 1.0
_GUESSED_SHARE = 0.3
# How far from its expected place the edge is looked for, pixels of the reduced photo.
_EXPECTED_REACH = 8.0


@dataclass(frozen=True)
class Outline:
    """The paper's edge in one photo.

    Attributes
    ----------
    polygon : (K, 2) array
        Distorted pixels of the photo, closed (the first point is not repeated), clockwise on screen.
    confidence : float
        The probability that it is right, 0 to 1; 1 for an outline that a person gave.
    notes : tuple of str
        A sentence for each uncertainty.
    """

    polygon: Array
    confidence: float
    notes: tuple[str, ...]


@dataclass(frozen=True)
class FollowedOutlines:
    """The edges that were followed in one photo, one of which may be the paper's.

    Attributes
    ----------
    edges : list of FollowedEdge
        The first is that from where the sheet is expected, the others from where its rivals are.
    signs : list of Signs
        What speaks for and against each.
    """

    edges: list[FollowedEdge]
    signs: list[Signs]


def follow_outlines(photo: Image, camera: Camera, sheet: FoundSheet, threads: int = 1) -> FollowedOutlines:
    """Follow the edge of a sheet whose place is roughly known, by colour differences and edges.

    The edge is followed from where the sheet is expected, and from where each of its rivals is. A true edge is reached
    from most of them, while a line of print, a fold or a gutter is reached from few; see `outline_judgement`.

    Parameters
    ----------
    photo : (h, w, 3) uint8 or uint16 array
    camera : Camera
        Of the photo.
    sheet : FoundSheet
    threads : int
        From how many places the edge is followed at once.

    Raises
    ------
    StepFailed
        If the sheet does not show in the photo.
    """
    linear = linear_light(photo)
    if not _shows(camera.project(sheet.outline), _size(linear)):
        raise StepFailed(
            f"{camera.name} hardly shows the sheet; choose another reference photo, or none (--reference, or Reference "
            "Photo in Blender)."
        )
    return FollowedOutlines(*follow_all(ReducedPhoto(linear), camera, sheet, threads))


def settled(photo: Image, edge: FollowedEdge, judgement: Judgement) -> Outline:
    """The outline along an edge in its photo (h, w, 3), to a part of a pixel."""
    if edge.guessed:
        return Outline(edge.points, judgement.confidence, judgement.notes)
    linear = linear_light(photo)
    window = int(np.clip(_WINDOW * len(edge.points), _FEWEST, _MOST))
    rough = smooth_sides(edge.points, np.minimum(edge.strength, _FULL_STEP) + _LEAST_TRUST, window)
    second = snap(linear, resample(rough, SPACING), *_LAST_SEARCH, in_linear_light=True)
    polygon = smooth_sides(second.points, np.minimum(second.strength, _FULL_STEP) + _LEAST_TRUST, window)
    polygon = without_loops(np.clip(polygon, 0, _size(linear)))
    return Outline(polygon, judgement.confidence, judgement.notes)


def _size(photo: NDArray[Any]) -> Array:
    """Width and height of a photo (h, w, 3)."""
    return np.array([photo.shape[1], photo.shape[0]], float)


def follow_all(
    reduced: ReducedPhoto, camera: Camera, sheet: FoundSheet, threads: int = 1
) -> tuple[list[FollowedEdge], list[Signs]]:
    """The edges followed from where a sheet and those of its rivals that the photo shows are expected."""
    frame = _size(reduced.linear)
    regions = regions_of(reduced.lab, reduced.gradient)
    starts = [(each, camera.project(each.outline)) for each in (sheet, *sheet.rivals)]
    starts = [(each, about) for each, about in starts if _shows(about, frame)]

    def near(start: tuple[FoundSheet, Array]) -> Mask:
        return _mask_near(regions, start[1] / reduced.factor)

    masks = list(in_threads(near, starts, threads))
    like = [next(first for first, other in enumerate(masks) if _alike(other, mask)) for mask in masks]
    distinct = sorted(set(like))

    def follow(number: int) -> FollowedEdge:
        each, about = starts[number]
        return _followed(reduced, regions, about, masks[number], frame, each.agreement)

    followed = dict(zip(distinct, in_threads(follow, distinct, threads), strict=True))
    edges = [followed[first] for first in like]
    return edges, signs_of(edges, [each for each, _ in starts], reduced.lab.shape[:2], reduced.factor)


def _shows(about: Array, frame: Array) -> bool:
    """Whether a photo shows enough of a region whose outline is expected at pixels (K, 2)."""
    return bool(np.isfinite(about).all() and abs(signed_area(np.clip(about, 0, frame))) >= _LEAST_SHARE * frame.prod())


def _alike(one: Mask, other: Mask) -> bool:
    """Whether two masks differ nowhere by more than the search for an edge evens out."""
    return not eroded(one ^ other, _THIN).any()


def _followed(
    reduced: ReducedPhoto, regions: Regions, about: Array, mask: Mask, frame: Array, agreement: float
) -> FollowedEdge:
    """The edge near where it is expected, pixels (K, 2), from the mask that was found there."""
    about = np.clip(about, 0, frame)
    edge = reduced.follow_mask(mask, agreement)
    if (clear := _clear_edge_there(reduced, about, edge)) is not None:
        return clear
    if edge.doubt > _OPEN_SHARE:
        edge = _less_doubtful(reduced, regions, about, mask, edge, agreement)
    if ((edge.strength < _NO_EDGE) & ~edge.at_frame).mean() > _GUESSED_SHARE:
        # without an edge, the nearest print would be taken for one
        return FollowedEdge.guess(resample(about, SPACING), frame)
    return edge


def _clear_edge_there(reduced: ReducedPhoto, about: Array, edge: FollowedEdge) -> FollowedEdge | None:
    """The edge where it is expected, pixels (K, 2), if it is clear all around and another than the one followed.

    The colours of what a sheet lies in or on, a clear pocket for example, may be more like the sheet's than like the
    table's.
    """

    def inside(outline: Array) -> Mask:
        return filled_polygon(outline / reduced.factor, reduced.lab.shape[:2])

    # right outlines of 21 generated sheets share .91 to .99 with where the sheet is expected; where they share less
    # than SAME, the edge that is expected is open or ragged
    expected, found = inside(about), inside(edge.points)
    if not expected.any() or in_common(expected, found) > SAME:
        return None
    there = reduced.follow(about, expected, _EXPECTED_REACH, _NO_AGREEMENT)
    another = in_common(inside(there.points), found) <= SAME
    return there if another and there.doubt <= _OPEN_SHARE else None


def _less_doubtful(
    reduced: ReducedPhoto, regions: Regions, about: Array, mask: Mask, first: FollowedEdge, agreement: float
) -> FollowedEdge:
    """The least doubtful of several outlines, if the first one is partly open or ragged, or has an inward corner.

    Colours may have misled the cut, and the edge is where it was expected; or the sheet continues beyond what was
    expected, where no edge is; or it ends at a gutter, which print beside it outdoes; or at another paper like it.
    """
    found, area = [first], [mask.sum()]
    expected = filled_polygon(about / reduced.factor, mask.shape)
    if expected.any():
        found.append(reduced.follow(about, expected, _EXPECTED_REACH, agreement))
        area.append(expected.sum())
    goes_on = first.open | first.continued
    if goes_on.mean() > _OPEN_SHARE:
        nowhere = np.zeros(mask.shape, bool)
        for barred in (nowhere, _beside_edges(mask, first.points / reduced.factor, goes_on)):
            grown = _grown(regions, mask, barred)
            if grown is not None:
                found.append(reduced.follow_mask(grown, agreement))
                area.append(grown.sum())
        side = straight_side(reduced.lab[..., 0], first.points / reduced.factor, first.open, np.sqrt(mask.sum()))
        if side is not None:
            ending = _up_to(regions, mask, side)
            found.append(reduced.follow_mask(ending, agreement).along(side, reduced.factor))
            area.append(ending.sum())
    if first.notch:
        for part in cut_at_notches(mask, first.points / reduced.factor):
            cut = reduced.follow_mask(part, agreement)
            side = straight_side(reduced.lab[..., 0], cut.points / reduced.factor, cut.open, np.sqrt(part.sum()))
            found.append(cut if side is None else cut.along(side, reduced.factor))
            area.append(part.sum())
    # an edge within the sheet is more often print than the paper's edge
    doubt = [each.doubt + max(1 - size / area[0], 0) for each, size in zip(found, area, strict=True)]
    least = int(np.argmin(doubt))
    return found[least] if doubt[least] < doubt[0] - _OPEN_SHARE else first


def _mask_near(regions: Regions, about: Array) -> Mask:
    """The sheet's pixels: searched in a belt around the expected edge, and again in a narrower belt."""
    mask = filled_polygon(about, regions.label.shape)
    widest = _BELTS[0][0] * np.sqrt(mask.sum())
    expected = _within(mask, widest)
    for reach, rounds in _BELTS:
        width = max(reach * np.sqrt(mask.sum()), _NARROWEST_BELT)
        inner, outer = eroded(mask, width), ~dilated(mask, width)
        if not outer.any():
            outer = unlike_paper(regions, inner, _along_frame(mask.shape) & ~mask)
        found = paper_mask(regions, inner, outer, expected, rounds)
        if not found.any():
            break
        mask = found
    return mask


def _up_to(regions: Regions, mask: Mask, side: StraightSide) -> Mask:
    """The mask as far as a straight side, and not beyond."""
    beyond = side.beyond(mask.shape)
    ending = (mask | filled_polygon(side.between(), mask.shape)) & ~beyond
    width = max(_BELTS[1][0] * np.sqrt(ending.sum()), _NARROWEST_BELT)
    inner, outer = eroded(ending | beyond, width) & ~beyond, ~dilated(ending, width) | beyond
    found = paper_mask(regions, inner, outer, _within(ending, width), _BELTS[1][1]) & ~beyond
    return found if found.any() else ending


def _within(mask: Mask, width: float) -> Array:
    """How far within a mask each pixel (h, w) is, -1 to 1, in parts of the width of a belt."""
    depth = ndimage.distance_transform_edt(mask) - ndimage.distance_transform_edt(~mask)
    return np.asarray(np.clip(depth / width, -1, 1))


def _along_frame(shape: tuple[int, ...]) -> Mask:
    strip = np.ones(shape, bool)
    strip[_STRIP:-_STRIP, _STRIP:-_STRIP] = False
    return strip


def _grown(regions: Regions, mask: Mask, barred: Mask) -> Mask | None:
    """The mask extended as far as paper continues, but not into what is barred; without an expected place.

    None if it grows too much for one sheet.
    """
    nothing = np.zeros(mask.shape)
    most = _MOST_GROWTH * mask.sum()
    for _ in range(_MOST_STEPS):
        width = _BELTS[0][0] * np.sqrt(mask.sum())
        inner = eroded(mask, width)
        # paper beyond the belt must not count as an example of the surroundings
        outer = unlike_paper(regions, inner, ~dilated(mask, width)) | barred
        found = paper_mask(regions, inner, outer, nothing, 1)
        if not found.any() or (found ^ mask).sum() < _SETTLED * mask.sum():
            break
        mask = found
        if mask.sum() >= most:
            return None
    return mask


def _beside_edges(mask: Mask, outline: Array, open_part: NDArray[np.bool_]) -> Mask:
    """The pixels outside the mask that are nearer to a clear part of its outline than to an open one.

    A book's page continues beyond a line of print, but not beyond the gutter into the facing page.
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
