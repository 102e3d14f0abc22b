"""The sheet and its flat map as a Blender mesh, and back.

Whatever an artist may edit is ordinary Blender data: positions are vertices, the page is the UV layer `page`, creases
and the paper's edge are the vertex groups `ridge` and `boundary`. Two integer attributes keep the order of the vertices
along each crease and around the edge, in a form that survives editing of the mesh.
"""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array, Indices
from ...core.camera import Camera
from ...core.checks.page_bound import bound_on_page
from ...core.errors import StepFailed
from ...core.flat.distortion import measure_strain
from ...core.numeric.triangles import closed_loops, directed_edges, one_part, rim
from ...core.sheet import FlatMap, Sheet
from .color_scale import WORST_BOUND, WORST_STRETCH, colors
from .mesh_values import read_values, set_attribute, set_group
from .ridge_group import put_ridges, read_ridges
from .shape_keys import clear_shape_keys, move_vertices

PAGE_UV, PHOTO_UV = "page", "photo"
PHOTO_DEPTH = "photo_depth"  # of a vertex: depth from the reference camera along its axis, in any unit
STRETCH_COLOR, BOUND_COLOR = "stretch color", "page bound color"
PAGE_BOUND = "page_bound"  # of a vertex: how far it is at most, nine times in ten, from its place, in the page's unit
BOUNDARY_GROUP = "boundary"
_NO_EDGES = np.zeros((0, 2), np.int64)
_ORDER = "boundary_order"  # of a vertex: its place along the paper's edge, -1 inside
_FRAME, _PAGE_SIZE, _PAGE_UNIT, _WORLD_SCALE = (
    "origami_frame",
    "origami_page_size",
    "origami_page_unit",
    "origami_world_scale",
)


def sheet_to_object(name: str, sheet: Sheet, flat: FlatMap | None, reference: Camera, frame: Array) -> bpy.types.Object:
    """Make a mesh object of a sheet, not in a collection yet; parameters as for `put_sheet`."""
    sheet_object = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    put_sheet(sheet_object, sheet, flat, reference, frame)
    put_groups(sheet_object, sheet)
    return sheet_object


def put_sheet(
    sheet_object: bpy.types.Object, sheet: Sheet, flat: FlatMap | None, reference: Camera, frame: Array
) -> None:
    """Give an object's mesh the shape of a sheet; materials, and UV layers and shape keys of the same mesh, stay.

    Its vertex groups are still those of the old shape: see `put_groups`.

    Parameters
    ----------
    sheet_object : bpy.types.Object
        In Object Mode.
    sheet : Sheet
    flat : FlatMap or None
        None if the sheet is not flat yet: then there is no UV layer `page`. Otherwise the faces get the attributes
        `stretch`, `area_distortion` and `angle_distortion`, and the vertices `page_bound` if it is known.
    reference : Camera
        The photo of the UV layer `photo`; the coordinates include its lens distortion.
    frame : (4, 4) array
        Similarity from the world frame of the sparse model to Blender's, metres.
    """
    mesh = sheet_object.data
    positions = transform(frame, sheet.vertices)
    if _has_triangles(mesh, sheet.triangles):
        move_vertices(mesh, positions.astype(np.float32))
    else:
        clear_shape_keys(sheet_object)  # they have other vertices
        mesh.clear_geometry()
        _set_geometry(mesh, positions, sheet.triangles, sheet.ridges)
    corner = sheet.triangles.reshape(-1)
    if flat is not None:
        if PAGE_UV not in mesh.uv_layers and PHOTO_UV in mesh.uv_layers:  # the page's must be the first
            mesh.uv_layers.remove(mesh.uv_layers[PHOTO_UV])
        set_uv(mesh, PAGE_UV, page_uv(flat)[corner])
        _set_strain(mesh, sheet, flat)
        _set_bound(mesh, sheet, flat)
    elif PAGE_UV in mesh.uv_layers:
        mesh.uv_layers.remove(mesh.uv_layers[PAGE_UV])
    set_uv(mesh, PHOTO_UV, photo_uv(reference, sheet.vertices)[corner])
    mesh.uv_layers.active = mesh.uv_layers[PAGE_UV if flat is not None else PHOTO_UV]
    mesh.uv_layers.active.active_render = True
    depth = reference.to_camera_frame(sheet.vertices)[:, 2].astype(np.float32)
    set_attribute(mesh, PHOTO_DEPTH, "FLOAT", "POINT", depth)
    order = np.full(len(sheet.vertices), -1, np.int32)
    order[sheet.boundary] = np.arange(len(sheet.boundary))
    set_attribute(mesh, _ORDER, "INT", "POINT", order)
    sheet_object[_FRAME] = [float(value) for value in frame.reshape(-1)]
    if flat is not None:
        sheet_object[_PAGE_SIZE] = [float(flat.width), float(flat.height)]
        sheet_object[_PAGE_UNIT] = flat.unit
        sheet_object[_WORLD_SCALE] = float("nan") if flat.world_scale is None else float(flat.world_scale)


