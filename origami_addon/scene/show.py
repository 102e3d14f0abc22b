"""Puts the results of the stages into the scene, a little at a time, to keep the window responsive."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import bpy
import numpy as np

from ...core.arrays import Array
from ...core.camera import Camera
from ...core.errors import StepFailed
from ...core.sheet import FlatMap
from ..stages import about
from ..state import Found, LaidOut, Placed, Surfaced
from .camera_object import camera_to_object, pose_camera, set_background
from .document import Document, document_frame, document_of, first_frame, new_document, remove_document
from .free_ground import give_origin
from .outline_curve import outline_to_object, set_outline
from .page_object import frame_to_object, page_to_object, set_page_size
from .paper_material import paper_material
from .points_mesh import move_points, points_to_object
from .shape_keys import put_unfolding
from .sheet_mesh import PAGE_UV, PHOTO_UV, put_groups, put_sheet
from .unfolding import unfolding

CAMERA, POINTS, OUTLINE, SHEET, PAGE, PAGE_FRAME = "camera", "points", "outline", "sheet", "page", "page frame"
OTHER_PAGE = "other page"
_PAGE_MATERIAL, _PHOTO_MATERIAL = "page", "photo"
PICTURE = "origami_picture"  # of an image: document and use


@dataclass(frozen=True)
class Pictures:
    """Where a document's pictures are.

    Attributes
    ----------
    views : sequence of Path
        The background of each camera.
    photos : sequence of Path
        The photo of each camera.
    pack : bool
        Whether the views and the page are packed into the .blend.
    """

    views: Sequence[Path]
    photos: Sequence[Path]
    pack: bool


def show_cameras(document: Document, state: Placed, pictures: Pictures) -> Iterator[None]:
    """Add one camera for each placed photo, and the points; those of an earlier run are removed."""
    model = state.model
    for role in (OTHER_PAGE, PAGE_FRAME, PAGE, SHEET, OUTLINE, CAMERA, POINTS):
        document.remove(role)
        yield
    document.frame = first_frame(model)
    give_origin(document)
    points = points_to_object(f"{document.title} points", model, document.frame)
    document.add(points, POINTS)
    _hide(points)
    yield
    for camera, view in zip(model.cameras, pictures.views, strict=True):
        camera_object = camera_to_object(f"{document.title} {camera.name}", camera, document.frame)
        camera_object["photo"] = camera.name
        document.add(camera_object, CAMERA)
        image = set_background(camera_object, view)
        document.own(image)
        if pictures.pack:
            image.pack()
        yield


def show_outline(document: Document, state: Found) -> Iterator[None]:
    """Show the paper's edge in front of the reference camera."""
    reference = state.reference
    camera_object = find_camera(document, reference)
    distance = float(np.linalg.norm(camera_object.matrix_basis.translation))
    outline = document.object(OUTLINE)
    if outline is None:
        outline = outline_to_object(f"{document.title} outline", state.region.outline.polygon, reference, distance)
        document.add(outline, OUTLINE)
    else:
        set_outline(outline, state.region.outline.polygon, reference, distance)
    _hang_before(outline, camera_object)
    points = document.object(POINTS)
    if points is not None:
        move_points(points, state.model, document.frame)
    yield


def show_sheet(document: Document, state: Surfaced, pictures: Pictures, shapes: Array | None = None) -> Iterator[None]:
    """Show the sheet in space, with its UV map for the reference photo and, once it is flat, for the page.

    ``shapes`` are those of a flat sheet on its way there, from `unfolding`.
    """
    flat = state.flat if isinstance(state, LaidOut) else None
    frame = document.frame if flat is None else document_frame(state.sheet, flat)
    yield from move_document(document, state, frame)
    sheet_object = document.object(SHEET)
    if sheet_object is None:
        sheet_object = bpy.data.objects.new(f"{document.title} sheet", bpy.data.meshes.new(f"{document.title} sheet"))
        document.add(sheet_object, SHEET)
    put_sheet(sheet_object, state.sheet, flat, state.sheet_reference, document.frame)
    yield
    put_groups(sheet_object, state.sheet)
    yield
    if shapes is not None:
        put_unfolding(sheet_object, shapes)
        yield
    photo = pictures.photos[state.region.reference]
    if not _has_photo(document, sheet_object, photo):
        _set_material(document, sheet_object, _PHOTO_MATERIAL, photo, PHOTO_UV)
    _use_material(sheet_object, _PHOTO_MATERIAL, PHOTO_UV)
    yield


