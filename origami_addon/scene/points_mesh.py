"""The sparse points as a mesh of loose vertices."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.errors import StepFailed
from ...core.sparse_model import SparseModel
from .mesh_values import read_values
from .sheet_mesh import transform

POINT_ERROR = "reprojection_error"  # of a vertex: mean over the photos that see it, pixels
_POINT = "point"  # of a vertex: index of the point in the sparse model; shows which ones the user has deleted


def points_to_object(name: str, model: SparseModel, frame: Array) -> bpy.types.Object:
    """A mesh object with a vertex for each point.

    Its attributes are `color`, as in the photos; `reprojection_error`, the point's mean error in pixels; `views`, the
    number of photos that show it; and `point`, its index in the model.
    """
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(model.points))
    colors = np.full((len(model.points), 4), 1, np.float32)
    colors[:, :3] = model.colors / np.float32(255)
    mesh.attributes.new("color", "BYTE_COLOR", "POINT").data.foreach_set("color_srgb", colors.reshape(-1))
    views = model.views_per_point()
    error = np.bincount(model.observed_point, model.reprojection_errors(), len(model.points)) / np.maximum(views, 1)
    for attribute, kind, values in (
        (POINT_ERROR, "FLOAT", error.astype(np.float32)),
        ("views", "INT", views.astype(np.int32)),
        (_POINT, "INT", np.arange(len(model.points), dtype=np.int32)),
    ):
        mesh.attributes.new(attribute, kind, "POINT").data.foreach_set("value", values)
    made = bpy.data.objects.new(name, mesh)
    move_points(made, model, frame)
    return made


def move_points(points_object: bpy.types.Object, model: SparseModel, frame: Array) -> None:
    """Move the vertices to the points' places in ``frame``, the similarity (4, 4) from the sparse model to Blender.

    If the model no longer has the points that the user deleted, the vertices are renumbered.

    Raises
    ------
    StepFailed
        If the points have lost their numbers.
    """
    mesh, index = points_object.data, _indices(points_object)
    if len(index) == len(model.points):
        index = np.arange(len(model.points))
        mesh.attributes[_POINT].data.foreach_set("value", index.astype(np.int32))
    mesh.vertices.foreach_set("co", transform(frame, model.points[index]).astype(np.float32).reshape(-1))
    mesh.update()


def points_left(points_object: bpy.types.Object, model: SparseModel) -> NDArray[np.bool_]:
    """Which of the model's points the user has not deleted, (N,).

    Raises
    ------
    StepFailed
        If the points have lost their numbers.
    """
    left = np.zeros(len(model.points), bool)
    index = _indices(points_object)
    if len(index) and not 0 <= index.min() <= index.max() < len(left):
        raise _numbers_lost(points_object)
    left[index] = True
    return left


def _indices(points_object: bpy.types.Object) -> NDArray[np.int64]:
    if points_object.type != "MESH" or _POINT not in points_object.data.attributes:
        raise _numbers_lost(points_object)
    return read_values(points_object.data.attributes[_POINT].data, "value", 1, np.int32).astype(np.int64)


def _numbers_lost(points_object: bpy.types.Object) -> StepFailed:
    return StepFailed(
        f"{points_object.name} no longer says which points it holds: press Ctrl-Z, or run Place Photos again."
    )