def put_groups(sheet_object: bpy.types.Object, sheet: Sheet) -> None:
    """Store the sheet's creases and its edge as vertex groups of an object with its shape."""
    put_ridges(sheet_object, sheet)
    set_group(sheet_object, BOUNDARY_GROUP, sheet.boundary)


def _has_triangles(mesh: bpy.types.Mesh, triangles: Indices) -> bool:
    """Whether the mesh consists of exactly these triangles, in this order."""
    if len(mesh.loops) != triangles.size or len(mesh.polygons) != len(triangles):
        return False
    return bool((read_values(mesh.loops, "vertex_index", 1, np.int32) == triangles.reshape(-1)).all())


def _set_strain(mesh: bpy.types.Mesh, sheet: Sheet, flat: FlatMap) -> None:
    strain = measure_strain(sheet.vertices, sheet.triangles, flat.uv)
    for attribute in ("stretch", "area_distortion", "angle_distortion"):
        values = np.nan_to_num(getattr(strain, attribute)).astype(np.float32)
        set_attribute(mesh, attribute, "FLOAT", "FACE", values)
    _set_colors(mesh, STRETCH_COLOR, colors(strain.stretch, WORST_STRETCH).repeat(3, axis=0))


def _set_bound(mesh: bpy.types.Mesh, sheet: Sheet, flat: FlatMap) -> None:
    bound = bound_on_page(sheet, flat)
    if bound is None:
        for name in (PAGE_BOUND, BOUND_COLOR):
            if name in mesh.attributes:
                mesh.attributes.remove(mesh.attributes[name])
        return
    set_attribute(mesh, PAGE_BOUND, "FLOAT", "POINT", bound.astype(np.float32))
    _set_colors(mesh, BOUND_COLOR, colors(bound / flat.height, WORST_BOUND)[sheet.triangles.reshape(-1)])


def _set_colors(mesh: bpy.types.Mesh, name: str, of_corners: NDArray[np.float32]) -> None:
    shown = mesh.color_attributes.get(name) or mesh.color_attributes.new(name, "BYTE_COLOR", "CORNER")
    shown.data.foreach_set("color_srgb", of_corners.reshape(-1))


def is_unchanged(sheet_object: bpy.types.Object, sheet: Sheet, frame: Array) -> bool:
    """Whether an object's mesh is still what `put_sheet` made of a sheet, except for its creases and UV layers."""
    mesh = sheet_object.data
    if not _has_triangles(mesh, sheet.triangles) or len(mesh.vertices) != len(sheet.vertices):
        return False
    positions = read_values(mesh.vertices, "co", 3, np.float32)
    return bool((positions == transform(frame, sheet.vertices).astype(np.float32)).all())


def read_flat(sheet_object: bpy.types.Object) -> FlatMap | None:
    """The flat map of every vertex from the UV layer `page`; None if there is no such layer."""
    mesh = sheet_object.data
    if PAGE_UV not in mesh.uv_layers:
        return None
    width, height = sheet_object[_PAGE_SIZE]
    corner_uv = read_values(mesh.uv_layers[PAGE_UV].uv, "vector", 2, np.float32).astype(float)
    uv = np.zeros((len(mesh.vertices), 2))
    uv[read_values(mesh.loops, "vertex_index", 1, np.int32)] = corner_uv
    scale = sheet_object[_WORLD_SCALE]
    return FlatMap(
        np.column_stack([uv[:, 0], 1 - uv[:, 1]]) * (width, height),
        width,
        height,
        sheet_object[_PAGE_UNIT],
        None if np.isnan(scale) else scale,
    )


