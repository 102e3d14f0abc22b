"""Reads arrays from Blender's meshes and writes them."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array, Indices


def read_values(collection: Any, attribute: str, components: int, dtype: type) -> NDArray[Any]:
    """An attribute of all items of a Blender collection, (N,) or (N, components)."""
    values: NDArray[Any] = np.empty(len(collection) * components, dtype)
    collection.foreach_get(attribute, values)
    return values.reshape(-1, components) if components > 1 else values


def in_world(shown: bpy.types.Object, local: Array) -> Array:
    """Points (..., 3) of an object in the world."""
    matrix = np.array(shown.matrix_world)
    return np.asarray(local @ matrix[:3, :3].T + matrix[:3, 3])


def world_corners(shown: bpy.types.Object) -> Array:
    """The corners (8, 3) of an object's bounding box, in the world."""
    return in_world(shown, np.array([corner[:] for corner in shown.bound_box]))


def read_edges(mesh: bpy.types.Mesh) -> Indices:
    """The vertices of each edge, (E, 2)."""
    return read_values(mesh.edges, "vertices", 2, np.int32).astype(np.int64)


def members(mesh_object: bpy.types.Object, name: str) -> Indices:
    """The vertices with a weight in a vertex group, in ascending order."""
    group = mesh_object.vertex_groups.get(name)
    if group is None:
        return np.zeros(0, np.int64)
    index = group.index
    inside = [
        number
        for number, vertex in enumerate(mesh_object.data.vertices)
        for entry in vertex.groups
        if entry.group == index and entry.weight > 0
    ]
    return np.array(inside, np.int64)


def set_attribute(mesh: bpy.types.Mesh, name: str, kind: str, domain: str, values: NDArray[Any]) -> None:
    """Fill an attribute, which is created if missing; kind and domain have Blender's names."""
    attribute = mesh.attributes.get(name) or mesh.attributes.new(name, kind, domain)
    attribute.data.foreach_set("value", values)


def empty_group(mesh_object: bpy.types.Object, name: str) -> bpy.types.VertexGroup:
    """A vertex group, created or emptied."""
    group = mesh_object.vertex_groups.get(name) or mesh_object.vertex_groups.new(name=name)
    group.remove(range(len(mesh_object.data.vertices)))
    return group


def set_group(mesh_object: bpy.types.Object, name: str, vertices: Indices) -> None:
    """Make ``vertices`` the members of a vertex group."""
    empty_group(mesh_object, name).add(vertices.tolist(), 1.0, "REPLACE")