def show_page(document: Document, state: LaidOut, picture: Path, *, pack: bool) -> Iterator[None]:
    """Show the page on the sheet, and flat beside it."""
    document.remove(OTHER_PAGE)  # they lie on the page as it was
    sheet_object = document.object(SHEET)
    material = _set_material(document, sheet_object, _PAGE_MATERIAL, picture, PAGE_UV)
    _use_material(sheet_object, _PAGE_MATERIAL, PAGE_UV)
    yield
    image = page_image(document)
    assert image is not None
    if pack:
        image.pack()
    yield
    page_object, frame_object = document.object(PAGE), document.object(PAGE_FRAME)
    if page_object is None:
        page_object = page_to_object(f"{document.title} page", PAGE_UV)
        page_object.data.materials.append(material)
        document.add(page_object, PAGE)
    if frame_object is None:
        frame_object = frame_to_object(f"{document.title} page frame")
        document.add(frame_object, PAGE_FRAME)
    for each in (page_object, frame_object):
        set_page_size(each, state.flat)
    yield


def show_other_page(document: Document, flat: FlatMap, name: str, picture: Path) -> Iterator[None]:
    """Show the page of other photos flat beside the page; one of the same name is replaced."""
    title = f"{document.name} {name}"
    for each in document.objects(OTHER_PAGE):
        if each["other_photos"] == name:
            document.remove_object(each)
    yield
    image = bpy.data.images.load(str(picture))
    image.name = title
    image.pack()
    yield
    page_object = page_to_object(title, PAGE_UV)
    page_object["other_photos"] = name
    material = paper_material(title, image, PAGE_UV)
    page_object.data.materials.append(material)
    document.own(image, material)
    document.add(page_object, OTHER_PAGE)
    for place, each in enumerate(document.objects(OTHER_PAGE), 1):
        set_page_size(each, flat, place)
    yield


def build_document(name: str, state: LaidOut, pictures: Pictures, page: Path) -> Document:
    """Put a whole document into the scene at once, for a file of its own; one of the same name is replaced.

    The page is face up on the ground plane, readable from above, in true size if the paper's size is known; otherwise
    the page is one unit high.

    Parameters
    ----------
    name : str
    state : LaidOut
    pictures : Pictures
    page : Path
        The page image.
    """
    remove_document(name)
    document = new_document(name, bpy.context.scene)
    document.state = state
    for _ in chain(
        show_cameras(document, state, pictures),
        show_outline(document, state),
        show_sheet(document, state, pictures, unfolding(state.sheet, state.flat)),
        show_page(document, state, page, pack=pictures.pack),
    ):
        pass
    if not _is_the_users(bpy.context.scene):
        _set_up(bpy.context.scene, find_camera(document, state.reference), state)
    return document


def move_document(document: Document, state: Placed, frame: Array) -> Iterator[None]:
    """Move cameras and points to their places in ``frame``, the similarity (4, 4) from the sparse model to Blender."""
    document.frame = frame
    for camera in state.model.cameras:
        pose_camera(find_camera(document, camera), camera, frame)
        yield
    points = document.object(POINTS)
    if points is not None:
        move_points(points, state.model, frame)
    outline = document.object(OUTLINE)
    if outline is not None and isinstance(state, Found):
        camera_object = find_camera(document, state.reference)
        distance = float(np.linalg.norm(camera_object.matrix_basis.translation))
        set_outline(outline, state.region.outline.polygon, state.reference, distance)
        _hang_before(outline, camera_object)
    yield


