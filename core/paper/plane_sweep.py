"""Heights of what the photos show, by sweeping a plane through the scene.

At the height of a surface all photos show the same there (Collins, "A space-sweep approach to true multi-image
matching", CVPR 1996). Structure from motion finds points in print and grain only; the sweep finds the edges of blank
paper as well, and with them where a sheet is folded up.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import perceptual, shrink
from .ground_frame import GroundFrame
from .views import pixels_per_cell, seen

# Cells between two places, and between two heights: as much as two photos from 45 degrees apart shift by.
_STEP = 3
# Photos are read at so many pixels between two places.
_PIXELS = 2
# Detail is finer than the one of these and coarser than the other; photos are compared in squares of this side. Places.
_DETAIL, _BLUR, _SQUARE = 6.0, 0.3, 5
# Photos that must show a place.
_FEWEST_PHOTOS = 3
# A place has a surface where the photos agree to this part, by this much better than at all heights but the next ones,
# on detail of this strength, squared levels of lightness (0 to 100); noise of this strength takes away from agreement.
_AGREED, _CLEARLY, _NEXT = 0.6, 0.1, 2
_LEAST_DETAIL, _NOISE = 0.3, 0.3
# Pixels are projected at so many heights, and interpolated between.
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
    """Points on surfaces, at most one on each square of some cells.

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
        Cells above and below the plane up to which surfaces are looked for.

    Returns
    -------
    (N, 3) array
        Right, down and height in the frame, world units.
    """
    grid = shape[0] // _STEP, shape[1] // _STEP
    row, column = np.indices(grid)
    places = (np.stack([column, row], axis=-1) + 0.5) * _STEP * cell + corner
    levels = np.arange(-(highest // _STEP), highest // _STEP + 1) * _STEP * cell
    agreement, detail = _compared(cameras, photos, frame, places, levels, _STEP * cell)
    best = agreement.argmax(axis=0)
    away = np.abs(np.arange(len(levels))[:, None, None] - best)
    second = np.where(away > _NEXT, agreement, 0).max(axis=0)
    most, strength = (np.take_along_axis(each, best[None], axis=0)[0] for each in (agreement, detail))
    clear = (most > _AGREED) & (most - second > _CLEARLY) & (strength > _LEAST_DETAIL)
    clear &= (best > 0) & (best < len(levels) - 1)
    height = levels[best[clear]] + _to_peak(agreement[:, clear], best[clear]) * (levels[1] - levels[0])
    return np.column_stack([places[clear], height])


def _compared(
    cameras: Sequence[Camera],
    photos: Sequence[NDArray[np.float32]],
    frame: GroundFrame,
    places: Array,
    levels: Array,
    spacing: float,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """At each of L heights, for each place (h, w, 2): how far the photos agree, 0 to 1, and on how strong a detail."""
    exact = np.linspace(levels[0], levels[-1], _EXACT)
    surface = np.stack([frame.to_world(np.dstack([places, np.full(places.shape[:2], height)])) for height in exact])
    pixels = [seen(camera, surface) for camera in cameras]
    # at the middle height
    used = np.sum([np.isfinite(each[_EXACT // 2, ..., 0]) for each in pixels], axis=0) >= _FEWEST_PHOTOS
    total, squares, count = (np.zeros((len(levels), used.sum()), np.float32) for _ in range(3))
    for camera, photo, each in zip(cameras, photos, pixels, strict=True):
        fine, scale = _detail(photo, camera, pixels_per_cell(camera, frame, spacing))
        at_exact = (each[:, used] / scale).astype(np.float32)
        for level, at in enumerate(np.linspace(0, _EXACT - 1, len(levels))):
            first = min(int(at), _EXACT - 2)
            x, y = (at_exact[first] + np.float32(at - first) * (at_exact[first + 1] - at_exact[first])).T
            shown = np.isfinite(x)
            inside = _index(y, shown, fine.shape[0]), _index(x, shown, fine.shape[1])
            value = np.where(shown, fine[inside], 0)
            total[level] += value
            squares[level] += value**2
            count[level] += shown
    mean = total / np.maximum(count, 1)
    enough = count >= _FEWEST_PHOTOS
    common, apart = np.zeros((2, len(levels), *used.shape), np.float32)
    common[:, used] = np.where(enough, mean**2, 0)
    apart[:, used] = np.where(enough, (squares - total * mean) / np.maximum(count - 1, 1), 0)
    common, apart = (ndimage.uniform_filter(values, (0, _SQUARE, _SQUARE)) for values in (common, apart))
    return common / (common + apart + _NOISE), common


def _index(pixel: NDArray[np.float32], shown: NDArray[np.bool_], length: int) -> NDArray[np.int32]:
    """Row or column of a picture; any where nothing is shown."""
    return np.minimum(np.where(shown, pixel, 0).astype(np.int32), length - 1)


def _detail(photo: NDArray[np.float32], camera: Camera, spacing: float) -> tuple[NDArray[np.float32], int]:
    """What stands out from the lightness of a reduced photo, and how many pixels of the camera its pixels are wide.

    ``spacing`` pixels of the camera lie between two places.
    """
    reduction = round(camera.width / photo.shape[1])
    factor = max(1, round(spacing / reduction / _PIXELS))
    lightness = perceptual(shrink(photo, factor))[..., 0]
    place = spacing / (factor * reduction)
    fine = ndimage.gaussian_filter(lightness, _BLUR * place) - ndimage.gaussian_filter(lightness, _DETAIL * place)
    return fine, factor * reduction


def _to_peak(values: Array, best: NDArray[np.int64]) -> Array:
    """From the best level of each of N columns (L, N) to the peak of a parabola through its neighbours, in levels."""
    below, peak, above = (np.take_along_axis(values, (best + step)[None], axis=0)[0] for step in (-1, 0, 1))
    return np.asarray(np.clip(0.5 * (below - above) / np.minimum(below - 2 * peak + above, -1e-6), -0.5, 0.5))
