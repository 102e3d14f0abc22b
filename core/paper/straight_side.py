"""Find a straight side along which paper lies on both sides, such as the gutter of a book, by its faint shade."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..numeric.image import sample_bilinear
from ..numeric.morphology import Mask
from ..numeric.polygon import direction_of

# Values without a figure are choices; no measurement of them is recorded.
# The shortest stretch of open outline that may be a side, as a part of the outline: a short side of a long receipt has
# a tenth.
_SHORTEST_SIDE = 0.08
# Gaps in the stretch, where print makes an edge, up to this part of the outline do not end it.
_GAP = 0.03
# How far from the stretch the side is looked for, as a part of the sheet's side. The outline of a generated book that
# follows the first letters of its lines is off the gutter by up to .06.
_REACH = 0.12
# A stretch of which this share is not that near to its own straight line turns a corner.
_WITHIN_REACH = 0.8
# Places along the side at which the shade is measured, and step between lines across it, pixels.
_PLACES, _STEP = 96, 1.0
# The shade is the median of strips beside the line, from and to this many pixels off it: beside a step, and beside a
# valley, whose middle is as wide. A ruled line is narrower than half a strip, so it has no shade.
_BESIDE_STEP, _BESIDE_VALLEY, _MIDDLE = (0.5, 4.5), (4.0, 8.0), 2.0
# A valley counts this many times: each of its flanks is a step, off its middle.
_VALLEY_WEIGHT = 1.5
# The shade is the one that all but this part of the side exceeds, because print hides the rest.
_HIDDEN = 0.25
# An outline's tangents are taken over this many of its points (standard deviation), and run along the side from this
# cosine on: the upper edge of a book's page turns into the gutter within a few pixels.
_TANGENT, _PARALLEL = 4.0, 0.85
# The least shade of a side, Oklab times 100.
_LEAST_SHADE = 0.8


@dataclass(frozen=True)
class StraightSide:
    """A straight side of a sheet in a photo.

    Attributes
    ----------
    ends : (2, 2) array
        Pixels, in the direction of the clockwise outline: the sheet lies to the right of it on screen.
    stretch : (K, 2) array
        The part of an outline, in order, in whose place it is.
    shade : float
        How much darker or brighter the line or its other side is nearly all along it, Oklab times 100.
    """

    ends: Array
    stretch: Array
    shade: float

    def between(self) -> Array:
        """What lies between it and the stretch, a polygon (2 K, 2)."""
        return np.concatenate([self.stretch, self.nearest(self.stretch)[::-1]])

    def beyond(self, shape: tuple[int, ...]) -> Mask:
        """The pixels (h, w) on its other side."""
        (x, y), (dx, dy) = self.ends[0], self._direction()
        rows, columns = np.indices(shape) + 0.5
        return np.asarray(dx * (rows - y) - dy * (columns - x) < 0)

    def nearest(self, points: Array) -> Array:
        """The places (N, 2) on its line that are nearest to points (N, 2)."""
        along = self._direction()
        return np.asarray(self.ends[0] + ((points - self.ends[0]) @ along)[:, None] * along)

    def alongside(self, outline: Array) -> NDArray[np.bool_]:
        """Which places of a closed outline (N, 2), evenly spaced, run about as the line does."""
        tangent = ndimage.gaussian_filter1d(outline, _TANGENT, axis=0, order=1, mode="wrap")
        return np.asarray(tangent @ self._direction() > _PARALLEL * np.linalg.norm(tangent, axis=1))

    def distance(self, points: Array) -> Array:
        """Of points (N, 2) from its line."""
        return np.asarray(np.linalg.norm(points - self.nearest(points), axis=1))

    def _direction(self) -> Array:
        span = self.ends[1] - self.ends[0]
        return np.asarray(span / np.linalg.norm(span))


def longest_stretch(marked: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Indices, in order, of the longest run of marked places of a closed outline; short gaps do not end it."""
    count = len(marked)
    at = np.flatnonzero(marked)
    if not len(at) or len(at) == count:
        return at
    gaps = np.diff(np.append(at, at[0] + count))
    breaks = np.flatnonzero(gaps > max(round(_GAP * count), 1))
    if not len(breaks):
        return at
    starts, stops = at[(np.roll(breaks, 1) + 1) % len(at)], at[breaks]
    lengths = (stops - starts) % count + 1
    longest = int(lengths.argmax())
    return np.asarray((starts[longest] + np.arange(lengths[longest])) % count)


def straight_side(
    lightness: NDArray[np.float32], outline: Array, open_part: NDArray[np.bool_], size: float
) -> StraightSide | None:
    """The straight side near the longest open stretch of an outline; None if there is none.

    The gutter of a book is a step or a valley of shade from one edge of the paper to the other. Print beside it has a
    stronger edge, but not all along a line.

    Parameters
    ----------
    lightness : (h, w) array
        Oklab times 100.
    outline : (M, 2) array
        Pixels, evenly spaced, clockwise.
    open_part : (M,) bool array
        Where paper goes on beyond the outline, or there is no edge.
    size : float
        Side of the sheet, pixels: the square root of its area.
    """
    stretch = longest_stretch(open_part)
    if len(stretch) < _SHORTEST_SIDE * len(outline):
        return None
    points = outline[stretch]
    center = points.mean(axis=0)
    along = direction_of(points)
    outwards = np.array([along[1], -along[0]])
    reach = (points - center) @ along
    off = np.abs((points - center) @ outwards)
    if np.quantile(off, _WITHIN_REACH) > _REACH * size:
        return None  # it turns a corner
    half = np.arange(0, _REACH * size, _STEP)
    offsets = np.concatenate([-half[:0:-1], half])
    places = center + np.linspace(reach.min(), reach.max(), _PLACES)[:, None] * along
    shades = _shades(lightness, places, offsets, outwards)
    # lines from each offset at one end to each at the other
    share = np.linspace(0, 1, _PLACES)[:, None, None]
    index = np.arange(len(offsets))
    at = np.rint((1 - share) * index[:, None] + share * index).astype(int)
    best = max(
        (np.quantile(shade[np.arange(_PLACES)[:, None, None], at], _HIDDEN, axis=0) for shade in shades),
        key=lambda each: float(each.max()),
    )
    first, last = np.unravel_index(int(best.argmax()), best.shape)
    shade = float(best[first, last])
    if shade < _LEAST_SHADE:
        return None
    ends = np.stack([places[0] + offsets[first] * outwards, places[-1] + offsets[last] * outwards])
    return StraightSide(ends, points, shade)


def _shades(lightness: NDArray[np.float32], places: Array, offsets: Array, outwards: Array) -> list[Array]:
    """How strong a step to the dark, a step to the bright, and a valley are (K, O) at places and offsets from them."""

    def strip(first: float, last: float) -> Array:
        off = offsets[:, None] + np.arange(first, last + 1)
        at = places[:, None, None] + off[..., None] * outwards
        return np.asarray(np.median(sample_bilinear(lightness[..., None], at)[..., 0], axis=-1))

    def beside(near: float, far: float) -> tuple[Array, Array]:
        return strip(near, far), strip(-far, -near)

    outside, inside = beside(*_BESIDE_STEP)
    valley = np.minimum(*beside(*_BESIDE_VALLEY)) - strip(-_MIDDLE, _MIDDLE)
    return [inside - outside, outside - inside, _VALLEY_WEIGHT * valley]
