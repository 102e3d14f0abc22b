"""Measure heights by sweeping a plane through the scene.

At the height of a surface, all photos show the same (Collins, "A space-sweep approach to true multi-image
matching", CVPR 1996). Structure from motion finds points only in print and grain; the sweep also finds the edges of
blank paper, and so where a sheet is folded up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import perceptual, shrink
from ..numeric.peaks import peak_offset
from ..sparse_model import FEWEST_VIEWS
from .ground_frame import GroundFrame
from .views import pixels_per_cell, seen

# Cells between two places, and between two heights: as much as two photos from 45 degrees apart shift by.
_STEP = 3
# Photos are sampled at this many pixels between two places.
_PIXELS = 2
# Standard deviations between which detail is, and the side of the squares in which photos are compared. In places;
# chosen with those below.
_DETAIL, _BLUR, _SQUARE = 6.0, 0.3, 5
# A place has a surface where the photos agree to this part, by this much better than at all heights except the next so
# many, on detail of this strength, squared levels of lightness (0 to 100); noise of this strength reduces agreement.
# Chosen by eye on five tuning scenes.
_AGREED, _CLEARLY, _NEXT = 0.6, 0.1, 2
_LEAST_DETAIL, _NOISE = 0.3, 0.3
# From this many photos on the best height must be better by this much without the oddest of them too. On a drawn scene
# a patch in one photo of 6 to 8 changes 0.4 to 0.8 % of the map at 0.03, and in one of 5, unchecked, 2.7 %; at 0.1 one
# side of a blank folded sheet gives no samples in 6 or 7 photos.
_ONE_ODD, _STILL_CLEARLY = 6, 0.03
# This many places that touch, at levels that touch, make a surface: more than the square that one feature alone
# reaches.
_COMPANY = 30
# Pixels are projected at this many heights, and interpolated between, because they move nearly straight with the
# height.
_EXACT = 7


def swept_samples(
    cameras: Sequence[Camera],
    photos: Sequence[NDArray[np.float32]],
    frame: GroundFrame,
    corner: Array,
    cell: float,
    shape: tuple[int, int],
    highest: int,
) -> Array:
    """Points on surfaces, at most one for each square of a few cells.

    Parameters
    ----------
    cameras : sequence of Camera
    photos : sequence of (h, w, 3) float32 arrays
        One for each camera: linear light, as `image.reduced` gives it.
    frame : GroundFrame
    corner : (2,) array
        Right and down, world units of the frame, of the first corner of the map that is searched.
    cell : float
        Side of a cell, world units.
    shape : (int, int)
        Rows and columns of the map.
    highest : int
        Largest distance of surfaces above and below the plane, cells.

    Returns
    -------
    (N, 3) array
        Right, down and height in the frame, world units.
    """
    grid = shape[0] // _STEP, shape[1] // _STEP
    row, column = np.indices(grid)
    places = (np.stack([column, row], axis=-1) + 0.5) * _STEP * cell + corner
    levels = np.arange(-(highest // _STEP), highest // _STEP + 1) * _STEP * cell
    used, shown = _shown(cameras, photos, frame, places, levels, _STEP * cell)
    agreement, detail = shown.agreement(used)
    best = agreement.argmax(axis=0)
    fewer, _ = shown.without_the_oddest().agreement(used)
    clear = _at(agreement, best) > np.maximum(_AGREED, _second(agreement, best) + _CLEARLY)
    clear &= _at(fewer, best) > _second(fewer, best) + _STILL_CLEARLY
    clear &= (_at(detail, best) > _LEAST_DETAIL) & (best > 0) & (best < len(levels) - 1)
    clear = in_company(clear, best, len(levels))
    best = best[clear]
    offset = np.clip(peak_offset(*(_at(agreement[:, clear], best + step) for step in (-1, 0, 1))), -0.5, 0.5)
    return np.column_stack([places[clear], levels[best] + offset * (levels[1] - levels[0])])


@dataclass(frozen=True)
class _Shown:
    """Sums of what the photos show at L heights of M places: (L, M) arrays."""

    total: NDArray[np.float32]
    squares: NDArray[np.float32]
    count: NDArray[np.float32]
    lowest: NDArray[np.float32]
    highest: NDArray[np.float32]

    @classmethod
    def nothing(cls, shape: tuple[int, int]) -> _Shown:
        return cls(*(np.full(shape, value, np.float32) for value in (0, 0, 0, np.inf, -np.inf)))

    def add(self, level: int, value: NDArray[np.float32], there: NDArray[np.bool_]) -> None:
        """A photo's values (M,) at a height, where it shows the places."""
        for each, addend in ((self.total, value), (self.squares, value**2), (self.count, np.float32(1))):
            np.add(each[level], addend, out=each[level], where=there)
        np.minimum(self.lowest[level], value, out=self.lowest[level], where=there)
        np.maximum(self.highest[level], value, out=self.highest[level], where=there)

    def without_the_oddest(self) -> _Shown:
        """Without the value furthest from the mean, if there are enough others: it may be a hand or a reflection."""
        more = self.count >= _ONE_ODD
        lowest, highest = (np.where(more, each, 0) for each in (self.lowest, self.highest))
        odd = np.where(2 * self.total > self.count * (lowest + highest), lowest, highest)
        return replace(self, total=self.total - odd, squares=self.squares - odd**2, count=self.count - more)

    def agreement(self, used: NDArray[np.bool_]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """How well the photos agree, 0 to 1, and how strong detail is, (L, h, w), at the M places ``used`` (h, w)."""
        mean = self.total / np.maximum(self.count, 1)
        variance = (self.squares - self.total * mean) / np.maximum(self.count - 1, 1)
        common, apart = np.zeros((2, len(mean), *used.shape), np.float32)
        common[:, used] = np.where(self.count >= FEWEST_VIEWS, mean**2, 0)
        apart[:, used] = np.where(self.count >= FEWEST_VIEWS, variance, 0)
        common, apart = (ndimage.uniform_filter(values, (0, _SQUARE, _SQUARE)) for values in (common, apart))
        return common / (common + apart + _NOISE), common


def _shown(
    cameras: Sequence[Camera],
    photos: Sequence[NDArray[np.float32]],
    frame: GroundFrame,
    places: Array,
    levels: Array,
    spacing: float,
) -> tuple[NDArray[np.bool_], _Shown]:
    """Which places (h, w, 2) enough photos show, and what the photos show there at each of the heights (L,)."""
    exact = np.linspace(levels[0], levels[-1], _EXACT)
    surface = np.stack([frame.to_world(np.dstack([places, np.full(places.shape[:2], height)])) for height in exact])
    pixels = [seen(camera, surface) for camera in cameras]
    # at the middle height
    used = np.sum([np.isfinite(each[_EXACT // 2, ..., 0]) for each in pixels], axis=0) >= FEWEST_VIEWS
    shown = _Shown.nothing((len(levels), int(used.sum())))
    for camera, photo, each in zip(cameras, photos, pixels, strict=True):
        fine, scale = _detail(photo, camera, pixels_per_cell(camera, frame, spacing))
        at_exact = (each[:, used] / scale).astype(np.float32)
        for level, at in enumerate(np.linspace(0, _EXACT - 1, len(levels))):
            first = min(int(at), _EXACT - 2)
            x, y = (at_exact[first] + np.float32(at - first) * (at_exact[first + 1] - at_exact[first])).T
            there = np.isfinite(x)
            shown.add(level, fine[_index(y, there, fine.shape[0]), _index(x, there, fine.shape[1])], there)
    return used, shown


def _index(pixel: NDArray[np.float32], shown: NDArray[np.bool_], length: int) -> NDArray[np.int32]:
    """Row or column of a picture; arbitrary where nothing is shown."""
    return np.minimum(np.where(shown, pixel, 0).astype(np.int32), length - 1)


def _detail(photo: NDArray[np.float32], camera: Camera, spacing: float) -> tuple[NDArray[np.float32], int]:
    """The detail of a reduced photo's lightness, and the width of its pixels in pixels of the camera.

    ``spacing`` pixels of the camera lie between two places.
    """
    reduction = round(camera.width / photo.shape[1])
    factor = max(1, round(spacing / reduction / _PIXELS))
    lightness = perceptual(shrink(photo, factor))[..., 0]
    place = spacing / (factor * reduction)
    fine = ndimage.gaussian_filter(lightness, _BLUR * place) - ndimage.gaussian_filter(lightness, _DETAIL * place)
    return fine, factor * reduction


def in_company(clear: NDArray[np.bool_], best: NDArray[np.int64], levels: int) -> NDArray[np.bool_]:
    """The places (h, w) that have enough others beside them at about their level; reflections do not."""
    volume = np.zeros((levels, *clear.shape), bool)
    row, column = np.nonzero(clear)
    volume[best[clear], row, column] = True
    label, _ = ndimage.label(volume, np.ones((3, 3, 3)))
    group = label[best[clear], row, column]
    result = np.zeros_like(clear)
    result[clear] = np.bincount(group)[group] >= _COMPANY
    return result


def _at(values: NDArray[np.float32], level: NDArray[np.int64]) -> NDArray[np.float32]:
    """Values (L, ...) at a level of each place (...)."""
    return np.asarray(np.take_along_axis(values, level[None], axis=0)[0])


def _second(values: NDArray[np.float32], best: NDArray[np.int64]) -> NDArray[np.float32]:
    """The largest of the values (L, h, w), at least 0, apart from each place's best level and those next to it."""
    away = np.abs(np.arange(len(values))[:, None, None] - best)
    return np.asarray(np.where(away > _NEXT, values, 0).max(axis=0))
