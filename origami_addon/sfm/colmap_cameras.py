"""Converts COLMAP's lens models to the radial model that the rest of the program uses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.camera import Camera
from ...core.errors import UnusablePhotos

# Pixels at the edge of the photo: a lens term that moves a point there by less is left out.
_NEGLIGIBLE_PIXELS = 0.25


def to_camera(name: str, kind: str, size: Sequence[int] | NDArray[np.int64], parameters: Array, pose: Array) -> Camera:
    """A COLMAP camera as a `Camera`.

    Parameters
    ----------
    name : str
        The photo's.
    kind : str
        COLMAP's name of the lens model.
    size : (2,) int array
        Width and height in pixels.
    parameters : (K,) array
        In COLMAP's order; unused places at the end may hold anything.
    pose : (3, 4) array
        World to camera.

    Raises
    ------
    UnusablePhotos
        If radial distortion with two terms cannot describe the lens, or a size or focal length is not positive.
    """
    width, height = int(size[0]), int(size[1])
    fx, fy, cx, cy, radial, other = _split(kind, parameters)
    if min(width, height) <= 0 or not (min(fx, fy) > 0 and np.isfinite([fx, fy, cx, cy, *radial, *other]).all()):
        raise UnusablePhotos(
            f"The COLMAP model's camera of {name} ({width} x {height} pixels, focal length {fx:g}) is invalid: export "
            "the model again from COLMAP."
        )
    corner = np.hypot(width, height) / 2 / fx
    # Their mean takes the place of both focal lengths, and is half of their difference off each.
    moved = max(abs(fx - fy) / (fx + fy) * max(width, height) / 2, fx * np.abs(other).max() * corner**2)
    if moved > _NEGLIGIBLE_PIXELS:
        raise UnusablePhotos(
            f"The COLMAP model's lens ({kind}) has terms other than radial distortion: undistort the photos with "
            "COLMAP's image_undistorter and use the undistorted photos and their model."
        )
    return Camera(
        name,
        width,
        height,
        float((fx + fy) / 2),
        np.array([cx, cy]),
        radial,
        np.array(pose[:, :3]),
        np.array(pose[:, 3]),
    )


def _split(kind: str, p: Array) -> tuple[float, float, float, float, Array, Array]:
    """fx, fy, cx, cy, (k1, k2), (p1, p2) of a COLMAP camera."""
    none = np.zeros(2)
    if kind == "SIMPLE_PINHOLE":
        return p[0], p[0], p[1], p[2], none, none
    if kind == "PINHOLE":
        return p[0], p[1], p[2], p[3], none, none
    if kind == "SIMPLE_RADIAL":
        return p[0], p[0], p[1], p[2], np.array([p[3], 0]), none
    if kind == "RADIAL":
        return p[0], p[0], p[1], p[2], np.array(p[3:5]), none
    if kind == "OPENCV":
        return p[0], p[1], p[2], p[3], np.array(p[4:6]), np.array(p[6:8])
    raise UnusablePhotos(
        f"The COLMAP model's lens ({kind}) is not supported: undistort the photos with COLMAP's "
        "image_undistorter and use the undistorted photos and their model."
    )
