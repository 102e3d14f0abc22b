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
# How many numbers describe a lens of these kinds, in COLMAP's `models.h`.
_PARAMETERS = {"OPENCV": 8, "FULL_OPENCV": 12}
# Along each side of a photo, this many places are compared.
_PLACES = 21


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
    focal_length, center = (fx + fy) / 2, np.array([cx, cy])
    if fx != fy or other.any():
        focal_length, center, radial, moved = _radial((fx, fy, cx, cy, radial, other), width, height)
        if moved > _NEGLIGIBLE_PIXELS:
            raise UnusablePhotos(
                f"The COLMAP model's lens ({kind}) has terms other than radial distortion: undistort the photos with "
                "COLMAP's image_undistorter and use the undistorted photos and their model."
            )
    return Camera(
        name,
        width,
        height,
        float(focal_length),
        center,
        radial,
        np.array(pose[:, :3]),
        np.array(pose[:, 3]),
    )


_Lens = tuple[float, float, float, float, Array, Array]


def _split(kind: str, p: Array) -> _Lens:
    """fx, fy, cx, cy, (k1, k2), (p1, p2, k3, k4, k5, k6) of a COLMAP camera."""
    none = np.zeros(6)
    if kind == "SIMPLE_PINHOLE":
        return p[0], p[0], p[1], p[2], none[:2], none
    if kind == "PINHOLE":
        return p[0], p[1], p[2], p[3], none[:2], none
    if kind == "SIMPLE_RADIAL":
        return p[0], p[0], p[1], p[2], np.array([p[3], 0]), none
    if kind == "RADIAL":
        return p[0], p[0], p[1], p[2], np.array(p[3:5]), none
    if kind in ("OPENCV", "FULL_OPENCV"):
        return p[0], p[1], p[2], p[3], np.array(p[4:6]), np.concatenate([p[6 : _PARAMETERS[kind]], none])[: len(none)]
    raise UnusablePhotos(
        f"The COLMAP model's lens ({kind}) is not supported: undistort the photos with COLMAP's "
        "image_undistorter and use the undistorted photos and their model."
    )


def _radial(lens: _Lens, width: int, height: int) -> tuple[float, Array, Array, float]:
    """The focal length, principal point and radial terms (2,) nearest to a lens, and how far off they are, pixels.

    Pixels are linear in the focal length, its products with the radial terms, and the principal point.
    """
    fx, fy, cx, cy, (k1, k2), (p1, p2, k3, k4, k5, k6) = lens
    columns, rows = np.meshgrid(np.linspace(0, width, _PLACES), np.linspace(0, height, _PLACES))
    x, y = ((columns - cx) / fx).ravel(), ((rows - cy) / fy).ravel()
    r2 = x**2 + y**2
    with np.errstate(divide="ignore", invalid="ignore"):
        radial = (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) / (1 + k4 * r2 + k5 * r2**2 + k6 * r2**3)
    seen_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x**2)
    seen_y = y * radial + 2 * p2 * x * y + p1 * (r2 + 2 * y**2)
    seen = np.concatenate([fx * seen_x + cx, fy * seen_y + cy])
    if not np.isfinite(seen).all():
        return fx, np.array([cx, cy]), np.array([k1, k2]), np.inf
    one, none = np.ones_like(x), np.zeros_like(x)
    powers = np.stack([one, r2, r2**2], axis=1)
    terms = np.concatenate([x[:, None] * powers, y[:, None] * powers])
    places = np.concatenate([np.stack([one, none], axis=1), np.stack([none, one], axis=1)])
    fit = np.linalg.lstsq(np.hstack([terms, places]), seen, rcond=None)[0]
    off = (np.hstack([terms, places]) @ fit - seen).reshape(2, -1)
    return fit[0], fit[3:], fit[1:3] / fit[0], float(np.hypot(*off).max())
