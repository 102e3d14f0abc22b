"""A finished document as its photo, its sheet and its page, and the sheet unfolded."""

from __future__ import annotations

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

from .hands import Waits
from .user import User

_DRAWN_SECONDS = 2.0  # until software OpenGL has drawn the view
_SHARES = 0.0, 1 / 3, 2 / 3, 1.0  # how far the sheet is opened in the manual's picture
_UNFOLD_PERCENT, _UNFOLD_TOP = 40, 200  # its size, and the pixels above the sheet that are left out
_FILLED = 0.75  # of the view's free width or height, at least


def scene(user: User) -> Waits:
    """Each way by its button, there and back, and the slider."""
    user.hands.forget_places()
    before = _scene_settings()
    yield from _way(user, "PHOTO")
    user.check("the photo is seen through a camera", _view().view_perspective == "CAMERA")
    yield from _way(user, "PAGE")
    user.check("the page is seen from straight above", _view().view_perspective == "ORTHO")
    user.check("the scene is as before the photo", _scene_settings() == before, _scene_settings())
    user.check("the page fills the view", _share(user, "page") > _FILLED, _share(user, "page"))
    yield from _way(user, "SHEET")
    user.check("the sheet is seen in space", _view().view_perspective == "PERSP")
    user.check("the sheet fills the view", _share(user, "sheet") > _FILLED, _share(user, "sheet"))
    yield from _unfold(user)
    yield from _way(user, "PHOTO")
    yield from _way(user, "PHOTO")
    yield from _way(user, "SHEET")
    user.check("pressing twice restores as well", _scene_settings() == before, _scene_settings())
    user.check("nothing counts as edited", not user.module("scene.edits").edits(user.document()))


def _unfold(user: User) -> Waits:
    slider = user.module("scene.shape_keys").unfold_slider(user.document().object("sheet"))
    user.check("the sheet is folded at first", slider.value == 0, slider.value)
    _show_sheet_alone(user, alone=True)
    views = []
    for share in _SHARES:
        slider.value = share
        yield _DRAWN_SECONDS
        views.append(user.hands.pixels(user.hands.box(user.hands.region("WINDOW")))[_UNFOLD_TOP:])
    user.hands.keep("unfold", np.hstack(views), percent=_UNFOLD_PERCENT)
    user.check("unfolding is no edit", not user.module("scene.edits").edits(user.document()))
    slider.value = 0.0
    _show_sheet_alone(user, alone=False)
    yield _DRAWN_SECONDS


def _show_sheet_alone(user: User, alone: bool) -> None:
    """For a picture: no page, no creases, and nothing of Blender's over the view."""
    space = user.hands.area().spaces.active
    space.overlay.show_overlays = space.show_gizmo = bpy.context.scene.origami.show_creases = not alone
    user.document().object("page").hide_set(alone)


def _way(user: User, way: str) -> Waits:
    yield from user.hands.press(f"show_as(way='{way}')")
    yield from user.hands.over()
    yield _DRAWN_SECONDS
    user.hands.picture(f"shown_as_{way.lower()}")


def _view() -> bpy.types.RegionView3D:
    areas = [area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D"]
    return areas[0].spaces.active.region_3d


def _share(user: User, role: str) -> float:
    """How much of the view a part of the document fills, in the direction that it fills more; 0 if part is outside."""
    region, part = user.hands.region("WINDOW"), user.document().object(role)
    corners = [part.matrix_world @ Vector(corner) for corner in part.bound_box]
    seen = np.array([location_3d_to_region_2d(region, _view(), corner) for corner in corners])
    size = np.array([region.width, region.height])
    if (seen < 0).any() or (seen > size).any():
        return 0.0
    return float((np.ptp(seen, axis=0) / size).max())


def _scene_settings() -> list[object]:
    scene = bpy.context.scene
    camera = None if scene.camera is None else scene.camera.name
    return [camera, scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage]