def object_to_sheet(sheet_object: bpy.types.Object) -> tuple[Sheet, FlatMap | None]:
    """Read a sheet back from its mesh, as it is now; the flat map is None if there is no UV layer `page`.

    Positions come back in the sparse model's frame, in Blender's single precision. Vertices without a face are left
    out, larger faces are cut into triangles.

    Raises
    ------
    StepFailed
        If the object is not a sheet, or is no longer one piece.
    """
    mesh = sheet_object.data
    if sheet_object.type != "MESH" or _FRAME not in sheet_object or not mesh.polygons:
        raise StepFailed(f"{sheet_object.name} is not a sheet: select the sheet's object, or run Build Surface again.")
    mesh.calc_loop_triangles()
    triangles = read_values(mesh.loop_triangles, "vertices", 3, np.int32).astype(np.int64)
    frame = np.array(sheet_object[_FRAME]).reshape(4, 4)
    vertices = transform(np.linalg.inv(frame), read_values(mesh.vertices, "co", 3, np.float32).astype(float))
    used = np.unique(triangles)
    number = np.full(len(vertices), -1)
    number[used] = np.arange(len(used))
    flat = read_flat(sheet_object)
    ridges = [number[ridge] for ridge in read_ridges(sheet_object, None if flat is None else flat.uv)]
    sheet = Sheet(
        vertices[used],
        number[triangles],
        tuple(kept for ridge in ridges if len(kept := ridge[ridge >= 0]) > 1),
        number[_read_boundary(mesh, triangles)],
    )
    return sheet, None if flat is None else replace(flat, uv=flat.uv[used])


def pinned_vertices(sheet_object: bpy.types.Object) -> Indices:
    """The vertices pinned in the UV layer `page`, by their numbers in the sheet that `object_to_sheet` reads."""
    mesh = sheet_object.data
    layer = mesh.uv_layers.get(PAGE_UV)
    if layer is None or len(layer.pin) != len(mesh.loops):
        return np.zeros(0, np.int64)
    corner_vertex = read_values(mesh.loops, "vertex_index", 1, np.int32)
    pinned = np.unique(corner_vertex[read_values(layer.pin, "value", 1, bool)])
    return np.searchsorted(np.unique(corner_vertex), pinned)


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
    # Where a line does not follow the triangles, its edges are loose edges.
    edges = np.unique(np.sort(np.concatenate([np.stack([a[:-1], a[1:]], 1) for a in lines] or [_NO_EDGES])), axis=0)
    mesh.edges.add(len(edges))
    mesh.edges.foreach_set("vertices", edges.astype(np.int32).reshape(-1))
    mesh.update(calc_edges=True)
    if mesh.validate():
        raise StepFailed(
            f"The mesh {mesh.name} has faces that Blender cannot hold (doubled, or with a repeated corner): change "
            "Grid Rows (--grid-rows) by one and run again."
        )
    mesh.shade_smooth()


def set_uv(mesh: bpy.types.Mesh, name: str, uv: Array) -> None:
    """Set a UV layer, created if missing, to coordinates of the mesh's corners (L, 2), v up.

    Raises
    ------
    StepFailed
        If the mesh has as many as Blender allows.
    """
    layer = mesh.uv_layers.get(name) or mesh.uv_layers.new(name=name, do_init=False)
    if layer is None:
        raise StepFailed(f"{mesh.name} has {len(mesh.uv_layers)} UV maps, as many as Blender allows: remove some.")
    layer.uv.foreach_set("vector", uv.astype(np.float32).reshape(-1))


def _read_boundary(mesh: bpy.types.Mesh, triangles: Indices) -> Indices:
    """The paper's edge: the longest run of edges with a triangle on one side only; the others go around holes.

    It starts at the same vertex as when the mesh was made, if that still exists.
    """
    edges = directed_edges(triangles)
    edge_of_paper = rim(triangles)
    twice = len(edges) - len(np.unique(edges[:, 0] * len(mesh.vertices) + edges[:, 1]))
    if twice or len(np.unique(edge_of_paper[:, 0])) < len(edge_of_paper) or not one_part(triangles):
        raise StepFailed(
            f"{mesh.name} is no longer one piece of paper: delete its loose parts, and faces that hang by a corner or "
            "share an edge with two others."
        )
    longest = max(closed_loops(triangles), key=len)
    order = np.full(len(mesh.vertices), -1, np.int32)
    if _ORDER in mesh.attributes:
        order = read_values(mesh.attributes[_ORDER].data, "value", 1, np.int32)
    placed = np.where(order[longest] < 0, np.iinfo(np.int32).max, order[longest])
    longest = np.roll(longest, -int(np.argmin(placed)))
    if len(longest) > 2 and order[longest[-1]] == 1:  # it was stored in the other direction
        longest = np.concatenate([longest[:1], longest[:0:-1]])
    return longest
