"""Project the ground into a photo."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..camera import Camera
from .ground_frame import GroundFrame

# Values without a figure are choices; no measurement of them is recorded.
# Squared distance from the optical axis up to which the lens distortion holds, relative to that of the photo's corners:
# beyond, its polynomial may turn back into the photo.
_FARTHEST = 1.1


def seen(camera: Camera, surface: Array) -> Array:
    """Pixels (..., 2) of the surface (..., 3) in a photo; NaN outside it."""
    in_camera = camera.to_camera_frame(surface)
    depth = np.where(in_camera[..., 2] > 0, in_camera[..., 2], np.nan)
    normalized = in_camera[..., :2] / depth[..., None]
    frame = np.array([[0, 0], [camera.width, 0], [0, camera.height], [camera.width, camera.height]], float)
    farthest = _FARTHEST * float((camera.undistort(frame) ** 2).sum(axis=1).max())
    pixels = camera.distort(normalized)
    inside = ((pixels > 1) & (pixels < [camera.width - 1, camera.height - 1])).all(axis=-1)
    inside &= (normalized**2).sum(axis=-1) < farthest
    return np.asarray(np.where(inside[..., None], pixels, np.nan))


def pixels_per_cell(camera: Camera, frame: GroundFrame, cell: float) -> float:
    """Pixels of the photo along a cell of this side, world units, about the frame's origin."""
    return camera.focal_length * cell / float(np.linalg.norm(frame.origin - camera.center))
