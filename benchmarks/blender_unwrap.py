"""Blender's own unwrapping as a baseline, on the same mesh."""

from __future__ import annotations

from typing import Literal

import bpy
import numpy as np

from ..core.arrays import Array
from ..core.sheet import Sheet

Method = Literal["ANGLE_BASED", "CONFORMAL", "MINIMUM_STRETCH"]
METHODS: tuple[Method, ...] = ("ANGLE_BASED", "CONFORMAL", "MINIMUM_STRETCH")


def unwrap(sheet: Sheet, method: Method) -> Array:
    """Flat coordinates (V, 2) like those of `core.flat.flatten`: the sheet's own unit, v down, any turn and place."""
    mesh = bpy.data.meshes.new("unwrap")
    mesh.from_pydata(sheet.vertices.tolist(), [], sheet.triangles.tolist())
    thing = bpy.data.objects.new("unwrap", mesh)
    bpy.context.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    thing.select_set(True)
    try:
        mesh.uv_layers.new(name="flat")
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.uv.unwrap(method=method, margin=0.0)
        bpy.ops.object.mode_set(mode="OBJECT")
        corners = np.empty(2 * len(mesh.loops), np.float32)
        mesh.uv_layers["flat"].uv.foreach_get("vector", corners)
        vertex_of_corner = np.empty(len(mesh.loops), np.int32)
        mesh.loops.foreach_get("vertex_index", vertex_of_corner)
    finally:
        bpy.data.objects.remove(thing)
        bpy.data.meshes.remove(mesh)
    flat = np.zeros((len(sheet.vertices), 2))
    flat[vertex_of_corner] = corners.reshape(-1, 2)
    return flat * [1, -1] * np.sqrt(_area(sheet.vertices, sheet) / _area(np.c_[flat, np.zeros(len(flat))], sheet))


def _area(positions: Array, sheet: Sheet) -> float:
    a, b, c = (positions[sheet.triangles[:, i]] for i in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
