"""Follow the paper's edge along a first guess of it in a photo, and measure how doubtful the result is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..numeric.image import COLOR_WEIGHTS, gradient_magnitude, perceptual, sample_bilinear, shrink
from ..numeric.morphology import Mask, eroded
from ..numeric.polygon import resample
from .contour import outward_normals, take_short_cuts, trace_mask
from .notches import sharpness
from .paper_beyond import in_shade, unchanged, under_print
from .smooth_contour import raggedness
from .snapped_contour import snap
from .straight_side import StraightSide

# Values without a figure are choices; no measurement of them is recorded.
# Pixels of the photo between the points of an outline.
SPACING = 2.5
# Pixels of the reduced photo's longer side.
_COARSE_SIDE = 800
# How far from the border of a mask the edge is looked for, and from the edge that was found, once detours are cut out;
# and the standard deviation that smooths the border. Pixels of the reduced photo.
_REACH, _AGAIN, _SMOOTH = 4.0, 2.0, 3.0
# Step of the search, pixels of the photo, and stiffness of the path that it finds.
_STEP, _STIFFNESS = 1.0, 0.15
# Colour step below which the outline is open.
_FAINT = 2.5
# From the first agreement of the hypotheses on the sheet ends as expected where paper seems to go on beyond it: 0.74 to
# 0.94 in seven generated scenes with right outlines, 0.40 and 0.56 in two that stop at print. From the second, also
# where the same ground goes on under print: 0.82 and 0.86 in two that stop at a fold and at a barcode, 0.99 in a page
# of a book.
_AGREED, _CERTAIN = 0.7, 0.95
# Strip beside the outline in which paper may continue, pixels of the reduced photo. The outline's normals there are
# smoothed over this many of its points.
_BESIDE, _SMOOTH_NORMALS = (4.0, 12.0), 4.0
_GRADIENT_OVER = 1.0  # standard deviation at which the gradient is taken, pixels of the reduced photo
# Above this raggedness (see `smooth_contour.raggedness`) a place is not a paper's edge. Share of such places in nine
# outlines of generated scenes with an overlap of at least 0.99: 0 to 0.024; in nine that follow print or a gutter:
# 0.017 to 0.10.
_RAGGED = 0.015
# Places of an outline this near a straight side are on it, pixels of the reduced photo: print beside a gutter drew them
# off it by up to ten.
_BESIDE_SIDE = 12.0
# How much a place at the photo's border and a ragged place count, in open places. In seven photos of generated scenes
# in which the cut goes wrong, these weights choose the better outline in six, and 2 and 0 in three.
_FRAME_WEIGHT, _RAGGED_WEIGHT = 4.0, 5.0
# How much a sharp inward corner counts beside the share of open places: where one sheet lies upon another, the side
# between them is a quarter of the outline, and what is cut off as much of the region.
_NOTCH_WEIGHT = 0.6


@dataclass(frozen=True)
class FollowedEdge:
    """An edge that may be that of the paper.

    Attributes
    ----------
    points : (M, 2) array
        Pixels, evenly spaced, clockwise.
    strength : (M,) array
        Colour step across the edge, 0 to about 100.
    at_frame : (M,) bool array
        Where it runs along the border of the photo.
    open : (M,) bool array
        Where there is hardly an edge, or paper continues beyond it.
    continued : (M,) bool array
        Where paper continues beyond whole sides of it, in shade or under print, see `paper_beyond`.
    ragged : float
        Share of the outline that is neither smooth nor a corner, unlike a paper's edge.
    notch : float
        How sharp its sharpest inward corner is, see `notches.sharpness`.
    """

    points: Array
    strength: Array
    at_frame: NDArray[np.bool_]
    open: NDArray[np.bool_]
    continued: NDArray[np.bool_]
    ragged: float
    notch: float

    @classmethod
    def guess(cls, points: Array, frame: Array) -> FollowedEdge:
        """An outline (M, 2) that follows no edge, in a photo of the size ``frame``, width and height."""
        at_frame = ((points < 1) | (points > frame - 1)).any(axis=1)
        return cls(points, np.zeros(len(points)), at_frame, ~at_frame, np.zeros(len(points), bool), 0.0, 0.0)

    def along(self, side: StraightSide, factor: int) -> FollowedEdge:
        """The same with what is near a straight side moved onto it; the side's pixels are ``factor`` of these."""
        near = (side.distance(self.points / factor) < _BESIDE_SIDE) & side.alongside(self.points)
        points = np.where(near[:, None], side.nearest(self.points / factor) * factor, self.points)
        strength = np.where(near, np.maximum(self.strength, side.shade), self.strength)
        return FollowedEdge(
            points, strength, self.at_frame, self.open & ~near, self.continued, _ragged_share(points), sharpness(points)
        )

    @property
    def guessed(self) -> bool:
        """Whether it follows no edge anywhere."""
        return not self.strength.any()

    @property
    def doubt(self) -> float:
        """How little of it looks like the paper's edge; 0 if all of it does."""
        places = (self.open | self.continued).mean() + _FRAME_WEIGHT * self.at_frame.mean()
        return float(places + _RAGGED_WEIGHT * self.ragged + _NOTCH_WEIGHT * self.notch)


