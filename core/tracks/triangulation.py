"""Points in space from their places in several photos, robustly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..camera import Camera
from ..numeric.robust import GATE, observation_weight
from ..sparse_model import FEWEST_VIEWS
from .equations import determined

# Rounds, of which the first take the scatter for a pixel; the next estimate it. Choices.
_ROUNDS, _FIRST_ROUNDS = 10, 2
# Pixels: print is found no better than to a few hundredths.
_LEAST_DEVIATION = 0.02
# Median length of a vector whose two coordinates scatter by 1: the square root of 2 ln 2.
_MEDIAN_LENGTH = 1.1774


@dataclass(frozen=True)
class Triangulated:
    """Points with the observations that agree on them.

    Attributes
    ----------
    points : (N, 3) array
        World frame.
    kept : (N, C) bool array
        Which observations are used.
    deviation : float
        Standard deviation of an observation's coordinate, pixels.
    """

    points: Array
    kept: NDArray[np.bool_]
    deviation: float

    @property
    def usable(self) -> NDArray[np.bool_]:
        """Which points (N,) enough photos agree on."""
        return np.asarray(self.kept.sum(axis=1) >= FEWEST_VIEWS)


def triangulate(cameras: Sequence[Camera], observed: Array, start: Array | None = None) -> Triangulated:
    """Find each point from its pixels: linearly, then by Gauss and Newton's method with Cauchy's weights.

    Parameters
    ----------
    cameras : sequence of Camera
    observed : (N, C, 2) array
        Distorted pixels; NaN where a point is not seen.
    start : (N, 3) array, optional
        Points to begin with.
    """
    seen = np.isfinite(observed[..., 0])
    rays = _rays(cameras, observed)
    focal = np.array([camera.focal_length for camera in cameras])
    rotation = np.stack([camera.rotation for camera in cameras])
    translation = np.stack([camera.translation for camera in cameras])
    points = _linear(rays, seen, rotation, translation) if start is None else start.copy()
    deviation = 1.0
    for round_ in range(_ROUNDS + 1):
        in_camera = np.einsum("kij,nj->nki", rotation, points) + translation
        depth = in_camera[..., 2:]
        image = in_camera[..., :2] / depth
        off = (image - rays) * focal[:, None] * seen[..., None]
        length = np.linalg.norm(off, axis=2)
        if round_ >= _FIRST_ROUNDS:
            deviation = scatter(length[seen])
        if round_ == _ROUNDS:
            break
        weight = seen * observation_weight(length, deviation)
        slope = (rotation[None, :, :2] - image[..., None] * rotation[None, :, 2:]) * (focal[:, None] / depth[..., 0:1])[
            ..., None
        ]
        normal = np.einsum("nkri,nk,nkrj->nij", slope, weight, slope, optimize=True)
        right = np.einsum("nkri,nk,nkr->ni", slope, weight, off, optimize=True)
        points = points - np.linalg.solve(determined(normal), right[..., None])[..., 0]
    return Triangulated(points, seen & (length < GATE * deviation), deviation)


def scatter(length: Array) -> float:
    """Standard deviation of a coordinate of observations that lie this far off, pixels."""
    return max(float(np.median(length)) / _MEDIAN_LENGTH, _LEAST_DEVIATION)


def linear_points(cameras: Sequence[Camera], observed: Array) -> Array:
    """Points (N, 3) nearest to all their rays in the algebraic sense; ``observed`` as for `triangulate`."""
    rotation = np.stack([camera.rotation for camera in cameras])
    translation = np.stack([camera.translation for camera in cameras])
    return _linear(_rays(cameras, observed), np.isfinite(observed[..., 0]), rotation, translation)


def _linear(rays: Array, seen: NDArray[np.bool_], rotation: Array, translation: Array) -> Array:
    projection = np.concatenate([rotation, translation[..., None]], axis=2)
    rows = rays[..., None] * projection[None, :, 2:] - projection[None, :, :2]
    rows = rows * seen[..., None, None]
    least = np.linalg.eigh(np.einsum("nkri,nkrj->nij", rows, rows, optimize=True))[1][:, :, 0]
    return np.asarray(least[:, :3] / least[:, 3:])


def _rays(cameras: Sequence[Camera], observed: Array) -> Array:
    """Normalised image coordinates (N, C, 2); of a pixel that is not seen, any."""
    return np.stack([camera.undistort(np.nan_to_num(observed[:, k])) for k, camera in enumerate(cameras)], axis=1)
