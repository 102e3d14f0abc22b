"""Sharp inward corners of an outline, as where one paper lies upon another, and the parts of it that meet there."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np
from scipy import ndimage

from ..arrays import Array
from ..numeric.morphology import Mask
from ..numeric.polygon import direction_of, perimeter, resample

# Values without a figure are choices; no measurement of them is recorded.
_PLACES = 200  # along an outline, at which it may turn
# Places before and after a corner between which it turns, and the first and the last that tell a side's direction.
_ARM, _SIDE = 6, (2, 12)
# Degrees. Of 268 true outlines of 36 generated scenes (seeds 1000 to 1035), bent and seen at a slant, the sharpest
# inward corner turns by 55, and one in twenty by more than 32. Where papers overlap it turns by 60 to 100.
_BLUNT, _SHARP = 45.0, 75.0
_SHARPEST = 2  # inward corners at which an outline is cut, at most
# Shares of a region that a cut takes off at least, and leaves at least.
_LEAST_CUT, _LEAST_LEFT = 0.02, 0.4


@dataclass(frozen=True)
class Notch:
    """A sharp inward corner of a clockwise outline.

    Attributes
    ----------
    place : (2,) array
    before, after : (2,) array
        Directions of length 1 of the sides that end and begin there, along the outline.
    degrees : float
        By how much the outline turns to the left.
    """

    place: Array
    before: Array
    after: Array
    degrees: float


def notches(outline: Array) -> list[Notch]:
    """The inward corners of a closed clockwise outline (K, 2) that no folded sheet has, the sharpest first."""
    points, turn = _turns(outline)
    sharp = (turn > _BLUNT) & (turn == ndimage.maximum_filter1d(turn, 2 * _ARM + 1, mode="wrap"))
    found = []
    for index in np.flatnonzero(sharp):
        near, far = _SIDE
        before = points[(index - np.arange(far, near - 1, -1)) % _PLACES]
        after = points[(index + np.arange(near, far + 1)) % _PLACES]
        found.append(Notch(points[index], direction_of(before), direction_of(after), float(turn[index])))
    return sorted(found, key=lambda notch: -notch.degrees)


def sharpness(outline: Array) -> float:
    """How sharp the sharpest inward corner of a closed clockwise outline (K, 2) is: 0 as a fold's, 1 as of two papers.

    Examples
    --------
    A square, and one to which half of another is joined:

    >>> square = np.array([[0.0, 0], [40, 0], [40, 40], [0, 40]])
    >>> joined = np.array([[0.0, 0], [40, 0], [40, 20], [80, 20], [80, 40], [0, 40]])
    >>> sharpness(square), sharpness(joined)
    (0.0, 1.0)
    """
    _, turn = _turns(outline)
    return float(np.clip((turn.max() - _BLUNT) / (_SHARP - _BLUNT), 0, 1))


def cut_at_notches(mask: Mask, outline: Array) -> list[Mask]:
    """What a region (h, w) may be without another paper beside it.

    At an inward corner one paper's side ends at the other's, and goes on straight between the two, where it hardly
    shows. The region is cut there: along each side that meets such a corner, and along two of different corners.

    Parameters
    ----------
    mask : (h, w) bool array
    outline : (K, 2) array
        Its outline, clockwise, in the same pixels.
    """
    off = [
        (_beyond(mask, each.place, each.before), _beyond(mask, each.place, each.after))
        for each in notches(outline)[:_SHARPEST]
    ]
    both = [end | start for (end, _), (_, start) in permutations(off, 2)]
    parts = [mask & ~each for each in (*(end for end, _ in off), *(start for _, start in off), *both)]
    size = mask.sum()
    return [part for part in parts if _LEAST_LEFT * size < part.sum() < (1 - _LEAST_CUT) * size]


def _turns(outline: Array) -> tuple[Array, Array]:
    """Places (P, 2) along a clockwise outline, and the degrees (P,) by which it turns to the left there."""
    points = resample(outline, perimeter(outline) / _PLACES)
    into, out = points - np.roll(points, _ARM, axis=0), np.roll(points, -_ARM, axis=0) - points
    cross = into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0]
    return points, -np.degrees(np.arctan2(cross, (into * out).sum(axis=1)))


def _beyond(mask: Mask, place: Array, direction: Array) -> Mask:
    """The part of a region to the left of a line through a place on its outline, as far as it hangs together there."""
    rows, columns = np.indices(mask.shape) + 0.5
    left = mask & (direction[0] * (rows - place[1]) - direction[1] * (columns - place[0]) < 0)
    parts, count = ndimage.label(left)
    if not count:
        return left
    away = np.hypot(rows - place[1], columns - place[0])
    nearest = np.asarray(ndimage.minimum(away, parts, np.arange(1, count + 1)))
    return np.asarray(parts == 1 + int(nearest.argmin()))
