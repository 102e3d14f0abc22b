"""One document in a Blender file: a collection with its cameras, sparse points and sheet."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from ..core.camera import Array, Camera
from ..core.errors import StepFailed
from ..core.sheet import FlatMap, Sheet
from ..core.sparse_model import SparseModel
from ..core.warp import Photo, sample
from .atomic import replacing
from .image_files import to_eight_bits, write_jpeg
from .sheet_mesh import PAGE_UV, PHOTO_UV, sheet_to_object, transform

CAMERA_PHOTOS = "cameras"  # folder beside the .blend with the photos as pinhole cameras would have taken them
_MARK = "origami_document"  # of the collection and of all that was made for it: the document's name
_SENSOR_MM = 36.0
_VIEW_PIXELS = 1600  # the longer side of a camera's background picture, at most


@dataclass(frozen=True)
class DocumentFiles:
    """Where a document's pictures lie.

    Attributes
    ----------
    folder : Path
        Of the .blend; the pictures behind the cameras are written into ``cameras`` there.
    page : Path
        The page image.
    reference_photo : Path
    """

    folder: Path
    page: Path
    reference_photo: Path


def build_document(
    name: str,
    model: SparseModel,
    sheet: Sheet,
    flat: FlatMap,
    reference: int,
    read_photo: Callable[[int], Photo],
    files: DocumentFiles,
) -> bpy.types.Collection:
    """Put a document into the scene; one of the same name is replaced.

    The page lies face up on the ground plane as it would be read from above, in true size where the paper's size is
    known; otherwise the page is one unit high.

    Parameters
    ----------
    name : str
    model : SparseModel
    sheet : Sheet
    flat : FlatMap
    reference : int
        Index of the reference photo among ``model.cameras``.
    read_photo : callable
        ``read_photo(index)`` gives the pixels of ``model.cameras[index]``.
    files : DocumentFiles

    Returns
    -------
    bpy.types.Collection
        With objects ``<name> sheet``, ``<name> points`` and one camera for each photo.

    Raises
    ------
    StepFailed
        If the cameras' pictures could not be written.
    """
    remove_document(name)
    scene = bpy.context.scene
    collection = bpy.data.collections.new(name)
    collection[_MARK] = name
    scene.collection.children.link(collection)
    frame = document_frame(sheet, flat)

    sheet_object = sheet_to_object(f"{name} sheet", sheet, flat, model.cameras[reference], frame)
    sheet_object.data.materials.append(_paper(f"{name} page", files.page, PAGE_UV))
    sheet_object.data.materials.append(_paper(f"{name} photo", files.reference_photo, PHOTO_UV))
    _add(collection, sheet_object)
    _add(collection, _points_object(f"{name} points", model, frame))
    for index, camera in enumerate(model.cameras):
        camera_object = camera_to_object(f"{name} {camera.name}", camera, frame)
        stem = re.sub(r"[^\w.-]+", "_", camera.name.rsplit(".", 1)[0])
        picture = files.folder / CAMERA_PHOTOS / f"{index + 1:02d}_{stem}.jpg"
        _set_background(camera_object, camera, read_photo(index), picture)
        _add(collection, camera_object)
        if index == reference:
            scene.camera = camera_object
    _set_scene(scene, model.cameras[reference], flat)
    return collection


def find_sheet_object(name: str) -> bpy.types.Object:
    """The sheet of the document ``name``.

    Raises
    ------
    StepFailed
        If the file has no such document.
    """
    for collection in bpy.data.collections:
        if collection.get(_MARK) == name:
            for candidate in collection.objects:
                if candidate.get(_MARK) == name and candidate.type == "MESH" and PAGE_UV in candidate.data.uv_layers:
                    return candidate
    raise StepFailed(f"This .blend holds no sheet of a document {name!r}: rectify its photos first.")


def remove_document(name: str) -> None:
    """Remove the document's collection and what was made for it.

    What else lies in the collection is the user's and moves to the scene; data that anything else uses stay.
    """
    top = bpy.context.scene.collection
    for collection in [c for c in bpy.data.collections if c.get(_MARK) == name]:
        for inside in list(collection.objects):
            if inside.get(_MARK) == name:
                bpy.data.objects.remove(inside)
            elif inside.users_collection == (collection,):
                top.objects.link(inside)
        for inside in list(collection.children):
            if inside.name not in top.children:
                top.children.link(inside)
        bpy.data.collections.remove(collection)
    # Users before what they use: materials and cameras before their images.
    for kind in (bpy.data.meshes, bpy.data.cameras, bpy.data.materials, bpy.data.images):
        for data in [d for d in kind if d.get(_MARK) == name and d.users == 0]:
            kind.remove(data)


def save_document(path: Path) -> None:
    """Save the whole file as a copy; its pictures stay where they are, named by paths relative to it.

    Raises
    ------
    StepFailed
        If it could not be written.
    """
    here = {image: image.filepath_raw for image in bpy.data.images if image.filepath_raw}
    try:
        for image, picture in here.items():
            # On Windows there is no relative path to another drive.
            with suppress(ValueError):
                relative = os.path.relpath(bpy.path.abspath(picture), path.parent)
                image.filepath_raw = "//" + Path(relative).as_posix()
        with replacing(path) as temporary:
            bpy.ops.wm.save_as_mainfile(filepath=str(temporary), copy=True, compress=True, relative_remap=False)
    finally:
        for image, picture in here.items():
            image.filepath_raw = picture


def document_frame(sheet: Sheet, flat: FlatMap) -> Array:
    """The similarity (4, 4) from the sparse model's frame to Blender's, in metres.

    It lays the sheet as near to its flat page as a rigid motion can: u along x, v against y, the printed side up, the
    page's middle over the origin and the sheet's lowest point on the ground.
    """
    center = np.array([flat.width, flat.height]) / 2
    target = np.column_stack([(flat.uv - center) * (1, -1), np.zeros(len(flat.uv))])
    source_mean, target_mean = sheet.vertices.mean(axis=0), target.mean(axis=0)
    source, target = sheet.vertices - source_mean, target - target_mean
    left, stretch, right = np.linalg.svd(target.T @ source)
    signs = np.array([1, 1, np.sign(np.linalg.det(left @ right))])
    rotation = (left * signs) @ right
    if flat.world_scale is not None:
        metres_per_unit, scale = 1e-3, flat.world_scale * 1e-3
    else:
        metres_per_unit = 1 / flat.height
        scale = metres_per_unit * (stretch * signs).sum() / (source**2).sum()
    frame = np.eye(4)
    frame[:3, :3] = scale * rotation
    frame[:3, 3] = target_mean * metres_per_unit - frame[:3, :3] @ source_mean
    frame[2, 3] -= transform(frame, sheet.vertices)[:, 2].min()
    return frame


def camera_to_object(name: str, camera: Camera, frame: Array) -> bpy.types.Object:
    """A Blender camera that sees what ``camera`` does, but for the lens distortion, which Blender's have not.

    The scene's resolution must have the photo's aspect.
    """
    data = bpy.data.cameras.new(name)
    longer = max(camera.width, camera.height)
    data.sensor_fit = "HORIZONTAL" if camera.width >= camera.height else "VERTICAL"
    data.sensor_width = data.sensor_height = _SENSOR_MM
    data.lens = camera.focal_length * _SENSOR_MM / longer
    data.shift_x = (camera.width / 2 - camera.principal_point[0]) / longer
    data.shift_y = (camera.principal_point[1] - camera.height / 2) / longer
    data.clip_start = 1e-3
    camera_object = bpy.data.objects.new(name, data)
    scale = np.cbrt(np.linalg.det(frame[:3, :3]))
    pose = np.eye(4)
    # Blender's cameras look along -z with y up.
    pose[:3, :3] = frame[:3, :3] / scale @ camera.rotation.T @ np.diag([1, -1, -1])
    pose[:3, 3] = transform(frame, camera.center[None])[0]
    data.display_size = 0.1 * float(np.linalg.norm(pose[:3, 3]))
    camera_object.matrix_world = Matrix(pose.tolist())
    camera_object["photo_size"] = [camera.width, camera.height]
    return camera_object


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


def _set_background(camera_object: bpy.types.Object, camera: Camera, photo: Photo, picture: Path) -> None:
    try:
        picture.parent.mkdir(exist_ok=True)
    except OSError as error:
        raise StepFailed(
            f"The folder {picture.parent} could not be made ({error.strerror}): choose another output folder."
        ) from error
    write_jpeg(picture, undistorted(photo, camera, _VIEW_PIXELS), dpi=72, quality=85)
    camera_object.data.show_background_images = True
    background = camera_object.data.background_images.new()
    background.image = bpy.data.images.load(str(picture))
    background.alpha = 1.0
    background.display_depth = "BACK"
    background.frame_method = "STRETCH"


def _add(collection: bpy.types.Collection, made: bpy.types.Object) -> None:
    """Put an object just made into the document and mark it and all that it consists of."""
    collection.objects.link(made)
    data = made.data
    if made.type == "CAMERA":
        parts = [background.image for background in data.background_images]
    else:
        nodes = [node for material in data.materials for node in material.node_tree.nodes]
        parts = [*data.materials, *(node.image for node in nodes if node.type == "TEX_IMAGE")]
    for each in (made, data, *parts):
        each[_MARK] = collection[_MARK]


def _points_object(name: str, model: SparseModel, frame: Array) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(model.points))
    mesh.vertices.foreach_set("co", transform(frame, model.points).astype(np.float32).reshape(-1))
    colors = np.full((len(model.points), 4), 1, np.float32)
    colors[:, :3] = model.colors / np.float32(255)
    mesh.attributes.new("color", "BYTE_COLOR", "POINT").data.foreach_set("color_srgb", colors.reshape(-1))
    mesh.update()
    return bpy.data.objects.new(name, mesh)


def _paper(name: str, picture: Path, uv_layer: str) -> bpy.types.Material:
    """Matt paper with the picture on it; of the kind that exporters understand."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True  # always so, and deprecated, from Blender 5.0 on
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    surface = nodes.new("ShaderNodeBsdfPrincipled")
    surface.inputs["Roughness"].default_value = 1.0
    surface.inputs["Specular IOR Level"].default_value = 0.0
    texture = nodes.new("ShaderNodeTexImage")
    coordinates = nodes.new("ShaderNodeUVMap")
    texture.image = bpy.data.images.load(str(picture))
    texture.extension = "EXTEND"
    coordinates.uv_map = uv_layer
    links.new(coordinates.outputs["UV"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], surface.inputs["Base Color"])
    links.new(surface.outputs["BSDF"], output.inputs["Surface"])
    for place, node in enumerate((coordinates, texture, surface, output)):
        node.location = (300 * place, 0)
    return material


def _set_scene(scene: bpy.types.Scene, reference: Camera, flat: FlatMap) -> None:
    scene.render.resolution_x, scene.render.resolution_y = reference.width, reference.height
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"  # colours of the page as they are
    if scene.world is None:
        scene.world = _even_light()
    if flat.unit == "mm":
        scene.unit_settings.system = "METRIC"
        scene.unit_settings.length_unit = "MILLIMETERS"


def _even_light() -> bpy.types.World:
    """White from everywhere: a render shows the paper as bright as its picture."""
    world = bpy.data.worlds.new("even light")
    if world.node_tree is None:
        world.use_nodes = True  # always so, and deprecated, from Blender 5.0 on
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputWorld")
    background = nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    links.new(background.outputs["Background"], output.inputs["Surface"])
    background.location, output.location = (0, 0), (300, 0)
    return world
