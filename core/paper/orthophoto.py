"""The scene from straight above, joined from all photos: where paper and table are looked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import perceptual, sample_bilinear, shrink
from ..numeric.polygon import inside_polygon
from ..sparse_model import SparseModel
from .ground_frame import GroundFrame, footprint, ground_frame
from .height_map import Stiffness, height_map
from .plane_sweep import swept_samples
from .reference_view import prominence
from .views import pixels_per_cell, seen

# Values without a figure are choices; no measurement of them is recorded.
# Cells along what the long side of a typical photo shows.
_CELLS_PER_PHOTO = 450
# The map reaches this far from its middle, in long sides of what a typical photo shows.
_REACH = 0.85
# Exposures are compared where this many photos overlap, on this many cells at least, in this many rounds, and changed
# by factors between these: others are not exposure. Choices; no measurement of them is recorded.
_MIN_COVERAGE, _FEWEST_COMMON, _ROUNDS = 2, 100, 2
_LEAST_GAIN, _MOST_GAIN = 0.3, 3.0
# Surfaces are looked for up to this many cells above and below the plane: half an A4 sheet, folded up by 45 degrees, in
# a photo of which it fills two thirds. Anything further off is neither the sheet nor its table.
_HIGHEST = 120
# Cells darker than this (of 100) say nothing about a photo's exposure.
_DARK = 15.0
# Exposure is matched on every so many rows and columns.
_SPARSE = 4
# This many samples make a surface of their own.
_FEWEST_SAMPLES = 12
# Far from all points, the surface of the scene becomes level within some nodes; that of a sheet continues straight.
_SCENE = Stiffness(nodes=60, tension=0.004, pull=0.0004)
_SHEET = Stiffness(nodes=60, tension=0.0005, pull=1e-6)


@dataclass(frozen=True)
class Orthophoto:
    """A map of the scene, seen at right angles to the main plane.

    Cell ``(row, column)`` has its centre at the map position ``(column + 0.5, row + 0.5)``.

    Attributes
    ----------
    frame : GroundFrame
    corner : (2,) array
        Right and down, in world units of the frame, of the map's first corner.
    cell : float
        Side of a cell, world units.
    height : (h, w) array
        Of the surface above the frame's plane, world units.
    samples : (N, 3) array
        Right, down and height, in the frame, of points on surfaces: those of the model seen in three photos, and those
        found by sweeping a plane. Some are outside the map.
    color : (h, w, 3) float32 array
        Oklab times 100, the median over the photos that show the cell.
    coverage : (h, w) int array
        How many photos show the cell.
    disagreement : (h, w) float32 array
        Median distance of the photos' colours from ``color``: large where the cell's surface is elsewhere.
    """

    frame: GroundFrame
    corner: Array
    cell: float
    height: Array
    samples: Array
    color: NDArray[np.float32]
    coverage: NDArray[np.int64]
    disagreement: NDArray[np.float32]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.coverage.shape[0], self.coverage.shape[1]

    @property
    def known(self) -> NDArray[np.bool_]:
        """Which cells (h, w) enough photos show."""
        return self.coverage >= _MIN_COVERAGE

    def from_world(self, points: Array) -> Array:
        """Map positions (..., 2) of world points (..., 3)."""
        return (self.frame.from_world(points)[..., :2] - self.corner) / self.cell

    def to_world(self, positions: Array) -> Array:
        """World points (..., 3) of the surface at map positions (..., 2)."""
        height = sample_bilinear(self.height[..., None], positions)
        return self.frame.to_world(np.concatenate([positions * self.cell + self.corner, height], axis=-1))

    def on_sheet(self, polygon: Array) -> Orthophoto:
        """The same map with the surface of the samples within a polygon (K, 2) of map positions, if they are enough."""
        samples = self.samples[inside_polygon((self.samples[:, :2] - self.corner) / self.cell, polygon)]
        if len(samples) < _FEWEST_SAMPLES:
            return self
        return replace(self, height=height_map(samples, self.corner, self.cell, self.shape, _SHEET))


def orthophoto(model: SparseModel, photos: Sequence[NDArray[np.float32]]) -> Orthophoto:
    """Join all photos to one view from straight above.

    Parameters
    ----------
    model : SparseModel
    photos : sequence of (h, w, 3) float32 arrays
        One for each camera of the model: linear light, as `image.reduced` gives it.
    """
    weight = prominence(model)
    frame = ground_frame(model, weight)
    cell = float(np.median([footprint(camera, frame) for camera in model.cameras])) / _CELLS_PER_PHOTO
    cells = round(2 * _REACH * _CELLS_PER_PHOTO)
    corner = np.full(2, -0.5 * cells * cell)
    local = frame.from_world(model.points[weight > 0])
    swept = swept_samples(model.cameras, photos, frame, corner, cell, (cells, cells), _HIGHEST)
    samples = np.concatenate([local[np.abs(local[:, 2]) < _HIGHEST * cell], swept])
    height = height_map(samples, corner, cell, (cells, cells), _SCENE)
    return _joined(model.cameras, photos, frame, corner, cell, height, samples)


def _joined(
    cameras: Sequence[Camera],
    photos: Sequence[NDArray[np.float32]],
    frame: GroundFrame,
    corner: Array,
    cell: float,
    height: Array,
    samples: Array,
) -> Orthophoto:
    """The map at given heights (h, w) of its cells, cut to what enough photos show."""
    down, right = (np.arange(length) * cell + 0.5 * cell for length in height.shape)
    right, down = np.meshgrid(right + corner[0], down + corner[1])
    surface = frame.to_world(np.stack([right, down, height], axis=-1))
    pixels = [seen(camera, surface) for camera in cameras]
    shown = np.stack([np.isfinite(each[..., 0]) for each in pixels])
    rows, columns = _extent(shown.sum(axis=0) >= _MIN_COVERAGE)
    shown = shown[:, rows, columns]
    colors = np.stack(
        [
            _colors(camera, photo, each[rows, columns], frame, cell)
            for camera, photo, each in zip(cameras, photos, pixels, strict=True)
        ]
    )
    color, disagreement = _join(colors, shown)
    return Orthophoto(
        frame,
        corner + np.array([columns.start, rows.start]) * cell,
        cell,
        height[rows, columns],
        samples,
        color,
        shown.sum(axis=0),
        disagreement,
    )


def _extent(mask: NDArray[np.bool_]) -> tuple[slice, slice]:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return slice(0, mask.shape[0]), slice(0, mask.shape[1])
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


def _colors(
    camera: Camera, photo: NDArray[np.float32], pixels: Array, frame: GroundFrame, cell: float
) -> NDArray[np.float32]:
    """Colours (h, w, 3) of a reduced photo at full pixels (h, w, 2), Oklab times 100; NaN outside it."""
    reduction = round(camera.width / photo.shape[1])
    factor = max(1, round(pixels_per_cell(camera, frame, cell) / reduction))
    small = perceptual(shrink(photo, factor))
    shown = np.isfinite(pixels[..., 0])
    colors = np.full((*shown.shape, 3), np.nan, np.float32)
    colors[shown] = sample_bilinear(small, pixels[shown] / (factor * reduction))
    return colors


def _join(colors: NDArray[np.float32], shown: NDArray[np.bool_]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Median colour and median distance from it, after each photo's exposure and white balance are matched."""
    some = (slice(None), slice(None, None, _SPARSE), slice(None, None, _SPARSE))
    for _ in range(_ROUNDS):
        few, count = colors[some], shown[some].sum(axis=0)
        joined = _median(few, count)
        for index, visible in enumerate(shown[some]):
            common = visible & (count >= _MIN_COVERAGE) & (joined[..., 0] > _DARK)
            if common.sum() < _FEWEST_COMMON:
                continue
            gain = np.median(few[index][common][:, 0] / joined[common][:, 0])
            colors[index] /= np.clip(gain, _LEAST_GAIN, _MOST_GAIN)
            colors[index][..., 1:] -= np.median((few[index] - joined)[common][:, 1:], axis=0)
    count = shown.sum(axis=0)
    joined = _median(colors, count)
    off = np.sqrt(((colors - joined) ** 2).sum(axis=-1))
    return np.nan_to_num(joined), np.nan_to_num(_median(off, count))


def _median(values: NDArray[np.float32], count: NDArray[np.int64]) -> NDArray[np.float32]:
    """Median over the first axis, of which ``count`` are not NaN."""
    ordered = np.sort(values, axis=0)
    count = count.reshape(count.shape + (1,) * (values.ndim - 3))
    lower, upper = np.maximum(count - 1, 0) // 2, np.minimum(count // 2, len(values) - 1)
    low, high = (
        np.take_along_axis(ordered, np.broadcast_to(at, values.shape[1:])[None], axis=0)[0] for at in (lower, upper)
    )
    return np.asarray(0.5 * (low + high))
