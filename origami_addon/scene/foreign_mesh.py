"""Reads any mesh of the user's for the core's unwrapping, and writes the result into its UV map."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import bpy
import numpy as np

from ...core.arrays import Indices
from ...core.creases.painted_ridges import painted_ridges
from ...core.creases.ridge_runs import runs_of_edges
from ...core.errors import UnusableMesh
from ..files.kept import Arrays
from .mesh_values import members, read_edges, read_values
from .modes import in_object_mode

RidgeSource = Literal["none", "group", "sharp"]


@dataclass(frozen=True)
class ForeignMesh:
    """The part of a mesh to unwrap.

    Attributes
    ----------
    arrays : dict of arrays
        ``vertices``, ``corner_vertex``, ``triangles``, ``seams``, ``uv``, ``pinned``, ``ridges`` (all runs
        concatenated) and ``ridge_lengths``; `unwrap_arguments` makes of them what `unwrap` takes.
    warning : str or None
    """

    arrays: Arrays
    warning: str | None


def unwrap_arguments(arrays: Arrays) -> dict[str, Any]:
    """The arrays of a `ForeignMesh` as arguments of `unwrap` (`core/unwrap/unwrap.py`)."""
    ends = np.cumsum(arrays["ridge_lengths"])
    given = {name: array for name, array in arrays.items() if name not in ("ridges", "ridge_lengths")}
    return given | {"ridges": np.split(arrays["ridges"], ends)[:-1]}


def read_mesh(mesh_object: bpy.types.Object, ridges: RidgeSource) -> ForeignMesh:
    """A mesh object as arrays; in Edit Mode only its selected faces, otherwise all.

    Parameters
    ----------
    mesh_object : bpy.types.Object
        Its scale counts, its modifiers do not.
    ridges : {"none", "group", "sharp"}
        What becomes straight: nothing, the active vertex group's painted bands, or the edges marked sharp.

    Raises
    ------
    UnusableMesh
        If it has no faces, or none is selected.
    """
    selected_only = mesh_object.mode == "EDIT"
    with in_object_mode(mesh_object):
        return _read(mesh_object, ridges, selected_only)


def _read(mesh_object: bpy.types.Object, ridges: RidgeSource, selected_only: bool) -> ForeignMesh:
    mesh = mesh_object.data
    mesh.calc_loop_triangles()
    triangles = read_values(mesh.loop_triangles, "loops", 3, np.int32).astype(np.int64)
    if selected_only:
        selected = read_values(mesh.polygons, "select", 1, bool)
        triangles = triangles[selected[read_values(mesh.loop_triangles, "polygon_index", 1, np.int32)]]
    if len(triangles) == 0:
        if selected_only:
            raise UnusableMesh("No face is selected: select the faces to unwrap.")
        raise UnusableMesh("The mesh has no faces: choose one that has.")
    positions = read_values(mesh.vertices, "co", 3, np.float32).astype(float)
    vertices = positions * np.array(mesh_object.matrix_world.to_scale())
    edges = read_edges(mesh)
    runs, warning = _ridges(mesh_object, ridges, vertices, edges)
    layer = mesh.uv_layers.active
    count = len(mesh.loops)
    uv = np.zeros((count, 2)) if layer is None else read_values(layer.uv, "vector", 2, np.float32).astype(float)
    pinned = np.zeros(count, bool)
    if layer is not None and len(layer.pin) == count:
        pinned = read_values(layer.pin, "value", 1, bool)
    arrays = {
        "vertices": vertices,
        "corner_vertex": read_values(mesh.loops, "vertex_index", 1, np.int32).astype(np.int64),
        "triangles": triangles,
        "seams": edges[read_values(mesh.edges, "use_seam", 1, bool)],
        "uv": uv,
        "pinned": pinned,
        "ridges": np.concatenate([np.zeros(0, np.int64), *runs]),
        "ridge_lengths": np.array([len(run) for run in runs], np.int64),
    }
    return ForeignMesh(arrays, warning)


def _ridges(
    mesh_object: bpy.types.Object, source: RidgeSource, vertices: np.ndarray, edges: Indices
) -> tuple[list[Indices], str | None]:
    mesh = mesh_object.data
    if source == "sharp":
        return runs_of_edges(vertices, edges[read_values(mesh.edges, "use_edge_sharp", 1, bool)]), None
    group = mesh_object.vertex_groups.active
    if source == "none" or group is None:
        return [], None
    weight = np.zeros(len(vertices))
    weight[members(mesh_object, group.name)] = 1.0
    painted = painted_ridges(vertices, edges, weight)
    return list(painted.runs), painted.warning


def write_uv(mesh_object: bpy.types.Object, uv: np.ndarray) -> None:
    """Write UV coordinates (L, 2) into the active UV map of a mesh, which is created if missing.

    Raises
    ------
    UnusableMesh
        If the mesh has other corners than it had when it was read.
    """
    with in_object_mode(mesh_object):
        mesh = mesh_object.data
        if len(mesh.loops) != len(uv):
            raise UnusableMesh("The mesh was changed while it was unwrapped: unwrap it again.")
        layer = mesh.uv_layers.active or mesh.uv_layers.new(name="UVMap")
        layer.uv.foreach_set("vector", uv.astype(np.float32).reshape(-1))
        mesh.update()
