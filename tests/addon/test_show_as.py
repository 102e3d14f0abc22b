"""One click shows a document as its photo, its sheet or its page, and leaves the user's scene as it was."""

from __future__ import annotations

import numpy as np
import pytest
from folded import folded_sheet
from folded_document import folded_document

CASE = folded_sheet()


@pytest.fixture
def document(tmp_path):
    """A finished document beside a camera of the user's, in Blender's default scene."""
    import bpy
    from origami import register, unregister

    bpy.ops.wm.read_factory_settings()
    register()
    made = folded_document("letter", CASE, tmp_path)
    bpy.context.scene.origami.document = made.collection
    yield made
    unregister()


def settings():
    import bpy

    scene = bpy.context.scene
    return scene.camera, scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage


def view_area():
    import bpy

    return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")


def show(way):
    import bpy

    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        return bpy.ops.origami.show_as(way=way)


def shown(document):
    import bpy
    from origami.origami_addon.scene.view import shown_way

    return shown_way(document, bpy.context.scene, view_area().spaces.active)


def test_each_way_is_shown_and_the_scene_is_as_before(document):
    before = settings()
    shading = view_area().spaces.active.shading
    (background,) = document.objects("camera")[CASE.state.region.reference].data.background_images
    for way in ("PAGE", "PHOTO", "PHOTO", "SHEET", "PHOTO", "PAGE"):
        assert show(way) == {"FINISHED"}
        assert shown(document) == way
        assert (settings() == before) == (way != "PHOTO")
        assert background.display_depth == ("FRONT" if way == "PHOTO" else "BACK")
        assert not shading.show_xray  # the objects are there when the user turns the view
    assert before[0].name == "Camera"


@pytest.mark.parametrize("way", ["PHOTO", "SHEET", "PAGE"])
def test_no_line_from_a_camera_crosses_the_sheet(document, way):
    overlay = view_area().spaces.active.overlay
    assert overlay.show_relationship_lines
    show(way)
    assert not overlay.show_relationship_lines


def test_the_page_hides_the_axes_of_the_ground(document):
    page, frame = document.object("page"), document.object("page frame")
    assert page.location.z > 0
    assert page.location == frame.location


def test_the_photo_is_that_of_the_reference_camera(document):
    show("PHOTO")
    camera, width, height, _ = settings()
    assert camera["photo"] == CASE.state.reference.name
    assert (width, height) == (CASE.state.reference.width, CASE.state.reference.height)


def test_looking_through_the_camera_shows_the_sheet_before_its_photo(document):
    import bpy
    from origami.origami_addon.operators.look import look_through

    show("PHOTO")
    camera = bpy.context.scene.camera
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        look_through(bpy.context, camera)
    assert [each.display_depth for each in camera.data.background_images] == ["BACK"]


def test_a_camera_that_the_user_chose_meanwhile_stays(document):
    import bpy

    show("PHOTO")
    mine = bpy.data.objects.new("mine", bpy.data.cameras.new("mine"))
    bpy.context.scene.collection.objects.link(mine)
    bpy.context.scene.camera = mine
    show("SHEET")
    assert bpy.context.scene.camera == mine


def test_no_camera_stands_before_the_page_and_those_that_the_user_hid_stay_hidden(document):
    from origami.origami_addon.scene.view import keep_cameras_aside

    first, *others = document.objects("camera")
    first.hide_set(True)
    for way in ("PAGE", "PAGE", "SHEET", "PAGE", "PHOTO"):
        assert show(way) == {"FINISHED"}
        assert first.hide_get()
        assert {each.hide_get() for each in others} == {way == "PAGE"}
    keep_cameras_aside(document, hidden=False)
    assert first.hide_get()


def test_views_of_another_file_are_not_restored(document, tmp_path):
    import bpy
    from origami.origami_addon.operators import show_as

    show("PHOTO")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    assert show_as._before is None


@pytest.mark.parametrize(("way", "role"), [("PAGE", "page"), ("SHEET", "sheet")])
def test_it_is_in_the_middle_of_the_view(document, way, role):
    """In background mode Blender does not say what covers the view: the window's scene `showing` looks there."""
    document.object("origin").location = (3, -2, 1)
    document.object("origin").rotation_euler = (0.2, 0.1, 0.7)
    show(way)
    view = view_area().spaces.active.region_3d
    part = document.object(role)
    corners = np.array([part.matrix_world @ type(part.location)(corner) for corner in part.bound_box])
    away = np.array(view.view_rotation.to_matrix())[:, 2]
    assert away @ np.array(part.matrix_world.to_3x3())[:, 2] == pytest.approx(1 if way == "PAGE" else np.cos(0.9))
    size = np.linalg.norm(np.ptp(corners, axis=0))
    assert np.linalg.norm(np.array(view.view_location) - corners.mean(axis=0)) < 0.2 * size
    assert 0.5 * size < view.view_distance < 3 * size
