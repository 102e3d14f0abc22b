"""Points the window's 3D views at the document."""

from __future__ import annotations

from typing import Literal

import bpy
import numpy as np
from mathutils import Quaternion

from ...core.arrays import Array
from .document import Document, document_of
from .mesh_values import read_values, world_corners
from .roles import CAMERA, PAGE, PAGE_FRAME, POINTS, SHEET
from .sheet_materials import page_image

Way = Literal["PHOTO", "SHEET", "PAGE"]

_DISTANCE = 2.6  # of the eye, in radii of the target
_VIEW_MM = 72  # Blender's view is so wide along its longer side, at its lens's distance
_MARGIN = 1.06  # of the view's size, to that of what fills it
_FROM_THE_SIDE = 0.9  # radians from straight above
_SAME_DIRECTION = 1e-3  # radians
_HIDDEN = "hidden_for_page"  # of a camera
_NEAR_SHARE = 90  # per cent of the points that count: some are far behind the sheet


def look_at(document: Document) -> None:
    """Turn the 3D views in the open windows to the document, except those that look through a camera.

    They show the sheet with its picture and keep their direction; other workspaces stay as they are.
    """
    bpy.context.view_layer.update()
    places = _places(document)
    if not len(places):
        return
    low, high = places.min(axis=0), places.max(axis=0)
    radius = float(np.linalg.norm(high - low)) / 2
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type != "VIEW_3D" or area.spaces.active.region_3d.view_perspective == "CAMERA":
                continue
            view = area.spaces.active.region_3d
            view.view_location = (low + high) / 2
            view.view_distance = _DISTANCE * radius
            show_pictures(area.spaces.active)


def shown_way(document: Document, scene: bpy.types.Scene, space: bpy.types.SpaceView3D) -> Way:
    """The way in which a 3D view shows a document; in space if in no other."""
    view, page = space.region_3d, document.object(PAGE)
    if view.view_perspective == "CAMERA":
        return "PHOTO" if document_of(scene.camera) is not None else "SHEET"
    turned = 1.0 if page is None else view.view_rotation.rotation_difference(_facing(page)).angle
    return "PAGE" if view.view_perspective == "ORTHO" and turned < _SAME_DIRECTION else "SHEET"


def show_way(document: Document, way: Way, screen: bpy.types.Screen) -> bool:
    """Turn a window's 3D views to the sheet or to the page; its image editors get the page.

    The sheet is seen from the side, the page straight from above, without the cameras, which would stand before it;
    either fills the view beside the sidebars.

    Returns
    -------
    bool
        Whether anything shows it now.
    """
    target = document.object(SHEET if way == "SHEET" else PAGE)
    if target is None:
        return False
    keep_cameras_aside(document, hidden=way == "PAGE")
    bpy.context.view_layer.update()
    corners = world_corners(target)
    rotation = _facing(target) @ Quaternion((1, 0, 0), _FROM_THE_SIDE if way == "SHEET" else 0.0)
    seen = (corners - corners.mean(axis=0)) @ np.array(rotation.to_matrix())
    views = [area for area in screen.areas if area.type == "VIEW_3D"]
    editors = [area for area in screen.areas if area.type == "IMAGE_EDITOR" and way == "PAGE"]
    for area in editors:
        area.spaces.active.image = page_image(document)
    for area in views:
        space = area.spaces.active
        space.region_3d.view_perspective = "ORTHO" if way == "PAGE" else "PERSP"
        space.region_3d.view_rotation = rotation
        _fill(area, corners.mean(axis=0), np.ptp(seen, axis=0))
        space.shading.type = "SOLID"
        show_pictures(space)
    return bool(views or editors)


def show_pictures(space: bpy.types.SpaceView3D) -> None:
    """Show the pictures of the sheet and the page in a 3D view in Solid shading, without lines across them."""
    space.shading.light = "FLAT"  # the photo has its own light
    space.shading.color_type = "TEXTURE"
    space.overlay.show_relationship_lines = False  # from each camera to the document's origin, in the sheet's middle


def redraw_views() -> None:
    """Draw all 3D views again: Blender does not know that something is drawn over them."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def keep_cameras_aside(document: Document, *, hidden: bool) -> None:
    """Hide the cameras, or show those again that this function has hidden."""
    layer = bpy.context.view_layer
    for camera in document.objects(CAMERA):
        if layer.objects.get(camera.name) != camera:
            continue
        if hidden and camera.visible_get():
            camera.hide_set(True)
            camera[_HIDDEN] = True
        elif not hidden and camera.pop(_HIDDEN, False):
            camera.hide_set(False)


def _facing(target: bpy.types.Object) -> Quaternion:
    """How a view is turned that looks straight down at something with its upper side up."""
    return target.matrix_world.to_quaternion()


def _fill(area: bpy.types.Area, middle: Array, size: Array) -> None:
    """Move a 3D view so that something fills what the sidebars and headers leave of it.

    Parameters
    ----------
    area : bpy.types.Area
        Its view has its direction.
    middle : (3,) array
        In the world.
    size : (3,) array
        Width, height and depth, as seen from there.
    """
    space = area.spaces.active
    low, high, whole = _uncovered(area)
    per_pixel = _MARGIN * float((size[:2] / np.maximum(high - low, 1)).max())
    space.region_3d.view_distance = per_pixel * whole.max() * space.lens / _VIEW_MM + size[2] / 2
    aside = np.append((whole - low - high) / 2 * per_pixel, 0)
    space.region_3d.view_location = middle + np.array(space.region_3d.view_rotation.to_matrix()) @ aside


def _uncovered(area: bpy.types.Area) -> tuple[Array, Array, Array]:
    """The lower left and upper right corner of what sidebars and headers leave of a 3D view, and its size; pixels."""
    view = next(region for region in area.regions if region.type == "WINDOW")
    whole = np.array([view.width, view.height], float)
    low, high = np.zeros(2), whole.copy()
    for region in area.regions:
        over = region.type != "WINDOW" and min(region.width, region.height) > 1
        if not over or region.x >= view.x + view.width or region.y >= view.y + view.height:
            continue
        left, bottom = region.x - view.x, region.y - view.y
        if region.alignment == "LEFT":
            low[0] = max(low[0], left + region.width)
        elif region.alignment == "RIGHT":
            high[0] = min(high[0], left)
        elif region.alignment == "BOTTOM":
            low[1] = max(low[1], bottom + region.height)
        elif region.alignment == "TOP":
            high[1] = min(high[1], bottom)
    return low, high, whole


def _places(document: Document) -> np.ndarray:
    """Points (N, 3) around the visible results: sheet and page, or before these cameras and sparse points."""
    found = [np.zeros((0, 3))]
    for role in (SHEET, PAGE_FRAME):
        found += [world_corners(each) for each in document.objects(role)]
    if len(found) == 1:
        found += [np.array(each.matrix_world.translation)[None] for each in document.objects(CAMERA)]
        for each in document.objects(POINTS):
            positions = read_values(each.data.vertices, "co", 3, np.float32)
            distance = np.linalg.norm(positions - np.median(positions, axis=0), axis=1)
            found.append(positions[distance <= np.percentile(distance, _NEAR_SHARE)])
    return np.concatenate(found)
