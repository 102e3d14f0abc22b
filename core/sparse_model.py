"""The result of structure from motion: cameras, points, and where each camera sees each point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import Array
from .camera import Camera

# Points seen in fewer photos are not used: two photos always agree on some point, which does not reveal a wrong match.
FEWEST_VIEWS = 3


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
        """Number of photos that see each point, shape (N,)."""
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

    def observations(self) -> Array:
        """Where each camera sees each point, shape (N, C, 2), distorted pixels; NaN where it does not."""
        observed = np.full((len(self.points), len(self.cameras), 2), np.nan)
        observed[self.observed_point, self.observed_camera] = self.observed_pixel
        return observed

    def reprojection_errors(self) -> Array:
        """Distance in pixels between each observation and the projection of its point, shape (M,)."""
        errors = np.empty(len(self.observed_point))
        for index, camera in enumerate(self.cameras):
            mine = self.observed_camera == index
            projected = camera.project(self.points[self.observed_point[mine]])
            errors[mine] = np.linalg.norm(projected - self.observed_pixel[mine], axis=1)
        return errors


def model_arrays(model: SparseModel) -> dict[str, NDArray[Any]]:
    """A sparse model as plain arrays to keep in a file.

    Returns
    -------
    dict
        The arrays of `SparseModel`, and of its cameras ``camera_names``, ``camera_sizes`` (C, 2), ``camera_lenses``
        (C, 5: focal length, principal point, distortion) and ``camera_poses`` (C, 3, 4).
    """
    return {
        "points": model.points,
        "colors": model.colors,
        "observed_point": model.observed_point,
        "observed_camera": model.observed_camera,
        "observed_pixel": model.observed_pixel,
        **camera_arrays(model.cameras),
    }


def camera_arrays(cameras: Sequence[Camera]) -> dict[str, NDArray[Any]]:
    """Cameras as plain arrays to keep in a file, see `model_arrays`."""
    lenses = [[camera.focal_length, *camera.principal_point, *camera.distortion] for camera in cameras]
    poses = [np.column_stack([camera.rotation, camera.translation]) for camera in cameras]
    return {
        "camera_names": np.array([camera.name for camera in cameras], np.str_),
        "camera_sizes": np.array([[camera.width, camera.height] for camera in cameras], np.int64).reshape(-1, 2),
        "camera_lenses": np.array(lenses, float).reshape(-1, 5),
        "camera_poses": np.array(poses, float).reshape(-1, 3, 4),
    }


def model_from_arrays(arrays: Mapping[str, NDArray[Any]]) -> SparseModel:
    """The model from the arrays of `model_arrays`.

    Raises
    ------
    KeyError
        If an array is missing.
    """
    return SparseModel(
        cameras_from_arrays(arrays),
        arrays["points"],
        arrays["colors"],
        arrays["observed_point"],
        arrays["observed_camera"],
        arrays["observed_pixel"],
    )


def cameras_from_arrays(arrays: Mapping[str, NDArray[Any]]) -> tuple[Camera, ...]:
    """The cameras that `camera_arrays` took apart.

    Raises
    ------
    KeyError
        If an array is missing.
    """
    return tuple(
        Camera(str(name), int(size[0]), int(size[1]), float(lens[0]), lens[1:3], lens[3:5], pose[:, :3], pose[:, 3])
        for name, size, lens, pose in zip(
            arrays["camera_names"],
            arrays["camera_sizes"],
            arrays["camera_lenses"],
            arrays["camera_poses"],
            strict=True,
        )
    )
