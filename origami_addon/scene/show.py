"""Puts the results of the stages into the scene, a little at a time, to keep the window responsive."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
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
from .document import Document
from .document_frame import document_frame, first_frame
from .free_ground import give_origin
from .outline_curve import outline_to_object, set_outline
from .page_object import frame_to_object, page_to_object, set_page_size
from .paper_material import paper_material
from .points_mesh import move_points, points_to_object
from .roles import CAMERA, OTHER_PAGE, OUTLINE, PAGE, PAGE_FRAME, POINTS, SHEET
from .shape_keys import put_unfolding
from .sheet_materials import PAGE_MATERIAL, PHOTO_MATERIAL, has_photo, page_image, set_material, use_material
from .sheet_mesh import PAGE_UV, PHOTO_UV, put_groups, put_sheet


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
    if not has_photo(document, sheet_object, photo):
        set_material(document, sheet_object, PHOTO_MATERIAL, photo, PHOTO_UV)
    use_material(sheet_object, PHOTO_MATERIAL, PHOTO_UV)
    yield


def show_page(document: Document, state: LaidOut, picture: Path, *, pack: bool) -> Iterator[None]:
    """Show the page on the sheet, and flat beside it."""
    document.remove(OTHER_PAGE)  # they lie on the page as it was
    sheet_object = document.object(SHEET)
    material = set_material(document, sheet_object, PAGE_MATERIAL, picture, PAGE_UV)
    use_material(sheet_object, PAGE_MATERIAL, PAGE_UV)
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


def _hide(shown: bpy.types.Object) -> None:
    """Hide an object in each view layer that has it; layers from which the user excludes the document do not."""
    for scene in shown.users_scene:
        for layer in scene.view_layers:
            with suppress(RuntimeError):
                shown.hide_set(True, view_layer=layer)
