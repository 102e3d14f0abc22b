"""The paper's edge as a curve in front of the reference camera, through which it appears over the photo."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.camera import Camera
from ...core.errors import StepFailed
from ...core.numeric.control_points import control_points, with_moved_controls
from .mesh_values import read_values

# The curve's distance from the camera, relative to the camera's distance from the sheet.
_NEARNESS = 0.3
# The curve has as few points as keep it within this share of the photo's longer side from the outline.
_TOLERANCE = 7e-4
# Pixels; a point of the curve nearer to its place than this has not been edited.
_SAME = 0.01


def outline_to_object(name: str, polygon: Array, camera: Camera, distance: float) -> bpy.types.Object:
    """A closed curve of straight pieces, which must become a child of the camera's object.

    Parameters
    ----------
    name : str
    polygon : (K, 2) array
        Distorted pixels of the photo.
    camera : Camera
    distance : float
        From the camera to the sheet, in Blender's units.
    """
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "3D"
    made = bpy.data.objects.new(name, curve)
    set_outline(made, polygon, camera, distance)
    return made


def set_outline(outline_object: bpy.types.Object, polygon: Array, camera: Camera, distance: float) -> None:
    """Give the curve other points; parameters as for `outline_to_object`."""
    curve = outline_object.data
    curve.splines.clear()
    spline = curve.splines.new("POLY")
    shown = polygon[_controls(polygon, camera)]
    spline.points.add(len(shown) - 1)
    spline.use_cyclic_u = True
    spline.points.foreach_set("co", _on_plane(shown, camera, distance).reshape(-1))


def object_to_outline(outline_object: bpy.types.Object, polygon: Array, camera: Camera) -> Array:
    """The outline as it is in the curve now.

    Parameters
    ----------
    outline_object : bpy.types.Object
    polygon : (K, 2) array
        The outline from which the curve was made, distorted pixels of the photo.
    camera : Camera

    Returns
    -------
    (L, 2) array
        ``polygon`` itself if no point of the curve was edited; unchanged between points that were not edited.

    Raises
    ------
    StepFailed
        If the curve is not one closed line in front of its camera.
    """
    splines = list(outline_object.data.splines) if outline_object.type == "CURVE" else []
    if len(splines) != 1 or len(splines[0].points) < 3 or not splines[0].use_cyclic_u:
        raise StepFailed(
            f"The outline {outline_object.name} must be one closed line of straight pieces: delete everything else in "
            "it, close it (Alt-C in Edit Mode), or find it again."
        )
    points = read_values(splines[0].points, "co", 4, np.float32)[:, :3].astype(float)
    in_camera = points @ np.diag([1.0, -1.0, -1.0])
    if (in_camera[:, 2] <= 0).any():
        raise StepFailed(f"A point of the outline {outline_object.name} is behind its camera: move it back.")
    shown = camera.distort(in_camera[:, :2] / in_camera[:, 2:])
    controls = _controls(polygon, camera)
    if shown.shape == (len(controls), 2) and np.abs(shown - polygon[controls]).max() < _SAME:
        return polygon
    return with_moved_controls(polygon, controls, shown, _SAME)


def _controls(polygon: Array, camera: Camera) -> NDArray[np.int64]:
    return control_points(polygon, _TOLERANCE * max(camera.width, camera.height))


def _on_plane(polygon: Array, camera: Camera, distance: float) -> np.ndarray:
    """Points (K, 4) of the curve in the frame of the camera's object, which looks along -z with y up."""
    depth = _NEARNESS * distance
    normalized = camera.undistort(polygon) * depth
    return np.column_stack(
        [normalized[:, 0], -normalized[:, 1], np.full(len(polygon), -depth), np.ones(len(polygon))]
    ).astype(np.float32)