def _hang_before(outline: bpy.types.Object, camera_object: bpy.types.Object) -> None:
    """Put the outline back into its camera's frame, from which the user may have removed or moved it."""
    outline.parent = camera_object
    outline.matrix_parent_inverse.identity()
    outline.matrix_basis.identity()


def find_camera(document: Document, camera: Camera) -> bpy.types.Object:
    """The object for a camera of the document's sparse model.

    Raises
    ------
    StepFailed
        If the user has removed it.
    """
    for each in document.objects(CAMERA):
        if each["photo"] == camera.name:
            return each
    raise StepFailed(
        f"The camera of {camera.name} is no longer in the collection {document.collection.name}: bring it back, or run "
        f"{about('place').verb} again."
    )


def page_image(document: Document) -> bpy.types.Image | None:
    """The page as a Blender image, or None if there is none yet."""
    return next((each for each in bpy.data.images if each.get(PICTURE) == f"{document.name} {_PAGE_MATERIAL}"), None)


def _has_photo(document: Document, sheet_object: bpy.types.Object, photo: Path) -> bool:
    """Whether the sheet already has a material of this photo, which is large and slow to load and draw again."""
    name = f"{document.name} {_PHOTO_MATERIAL}"
    shown = next((each for each in bpy.data.images if each.get(PICTURE) == name), None)
    used = any(each is not None and each.get("use") == _PHOTO_MATERIAL for each in sheet_object.data.materials)
    return used and shown is not None and Path(bpy.path.abspath(shown.filepath)) == photo


def _set_material(
    document: Document, sheet_object: bpy.types.Object, use: str, picture: Path, uv_layer: str
) -> bpy.types.Material:
    """The sheet's material for a use, created if missing; its picture is reloaded."""
    name = f"{document.name} {use}"
    before = next((each for each in bpy.data.images if each.get(PICTURE) == name), None)
    image = bpy.data.images.load(str(picture))
    image[PICTURE] = name
    document.own(image)
    if before is not None:
        before.user_remap(image)
        bpy.data.images.remove(before)
    image.name = name
    material = next((each for each in sheet_object.data.materials if each is not None and each.get("use") == use), None)
    if material is None:
        material = paper_material(name, image, uv_layer)
        material["use"] = use
        document.own(material)
        sheet_object.data.materials.append(material)
    return material


def _use_material(sheet_object: bpy.types.Object, use: str, uv_layer: str) -> None:
    """Show the sheet in one of its materials, which becomes the first, with the UV layer that belongs to it."""
    mesh = sheet_object.data
    place = next(index for index, each in enumerate(mesh.materials) if each is not None and each.get("use") == use)
    mesh.materials[0], mesh.materials[place] = mesh.materials[place], mesh.materials[0]
    # Solid shading uses the active layer, whatever the material says.
    mesh.uv_layers.active = mesh.uv_layers[uv_layer]
    mesh.uv_layers[uv_layer].active_render = True


def _hide(shown: bpy.types.Object) -> None:
    """Hide an object in each view layer that has it; layers from which the user excludes the document do not."""
    for scene in shown.users_scene:
        for layer in scene.view_layers:
            with suppress(RuntimeError):
                shown.hide_set(True, view_layer=layer)


def _is_the_users(scene: bpy.types.Scene) -> bool:
    """Whether the scene's camera is not from a document: then its settings are the user's."""
    return scene.camera is not None and document_of(scene.camera) is None


def _set_up(scene: bpy.types.Scene, camera_object: bpy.types.Object, state: LaidOut) -> None:
    """Show the page's colours unchanged, in millimetres if the page has them, through the reference camera."""
    scene.camera = camera_object
    scene.render.resolution_x, scene.render.resolution_y = state.reference.width, state.reference.height
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    if scene.world is None:
        scene.world = _even_light()
    if state.flat.unit == "mm":
        scene.unit_settings.system = "METRIC"
        scene.unit_settings.length_unit = "MILLIMETERS"


def _even_light() -> bpy.types.World:
    """White light from everywhere: a render shows the paper as bright as its picture."""
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
