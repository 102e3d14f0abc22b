"""The strips of a map just inside and just outside an outline."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..numeric.image import sample_bilinear
from ..numeric.polygon import perimeter, resample, signed_area, smallest_rectangle
from .contour import outward_normals

# The values below are choices; no measurement of them is recorded.
# Cells beside the outline that are looked at.
REACH = 7
# Cells between two places, about how many there are at most, and places over which the outline's normals are smoothed.
_SPACING, _PLACES, _SMOOTH = 2.0, 240, 1.5
# An outline or a side with fewer places says nothing.
_FEWEST_PLACES, _FEWEST_OF_A_SIDE = 20, 4
# The step of colour is looked for within this many cells of the outline; it is that between the means of this many
# cells on either side.
_NEAR, _MEAN_OF = 2, 3
# The step of colour that counts half.
_CLEAR_STEP = 1.0
# Beyond a corner a side is followed from this many cells on, for this part of the mean side within these limits, with
# this spacing; with fewer places on the map it says nothing.
_CLEAR_OF_CORNER, _PART_BEYOND, _BEYOND, _SPACING_BEYOND = 4.0, 0.2, (16.0, 40.0), 2.0
_FEWEST_BEYOND = 4


@dataclass(frozen=True)
class EdgeStrips:
    """The map along an outline; K cells across it, from inside to outside.

    Attributes
    ----------
    places : (M, 2) array
        Map positions along the outline.
    at : (M, K, 2) array
        Map positions across it.
    profile : (M, K, 3) array
        Colours there.
    step : (M, 3) array
        The clearest step of colour near each place, from inside to outside.
    side : (M,) int array
        The nearest of the four sides of the smallest rectangle around the outline.
    rectangle : (4, 2) array
        That rectangle.
    """

    places: Array
    at: Array
    profile: Array
    step: Array
    side: NDArray[np.int64]
    rectangle: Array

    @property
    def inside(self) -> Array:
        """Colours (M, 6, 3) of the strip inside."""
        return self.profile[:, : REACH - 1]

    @property
    def outside(self) -> Array:
        """Colours (M, 5, 3) of the strip outside."""
        return self.profile[:, REACH + 2 :]

    def sides(self) -> list[NDArray[np.bool_]]:
        """The places (M,) of each side that has enough of them."""
        sides = [self.side == side for side in range(4)]
        return [side for side in sides if side.sum() >= _FEWEST_OF_A_SIDE]


def edge_strips(color: NDArray[np.float32], polygon: Array) -> EdgeStrips | None:
    """The strips along a closed polygon (K, 2) of a map (h, w, 3); None if it is too small to be judged."""
    length = perimeter(polygon)
    if length < _FEWEST_PLACES * _SPACING:
        return None
    places = resample(polygon, max(_SPACING, length / _PLACES))
    at = places[:, None] + np.arange(-REACH, REACH + 1.0)[None, :, None] * outward_normals(places, _SMOOTH)[:, None]
    profile = sample_bilinear(color, at).astype(np.float64)
    rectangle = smallest_rectangle(polygon)
    return EdgeStrips(places, at, profile, _steps(profile), _nearest_sides(places, rectangle), rectangle)


def even_steps(step: Array, clear_step: float = _CLEAR_STEP) -> Array:
    """Steps of colour (..., 3) limited to length 1, so that strong print counts no more than a clear edge.

    ``clear_step`` is the step that counts half.
    """
    return np.asarray(step / (np.linalg.norm(step, axis=-1, keepdims=True) + clear_step))


def steps_beyond(color: NDArray[np.float32], corners: Array) -> Array:
    """How the four sides of a quadrilateral continue as edges beyond its corners.

    Parameters
    ----------
    color : (h, w, 3) float32 array
        A map.
    corners : (4, 2) array
        Map positions.

    Returns
    -------
    (4, 2, 3) array
        For each side, before its first corner and beyond its second: the mean of even steps of colour, from the
        quadrilateral's side to the other; its length is 0 without an edge and 1 with a clear one.
    """
    ends = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    along = (ends[:, 1] - ends[:, 0]) / np.maximum(length, 1e-9)[:, None]
    outward = np.sign(signed_area(corners)) * along[:, ::-1] * [1, -1]
    beyond = np.arange(_CLEAR_OF_CORNER, np.clip(_PART_BEYOND * length.mean(), *_BEYOND), _SPACING_BEYOND)
    places = ends[:, :, None] + np.outer([-1, 1], beyond)[..., None] * along[:, None, None]
    across = np.arange(-REACH, REACH + 1.0)[:, None] * outward[:, None, None, None]
    profile = sample_bilinear(color, places[..., None, :] + across).astype(np.float64)
    steps = even_steps(_steps(profile.reshape(-1, *profile.shape[3:]))).reshape(*places.shape[:3], 3)
    on_map = ((places > 0) & (places < [color.shape[1], color.shape[0]])).all(axis=-1)
    count = on_map.sum(axis=2)
    mean = (steps * on_map[..., None]).sum(axis=2) / np.maximum(count, 1)[..., None]
    return np.where((count >= _FEWEST_BEYOND)[..., None], mean, 0)


def _nearest_sides(places: Array, corners: Array) -> NDArray[np.int64]:
    """For each place (M, 2) the nearest of four sides, (M,)."""
    side = np.roll(corners, -1, axis=0) - corners
    offset = places[:, None] - corners
    part = np.clip((offset * side).sum(axis=2) / np.maximum((side**2).sum(axis=1), 1e-9), 0, 1)
    away = offset - part[..., None] * side
    return np.asarray((away**2).sum(axis=2).argmin(axis=1))


def _steps(profile: Array) -> Array:
    """The clearest step of colour (M, 3) near the middle of each profile (M, K, 3), inside to outside."""
    middle = profile.shape[1] // 2
    running = np.pad(np.cumsum(profile, axis=1), ((0, 0), (1, 0), (0, 0)))
    at = middle + np.arange(-_NEAR, _NEAR + 1)
    after = running[:, at + 1 + _MEAN_OF] - running[:, at + 1]
    before = running[:, at] - running[:, at - _MEAN_OF]
    steps = (after - before) / _MEAN_OF
    best = (steps**2).sum(axis=2).argmax(axis=1)
    return np.asarray(steps[np.arange(len(steps)), best])
