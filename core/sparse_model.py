"""What structure from motion knows: cameras, points, and who saw which point where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .camera import Array, Camera


@dataclass(frozen=True)
class SparseModel:
    """Posed cameras and triangulated points in one world frame of unknown scale.

    Attributes
    ----------
    cameras : tuple of Camera
        One for each photo that could be placed.
    points : (N, 3) array
        World frame.
    colors : (N, 3) uint8 array
        sRGB.
    observed_point, observed_camera : (M,) int arrays
        Observation ``m`` is of point ``observed_point[m]`` in camera ``observed_camera[m]``.
    observed_pixel : (M, 2) array
        Where it was seen, in distorted pixels.
    """

    cameras: tuple[Camera, ...]
    points: Array
    colors: NDArray[np.uint8]
    observed_point: NDArray[np.int64]
    observed_camera: NDArray[np.int64]
    observed_pixel: Array

    def views_per_point(self) -> NDArray[np.int64]:
        """Number of photos that saw each point, shape (N,)."""
        return np.bincount(self.observed_point, minlength=len(self.points))

    def select(self, keep: NDArray[np.bool_]) -> SparseModel:
        """The model with only the points where ``keep`` (N,) is true; all cameras stay."""
        index = np.cumsum(keep) - 1
        seen = keep[self.observed_point]
        return SparseModel(
            self.cameras,
            self.points[keep],
            self.colors[keep],
            index[self.observed_point[seen]],
            self.observed_camera[seen],
            self.observed_pixel[seen],
        )

    def reprojection_errors(self) -> Array:
        """Distance in pixels between each observation and the projection of its point, shape (M,)."""
        errors = np.empty(len(self.observed_point))
        for index, camera in enumerate(self.cameras):
            mine = self.observed_camera == index
            projected = camera.project(self.points[self.observed_point[mine]])
            errors[mine] = np.linalg.norm(projected - self.observed_pixel[mine], axis=1)
        return errors
