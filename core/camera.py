"""One photo's camera: pinhole with radial distortion, in COLMAP's conventions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Array

# Fixed-point iterations: at the corner of a 12 megapixel photo, they leave less than 3e-8 pixels with k1 = +-0.1, and
# 0.012 pixels with k1 = -0.2.
_UNDISTORT_ITERATIONS = 12


@dataclass(frozen=True)
class Camera:
    """A posed pinhole camera with radial distortion.

    Camera frame: x right, y down, z forward. Pixel coordinates have the centre of the first pixel at (0.5, 0.5),
    as in COLMAP. A world point ``X`` is at ``rotation @ X + translation`` in the camera frame.

    Attributes
    ----------
    name : str
        The photo's file name.
    width, height : int
        Size of the photo in pixels.
    focal_length : float
        Pixels.
    principal_point : (2,) array
        Pixels.
    distortion : (2,) array
        ``k1, k2`` of ``x_distorted = x (1 + k1 r^2 + k2 r^4)`` in normalised coordinates.
    rotation : (3, 3) array
        World to camera.
    translation : (3,) array
        World to camera, in units of the world frame.
    """

    name: str
    width: int
    height: int
    focal_length: float
    principal_point: Array
    distortion: Array
    rotation: Array
    translation: Array

    @property
    def center(self) -> Array:
        """Position of the camera in the world frame, shape (3,)."""
        return -self.rotation.T @ self.translation

    def to_camera_frame(self, points: Array) -> Array:
        """World points (..., 3) in the camera frame (..., 3)."""
        return points @ self.rotation.T + self.translation

    def to_world_frame(self, points: Array) -> Array:
        """Camera-frame points (..., 3) in the world frame (..., 3)."""
        return (points - self.translation) @ self.rotation

    def project(self, points: Array) -> Array:
        """World points (..., 3) to distorted pixels (..., 2); NaN behind the camera."""
        in_camera = self.to_camera_frame(points)
        depth = np.where(in_camera[..., 2:] > 0, in_camera[..., 2:], np.nan)
        return self.distort(in_camera[..., :2] / depth)

    def distort(self, normalized: Array) -> Array:
        """Normalised image coordinates (x/z, y/z) (..., 2) to distorted pixels (..., 2)."""
        k1, k2 = self.distortion
        r2 = (normalized**2).sum(-1, keepdims=True)
        return normalized * (1 + k1 * r2 + k2 * r2**2) * self.focal_length + self.principal_point

    def undistort(self, pixels: Array) -> Array:
        """Distorted pixels (..., 2) to normalised image coordinates (..., 2), by fixed-point iteration."""
        k1, k2 = self.distortion
        distorted = (pixels - self.principal_point) / self.focal_length
        normalized = distorted
        for _ in range(_UNDISTORT_ITERATIONS):
            r2 = (normalized**2).sum(-1, keepdims=True)
            normalized = distorted / (1 + k1 * r2 + k2 * r2**2)
        return normalized
