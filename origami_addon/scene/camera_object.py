"""Cameras that see what the photos show, with the photo in the background."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Literal

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.camera import Camera
from ...core.errors import StepFailed
from ...core.page.photo_colors import Photo, sample
from ..files.image_files import to_eight_bits, write_jpeg
from .sheet_mesh import transform

_SENSOR_MM = 36.0
# Characters of a photo's name in that of its picture: systems allow 255 bytes, and a character has up to four.
_LONGEST_STEM = 50
# A camera's background picture: its longer side, at most, its quality as a JPEG, and a resolution, which means nothing.
_VIEW_PIXELS, _VIEW_QUALITY, _VIEW_DPI = 1600, 85, 72
_NEAREST = 1e-3  # that a camera shows, in Blender's units: a sheet in metres is never that near
VIEWS = "cameras"  # folder with the photos as pinhole cameras would have taken them
_SIZE = 0.1  # of a camera's drawing, relative to its distance from the page


def camera_to_object(name: str, camera: Camera, frame: Array) -> bpy.types.Object:
    """A Blender camera that sees what ``camera`` sees, without lens distortion, which Blender's cameras lack.

    The scene's resolution must have the photo's aspect.
    """
    data = bpy.data.cameras.new(name)
    longer = max(camera.width, camera.height)
    data.sensor_fit = "HORIZONTAL" if camera.width >= camera.height else "VERTICAL"
    data.sensor_width = data.sensor_height = _SENSOR_MM
    data.lens = camera.focal_length * _SENSOR_MM / longer
    data.shift_x = (camera.width / 2 - camera.principal_point[0]) / longer
    data.shift_y = (camera.principal_point[1] - camera.height / 2) / longer
    data.clip_start = _NEAREST
    camera_object = bpy.data.objects.new(name, data)
    camera_object["photo_size"] = [camera.width, camera.height]
    pose_camera(camera_object, camera, frame)
    return camera_object


def pose_camera(camera_object: bpy.types.Object, camera: Camera, frame: Array) -> None:
    """Move a camera's object to its place in ``frame``, the similarity (4, 4) from the sparse model to Blender."""
    scale = np.cbrt(np.linalg.det(frame[:3, :3]))
    pose = np.eye(4)
    # Blender's cameras look along -z with y up.
    pose[:3, :3] = frame[:3, :3] / scale @ camera.rotation.T @ np.diag([1, -1, -1])
    pose[:3, 3] = transform(frame, camera.center[None])[0]
    camera_object.data.display_size = _SIZE * float(np.linalg.norm(pose[:3, 3]))
    camera_object.matrix_basis = Matrix(pose.tolist())


def undistorted(photo: Photo, camera: Camera, longest: int) -> NDArray[np.uint8]:
    """The photo as a pinhole camera of the same focal length and principal point would have taken it.

    Reduced so that its longer side has at most about ``longest`` pixels; 8 bits; white where the photo ends.
    """
    factor = -(-max(camera.width, camera.height) // longest)
    rows, columns = (length // factor for length in (camera.height, camera.width))
    photo = to_eight_bits(photo)
    total = np.zeros((rows, columns, 3), np.float32)
    for row, column in np.ndindex(factor, factor):
        total += photo[row : rows * factor : factor, column : columns * factor : factor]
    small = np.rint(total / np.float32(factor**2)).astype(np.uint8)
    grid = np.stack(np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5), axis=-1) * factor
    position = camera.distort((grid - camera.principal_point) / camera.focal_length) / factor
    outside = (position < 0) | (position > (columns, rows))
    position[outside.any(axis=-1)] = np.nan
    return sample(small, position.astype(np.float32), "linear")


def write_views(folder: Path, cameras: Sequence[Camera], read_photo: Callable[[int], Photo]) -> Iterator[Path]:
    """Write the background picture of each camera as JPEG into a new folder.

    Raises
    ------
    StepFailed
    """
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise StepFailed(
            f"The folder {folder} could not be made ({error.strerror}): choose another output folder."
        ) from error
    for index, camera in enumerate(cameras):
        stem = re.sub(r"[^\w.-]+", "_", camera.name.rsplit(".", 1)[0])[:_LONGEST_STEM]
        path = folder / f"{index + 1:02d}_{stem}.jpg"
        write_jpeg(path, undistorted(read_photo(index), camera, _VIEW_PIXELS), _VIEW_DPI, quality=_VIEW_QUALITY)
        yield path


def draw_photo(camera_object: bpy.types.Object, where: Literal["BACK", "FRONT"]) -> None:
    """Draw a camera's photo behind or in front of the scene, in views through the camera."""
    for background in camera_object.data.background_images:
        background.display_depth = where


def set_background(camera_object: bpy.types.Object, picture: Path) -> bpy.types.Image:
    """Set the picture as the camera's background."""
    camera_object.data.show_background_images = True
    background = camera_object.data.background_images.new()
    background.image = bpy.data.images.load(str(picture))
    background.alpha = 1.0
    draw_photo(camera_object, "BACK")
    background.frame_method = "STRETCH"
    return background.image