class ReducedPhoto:
    """A photo in which edges are followed.

    Attributes
    ----------
    linear : (h, w, 3) float32 array
        Linear light.
    factor : int
        Pixels along the side of one reduced pixel.
    lab : (h / factor, w / factor, 3) float32 array
        Perceptual colours.
    gradient : (h / factor, w / factor) float32 array
        Length of the gradient of ``lab``, per pixel.
    """

    def __init__(self, linear: NDArray[np.float32]) -> None:
        self.linear = linear
        self.factor = max(1, round(max(linear.shape) / _COARSE_SIDE))
        self.lab = perceptual(shrink(linear, self.factor))
        self.gradient = gradient_magnitude(self.lab, _GRADIENT_OVER)

    def follow_mask(self, mask: Mask, agreement: float) -> FollowedEdge:
        """The edge along the border of a mask of the reduced photo.

        Whether paper seems to continue beyond it is asked only where the ``agreement`` of the hypotheses on the sheet
        is low.
        """
        border = resample(trace_mask(mask) * self.factor, self.factor)
        return self.follow(ndimage.gaussian_filter1d(border, _SMOOTH, axis=0, mode="wrap"), mask, _REACH, agreement)

    def follow(self, about: Array, mask: Mask, reach: float, agreement: float) -> FollowedEdge:
        """The edge within ``reach`` reduced pixels of a contour (K, 2), full pixels, whose inside is the mask."""
        first = snap(
            self.linear, resample(about, SPACING), reach * self.factor, _STEP, _STIFFNESS, in_linear_light=False
        )
        small = resample(first.points / self.factor, 1.0)
        shorter = self.factor * take_short_cuts(small, self.gradient)
        again = resample(shorter, SPACING)
        edge = snap(self.linear, again, _AGAIN * self.factor, _STEP, _STIFFNESS, in_linear_light=False)
        is_open, continued = edge.strength < _FAINT, np.zeros(len(edge.points), bool)
        if agreement < _CERTAIN:
            inside, outside = self._beside(edge.points)
            continued |= under_print(inside, outside)
            if agreement < _AGREED:
                inside, outside = np.median(inside, axis=1), np.median(outside, axis=1)
                continued |= in_shade(inside, outside)
                within = eroded(mask, _BESIDE[1])
                if within.any():
                    is_open |= unchanged(inside, outside, np.median(self.lab[within] * COLOR_WEIGHTS, axis=0))
        is_open, continued = is_open & ~edge.at_frame, continued & ~edge.at_frame
        ragged, notch = _ragged_share(edge.points), sharpness(edge.points)
        return FollowedEdge(edge.points, edge.strength, edge.at_frame, is_open, continued, ragged, notch)

    def _beside(self, points: Array) -> tuple[Array, Array]:
        """The colours (M, K, 3), weighted, of strips beside a clockwise outline (M, 2): inside and outside."""
        outline = points / self.factor
        offsets = np.arange(*_BESIDE)[None, :, None] * outward_normals(outline, _SMOOTH_NORMALS)[:, None]
        inside, outside = (
            sample_bilinear(self.lab, outline[:, None] + side * offsets) * COLOR_WEIGHTS for side in (-1, 1)
        )
        return inside, outside


def _ragged_share(points: Array) -> float:
    """The share of a closed outline (M, 2) that is ragged."""
    return float((raggedness(points) > _RAGGED).mean())
