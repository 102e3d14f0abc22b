"""Points the window's 3D views at the document."""

from __future__ import annotations

import bpy
import numpy as np

from .document import Document
from .mesh_values import read_values, world_corners
from .show import CAMERA, PAGE, PAGE_FRAME, POINTS, SHEET

_DISTANCE = 2.6  # of the eye, in radii of the target
_PAGE_DISTANCE = 1.5  # of the eye, in longer sides of the page: with Blender's lens of 50 mm all of it is in view
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
            area.spaces.active.shading.light = "FLAT"  # the photo has its own light
            area.spaces.active.shading.color_type = "TEXTURE"


def look_down_at_page(document: Document, screen: bpy.types.Screen) -> bool:
    """Show the flat page in the 3D views of a window, straight from above and filling them.

    Returns
    -------
    bool
        Whether the document has a page and the window a 3D view.
    """
    page, areas = document.object(PAGE), [area for area in screen.areas if area.type == "VIEW_3D"]
    if page is None or not areas:
        return False
    corners = world_corners(page)
    low, high = corners.min(axis=0), corners.max(axis=0)
    for area in areas:
        space = area.spaces.active
        view = space.region_3d
        view.view_perspective = "ORTHO"
        view.view_rotation = page.matrix_world.to_quaternion()
        view.view_location = (low + high) / 2
        view.view_distance = _PAGE_DISTANCE * float((high - low).max())
        space.shading.type, space.shading.light, space.shading.color_type = "SOLID", "FLAT", "TEXTURE"
    return True


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
