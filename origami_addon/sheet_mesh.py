"""The sheet and its flat map as a Blender mesh, and back.

What an artist may change stays what it is in Blender: positions are vertices, the page is the UV layer `page`, creases
and the paper's edge are the vertex groups `ridge` and `boundary`. Beside them, two integer attributes keep the order
of the vertices along each crease and around the edge, in a form that survives editing of the mesh.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.camera import Array, Camera
from ..core.distortion import measure_strain
from ..core.errors import StepFailed
from ..core.sheet import FlatMap, Indices, Sheet, sheet_arrays
from ..core.triangles import directed_edges

PAGE_UV, PHOTO_UV = "page", "photo"
PHOTO_DEPTH = "photo_depth"  # of a vertex: how far before the reference camera, along its axis, in any unit
RIDGE_GROUP, BOUNDARY_GROUP = "ridge", "boundary"
_NO_EDGES = np.zeros((0, 2), np.int64)
_RUN = "ridge_run"  # of an edge: number of its crease from 1 on, negative if the crease goes from its end to its start
_ORDER = "boundary_order"  # of a vertex: its place along the paper's edge, -1 inside
_FRAME, _PAGE_SIZE, _PAGE_UNIT, _WORLD_SCALE = (
    "origami_frame",
    "origami_page_size",
    "origami_page_unit",
    "origami_world_scale",
)


def sheet_to_object(name: str, sheet: Sheet, flat: FlatMap, reference: Camera, frame: Array) -> bpy.types.Object:
    """Make a mesh object of a sheet.

    Parameters
    ----------
    name : str
    sheet : Sheet
    flat : FlatMap
    reference : Camera
        The photo that the UV layer `photo` is for; its lens distortion is in the coordinates.
    frame : (4, 4) array
        Similarity from the world frame of the sparse model to Blender's, metres.

    Returns
    -------
    bpy.types.Object
        In no collection yet. Its faces have the attributes `stretch`, `area_distortion` and `angle_distortion`.
    """
    mesh = bpy.data.meshes.new(name)
    _set_geometry(mesh, transform(frame, sheet.vertices), sheet.triangles, sheet.ridges)
    corner = sheet.triangles.reshape(-1)
    _set_uv(mesh, PAGE_UV, page_uv(flat)[corner])
    _set_uv(mesh, PHOTO_UV, photo_uv(reference, sheet.vertices)[corner])
    mesh.uv_layers.active = mesh.uv_layers[PAGE_UV]
    mesh.uv_layers[PAGE_UV].active_render = True
    strain = measure_strain(sheet.vertices, sheet.triangles, flat.uv)
    for attribute in ("stretch", "area_distortion", "angle_distortion"):
        values = np.nan_to_num(getattr(strain, attribute)).astype(np.float32)
        mesh.attributes.new(attribute, "FLOAT", "FACE").data.foreach_set("value", values)
    depth = reference.to_camera_frame(sheet.vertices)[:, 2].astype(np.float32)
    mesh.attributes.new(PHOTO_DEPTH, "FLOAT", "POINT").data.foreach_set("value", depth)
    order = np.full(len(sheet.vertices), -1, np.int32)
    order[sheet.boundary] = np.arange(len(sheet.boundary))
    mesh.attributes.new(_ORDER, "INT", "POINT").data.foreach_set("value", order)
    mesh.attributes.new(_RUN, "INT", "EDGE").data.foreach_set("value", _ridge_runs(mesh, sheet.ridges))

    sheet_object = bpy.data.objects.new(name, mesh)
    on_ridge = np.unique(sheet_arrays(sheet)["ridges"])
    sheet_object.vertex_groups.new(name=RIDGE_GROUP).add(on_ridge.tolist(), 1.0, "REPLACE")
    sheet_object.vertex_groups.new(name=BOUNDARY_GROUP).add(sheet.boundary.tolist(), 1.0, "REPLACE")
    sheet_object[_FRAME] = [float(value) for value in frame.reshape(-1)]
    sheet_object[_PAGE_SIZE] = [float(flat.width), float(flat.height)]
    sheet_object[_PAGE_UNIT] = flat.unit
    if flat.world_scale is not None:
        sheet_object[_WORLD_SCALE] = float(flat.world_scale)
    return sheet_object


def object_to_sheet(sheet_object: bpy.types.Object) -> tuple[Sheet, FlatMap]:
    """Read a sheet back from its mesh, as it is now.

    Positions come back in the sparse model's frame, in Blender's single precision.

    Raises
    ------
    StepFailed
        If the object is not a sheet, or is no longer one piece of triangles with one edge.
    """
    mesh = sheet_object.data
    missing = [layer for layer in (PAGE_UV,) if layer not in getattr(mesh, "uv_layers", {})]
    if _FRAME not in sheet_object or missing:
        raise StepFailed(f"{sheet_object.name} is not a sheet with a UV map {PAGE_UV!r}: choose the sheet's object.")
    if any(polygon.loop_total != 3 for polygon in mesh.polygons):
        raise StepFailed(f"{sheet_object.name} has faces that are not triangles: triangulate it (Ctrl-T in Edit Mode).")
    positions = read_values(mesh.vertices, "co", 3, np.float32).astype(float)
    triangles = read_values(mesh.loops, "vertex_index", 1, np.int32).reshape(-1, 3).astype(np.int64)
    frame = np.array(sheet_object[_FRAME]).reshape(4, 4)
    vertices = transform(np.linalg.inv(frame), positions)

    width, height = sheet_object[_PAGE_SIZE]
    corner_uv = read_values(mesh.uv_layers[PAGE_UV].uv, "vector", 2, np.float32).astype(float)
    uv = np.zeros((len(vertices), 2))
    uv[triangles.reshape(-1)] = corner_uv
    uv = np.column_stack([uv[:, 0], 1 - uv[:, 1]]) * (width, height)
    flat = FlatMap(uv, width, height, sheet_object[_PAGE_UNIT], sheet_object.get(_WORLD_SCALE))
    return Sheet(vertices, triangles, _read_ridges(sheet_object), _read_boundary(mesh, triangles)), flat


def page_uv(flat: FlatMap) -> Array:
    """The flat map as Blender's UV (V, 2): 0 to 1, v up."""
    return np.column_stack([flat.uv[:, 0] / flat.width, 1 - flat.uv[:, 1] / flat.height])


