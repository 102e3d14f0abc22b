"""The files of a finished document: 3D models, arrays and the map between page and photos."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core.camera import Camera
from ...core.checks.page_bound import bound_on_page
from ...core.page.texture import PageTexture
from ...core.page.warp import photo_to_page
from ...core.sheet import FlatMap, Sheet, sheet_arrays
from ..files.atomic import replacing
from ..scene.scratch_scene import alone
from ..scene.shape_keys import animate_opening
from ..scene.sheet_mesh import PAGE_UV

_LARGEST = 65535  # number of 16 bits
PHOTO_STEP = 8  # pixels between two entries of the map from a photo to the page

_MAP_README = """\
photo[row, column]      the photo that a page pixel comes from: an index into photo_names, -1 if in no photo
position                np.cumsum(position_delta, axis=1, dtype=np.uint16) / position_scale gives for [row, column] the
                        x, y in that photo, in pixels as stored in the file, with the centre of the first pixel at
                        (0.5, 0.5); meaningless where photo is -1
page_size, page_unit    of the page that the pixels cover; u points right, v down
to_page[k, row, column] u, v of the place that photo k shows at x = (column + 0.5) * photo_step,
                        y = (row + 0.5) * photo_step; NaN where it does not show the sheet; smaller photos are padded
                        with NaN to the size of the largest
"""


def write_glb(path: Path, sheet_object: bpy.types.Object) -> None:
    """Write the sheet as binary glTF with its page image and UV map, folded, and an animation in which it opens.

    Raises
    ------
    StepFailed
        If it could not be written (as for all functions here).
    """
    with replacing(path) as temporary, _page_only(sheet_object, opening=True):
        bpy.ops.export_scene.gltf(
            filepath=str(temporary), export_format="GLB", use_active_scene=True, export_force_sampling=False
        )


def write_obj(path: Path, sheet_object: bpy.types.Object) -> None:
    """Write the sheet as OBJ with the UV map of the page, and its material beside it."""
    with replacing(path) as temporary, _page_only(sheet_object):
        bpy.ops.wm.obj_export(
            filepath=str(temporary),
            export_normals=False,
            export_materials=True,
            path_mode="STRIP",
            apply_modifiers=False,
        )


def without_usd() -> str:
    """Why there can be no USD file; empty if this Blender was built with USD. Debian's was not."""
    if "usd_export" in dir(bpy.ops.wm):
        return ""
    return "This Blender was built without USD and cannot write sheet.usdz: use sheet.glb instead."


def write_usd(path: Path, sheet_object: bpy.types.Object) -> None:
    """Write the sheet as USDZ, the page image packed inside; its UV map has USD's own name for it, `st`."""
    with replacing(path) as temporary, _page_only(sheet_object):
        # y up and plain ASCII names: not every reader of USDZ takes the rest
        bpy.ops.wm.usd_export(
            filepath=str(temporary),
            selected_objects_only=True,
            export_animation=False,
            rename_uvmaps=True,
            export_custom_properties=False,
            convert_orientation=True,
            export_global_forward_selection="NEGATIVE_Z",
            export_global_up_selection="Y",
            allow_unicode=False,
        )


@contextmanager
def _page_only(sheet_object: bpy.types.Object, *, opening: bool = False) -> Iterator[None]:
    """A scene with the sheet as other programs should see it: folded, with only the page as its material and UV map.

    ``opening`` gives it an animation in which it opens.
    """
    copy = sheet_object.copy()
    mesh = copy.data = sheet_object.data.copy()
    copy.name = mesh.name = "sheet"
    actions: list[bpy.types.Action] = []
    try:
        materials = [material for material in mesh.materials if material is not None]
        mesh.materials.clear()
        for material in [material for material in materials if _shows_page(material)][:1]:
            mesh.materials.append(material)
        mesh.polygons.foreach_set("material_index", np.zeros(len(mesh.polygons), np.int32))
        for name in [layer.name for layer in mesh.uv_layers if layer.name != PAGE_UV]:
            mesh.uv_layers.remove(mesh.uv_layers[name])
        # many programs tint the material with the mesh's colours
        for name in [layer.name for layer in mesh.color_attributes]:
            mesh.color_attributes.remove(mesh.color_attributes[name])
        if opening:
            actions.append(animate_opening(copy))
        else:
            copy.shape_key_clear()
        with alone(copy):
            yield
    finally:
        bpy.data.objects.remove(copy)
        bpy.data.meshes.remove(mesh)
        bpy.data.batch_remove(actions)


def _shows_page(material: bpy.types.Material) -> bool:
    return any(node.type == "UVMAP" and node.uv_map == PAGE_UV for node in material.node_tree.nodes)


def write_sheet(path: Path, sheet: Sheet, flat: FlatMap, cameras: Sequence[Camera]) -> None:
    """Write the sheet, its flat map and the cameras as arrays (npz).

    ``xyz`` and ``cam_centers`` are in the frame of the structure from motion; ``uv`` has u to the right and v down,
    both in ``unit``. The other entries of the cameras are the attributes of `Camera`, one row for each camera.
    both in ``unit``. ``uv_bound``, in the same unit, is how far each vertex is at most, nine times in ten, from its
    place on the page; NaN if that is not known.
    """
    arrays = sheet_arrays(sheet)
    arrays.pop("bound", None)
    bound = bound_on_page(sheet, flat)
    _write_arrays(
        path,
        xyz=arrays.pop("vertices"),
        uv=flat.uv,
        uv_bound=np.full(len(flat.uv), np.nan) if bound is None else bound,
        **arrays,
        page_size=np.array([flat.width, flat.height]),
        unit=np.array(flat.unit),
        mm_per_world_unit=np.array(np.nan if flat.world_scale is None else flat.world_scale),
        cam_names=np.array([camera.name for camera in cameras]),
        cam_centers=np.array([camera.center for camera in cameras]),
        cam_sizes=np.array([(camera.width, camera.height) for camera in cameras]),
        cam_focal_lengths=np.array([camera.focal_length for camera in cameras]),
        cam_principal_points=np.array([camera.principal_point for camera in cameras]),
        cam_distortions=np.array([camera.distortion for camera in cameras]),
        cam_rotations=np.array([camera.rotation for camera in cameras]),
        cam_translations=np.array([camera.translation for camera in cameras]),
    )


def write_map(path: Path, texture: PageTexture, sheet: Sheet, flat: FlatMap, cameras: Sequence[Camera]) -> None:
    """Write where in which photo each page pixel comes from, and where each photo's pixels are on the page (npz).

    The file's own entry ``readme`` says how to read it.
    """
    largest = max(max(camera.width, camera.height) for camera in cameras)
    # The finest fraction of a pixel with which positions fit into 16 bits: 1/16 up to 4096 pixels.
    scale = 2 ** int(np.log2(_LARGEST / largest))
    position = np.rint(np.nan_to_num(texture.position) * scale).astype(np.uint16)
    delta = np.diff(position, axis=1, prepend=np.uint16(0))
    to_page = [photo_to_page(sheet, flat, camera, PHOTO_STEP) for camera in cameras]
    rows, columns = (max(grid.shape[axis] for grid in to_page) for axis in (0, 1))
    stacked = np.full((len(cameras), rows, columns, 2), np.nan, np.float32)
    for index, grid in enumerate(to_page):
        stacked[index, : grid.shape[0], : grid.shape[1]] = grid
    _write_arrays(
        path,
        readme=np.array(_MAP_README),
        photo_names=np.array([camera.name for camera in cameras]),
        photo=texture.photo,
        position_delta=delta,
        position_scale=np.array(scale),
        page_size=np.array([flat.width, flat.height]),
        page_unit=np.array(flat.unit),
        to_page=stacked,
        photo_step=np.array(PHOTO_STEP),
    )


def _write_arrays(path: Path, **arrays: NDArray[Any]) -> None:
    with replacing(path) as temporary:
        np.savez_compressed(temporary, **arrays)