def photo_uv(camera: Camera, points: Array) -> Array:
    """Points (V, 3) of the sparse model's frame as UV (V, 2) of a photo: 0 to 1, v up."""
    pixels = camera.project(points)
    return np.nan_to_num(np.column_stack([pixels[:, 0] / camera.width, 1 - pixels[:, 1] / camera.height]))


def transform(matrix: Array, points: Array) -> Array:
    """Points (N, 3) moved by a (4, 4) matrix."""
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def _set_geometry(mesh: bpy.types.Mesh, positions: Array, triangles: Indices, lines: tuple[Indices, ...]) -> None:
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", positions.astype(np.float32).reshape(-1))
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.astype(np.int32).reshape(-1))
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    # Where a line does not follow the triangles, its edges are loose ones.
    edges = np.unique(np.sort(np.concatenate([np.stack([a[:-1], a[1:]], 1) for a in lines] or [_NO_EDGES])), axis=0)
    mesh.edges.add(len(edges))
    mesh.edges.foreach_set("vertices", edges.astype(np.int32).reshape(-1))
    mesh.update(calc_edges=True)
    if mesh.validate():
        raise StepFailed(
            f"The mesh {mesh.name} has faces that Blender cannot hold (doubled, or with a repeated corner): "
            "run again with another number of grid rows."
        )
    mesh.shade_smooth()


def _set_uv(mesh: bpy.types.Mesh, name: str, uv: Array) -> None:
    layer = mesh.uv_layers.new(name=name, do_init=False)
    layer.uv.foreach_set("vector", uv.astype(np.float32).reshape(-1))


def read_values(collection: Any, attribute: str, components: int, dtype: type) -> NDArray[Any]:
    """An attribute of all items of a Blender collection, (N,) or (N, components)."""
    values: NDArray[Any] = np.empty(len(collection) * components, dtype)
    collection.foreach_get(attribute, values)
    return values.reshape(-1, components) if components > 1 else values


def _edges(mesh: bpy.types.Mesh) -> Indices:
    return read_values(mesh.edges, "vertices", 2, np.int32).astype(np.int64)


def _ridge_runs(mesh: bpy.types.Mesh, ridges: tuple[Indices, ...]) -> NDArray[np.int32]:
    """For each edge the number of its crease, signed by direction."""
    runs = np.zeros(len(mesh.edges), np.int32)
    edge_at = {(int(a), int(b)): index for index, (a, b) in enumerate(_edges(mesh))}
    for number, ridge in enumerate(ridges, 1):
        for a, b in pairwise(ridge.tolist()):
            if (a, b) in edge_at:
                runs[edge_at[a, b]] = number
            else:
                runs[edge_at[b, a]] = -number
    return runs


def _read_ridges(sheet_object: bpy.types.Object) -> tuple[Indices, ...]:
    """The creases: edges marked so, as far as both ends are still in the group `ridge`."""
    mesh = sheet_object.data
    group = sheet_object.vertex_groups.get(RIDGE_GROUP)
    if _RUN not in mesh.attributes or group is None:
        return ()
    runs = read_values(mesh.attributes[_RUN].data, "value", 1, np.int32)
    marked = np.flatnonzero(runs)
    in_group = {
        vertex
        for vertex in np.unique(_edges(mesh)[marked]).tolist()
        if any(entry.group == group.index and entry.weight > 0 for entry in mesh.vertices[vertex].groups)
    }
    steps: dict[int, list[tuple[int, int]]] = {}
    for run, (a, b) in zip(runs[marked].tolist(), _edges(mesh)[marked].tolist(), strict=True):
        if a in in_group and b in in_group:
            steps.setdefault(abs(run), []).append((a, b) if run > 0 else (b, a))
    ridges: list[Indices] = []
    for number in sorted(steps):
        following = dict(steps[number])
        starts = [a for a in following if a not in set(following.values())] or list(following)[:1]
        for start in starts:
            line = [start]
            while line[-1] in following:
                line.append(following.pop(line[-1]))
            ridges.append(np.array(line, np.int64))
    return tuple(ridges)


def _read_boundary(mesh: bpy.types.Mesh, triangles: Indices) -> Indices:
    """The paper's edge: the edges with a triangle on one side only, from where it started when the mesh was made."""
    pairs = {(a, b) for a, b in directed_edges(triangles).tolist()}
    following = {a: b for a, b in pairs if (b, a) not in pairs}
    order = np.full(len(mesh.vertices), -1, np.int32)
    if _ORDER in mesh.attributes:
        order = read_values(mesh.attributes[_ORDER].data, "value", 1, np.int32)
    start = min(following, key=lambda vertex: (order[vertex] < 0, order[vertex]))
    loop = [start]
    while (after := following[loop[-1]]) != start and len(loop) <= len(following):
        loop.append(after)
    if len(loop) != len(following):
        raise StepFailed(f"{mesh.name} has holes or loose parts: fill or delete them, so that it has one edge.")
    placed = order[loop]
    if len(loop) > 2 and placed[-1] == 1:  # it was stored the other way round
        loop = [loop[0], *reversed(loop[1:])]
    return np.array(loop, np.int64)
