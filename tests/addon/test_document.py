"""The document in Blender shows what the photos show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from folded import folded_sheet
from origami.core.errors import StepFailed
from origami.origami_addon.files.image_files import write_jpeg
from origami.origami_addon.one_line import printable
from origami.origami_addon.scene.camera_object import VIEWS, undistorted, write_views
from origami.origami_addon.scene.document import find_document, remove_document
from origami.origami_addon.scene.document_frame import document_frame
from origami.origami_addon.scene.roles import SHEET
from origami.origami_addon.scene.save import save_document
from origami.origami_addon.scene.sheet_mesh import transform
from origami.origami_addon.scene.show import Pictures
from origami.origami_addon.scene.whole_document import build_document


@pytest.fixture
def case(empty_scene):
    return folded_sheet()


@pytest.fixture
def build(case, tmp_path):
    out = tmp_path / "Ausgabe ü 1"
    out.mkdir()
    (tmp_path / "Fotos").mkdir()
    write_jpeg(out / "page.jpg", case.photos[0], 100)
    write_jpeg(tmp_path / "Fotos" / "ü 0.jpg", case.photos[0], 72)
    photos = [tmp_path / "Fotos" / "ü 0.jpg"] * 2

    def build(name="Brief ü"):
        views = list(write_views(out / VIEWS, case.model.cameras, case.photos.__getitem__))
        pictures = Pictures(views, photos, pack=False)
        return build_document(name, case.state, pictures, out / "page.jpg").collection

    return build


def test_pictures_of_photos_with_the_longest_names(case, tmp_path):
    cameras = [replace(camera, name=number + 124 * "ü" + ".jpg") for number, camera in zip("12", case.model.cameras)]
    views = list(write_views(tmp_path / VIEWS, cameras, case.photos.__getitem__))
    assert len(set(views)) == len(cameras)
    assert all(path.is_file() for path in views)


@pytest.mark.parametrize("name", ["a\nb", "a\x1b[31m", "a\u2028b"])
def test_a_document_of_a_folder_with_control_characters(name):
    assert printable(name).isprintable()


def sheet_of(name):
    return find_document(name).object(SHEET)


def test_pictures_of_photos_with_very_long_names(case, tmp_path):
    cameras = [replace(camera, name="写真" * 40 + camera.name) for camera in case.model.cameras]
    views = list(write_views(tmp_path / VIEWS, cameras, case.photos.__getitem__))
    assert [path.name[:5] for path in views] == ["01_写真", "02_写真"]
    assert all(path.is_file() for path in views)


def test_camera_sees_each_vertex_where_the_photo_has_it(case, build):
    import bpy
    from bpy_extras.object_utils import world_to_camera_view

    collection = build()
    bpy.context.view_layer.update()
    sheet_object = sheet_of("Brief ü")
    cameras = [candidate for candidate in collection.objects if candidate.type == "CAMERA"]
    assert len(cameras) == 2
    for seen_by, camera in zip(cameras, case.model.cameras, strict=True):
        pinhole = replace(camera, distortion=np.zeros(2))
        for index in (0, 24, 300, 500, 774):
            vertex = sheet_object.matrix_world @ sheet_object.data.vertices[index].co
            x, y, _ = world_to_camera_view(bpy.context.scene, seen_by, vertex)
            expected = pinhole.project(case.sheet.vertices[index])
            np.testing.assert_allclose([x * camera.width, (1 - y) * camera.height], expected, atol=0.01)


def test_background_shows_the_photo_without_its_distortion(case):
    camera = case.model.cameras[0]
    straight = undistorted(case.photos[0], camera, 1000)
    assert straight.shape == case.photos[0].shape
    pinhole = replace(camera, distortion=np.zeros(2))
    for vertex in case.sheet.vertices[::97]:
        there = (pinhole.project(vertex) - 0.5).round().astype(int)
        pixel = camera.distort((there + 0.5 - camera.principal_point) / camera.focal_length) - 0.5
        column, row = pixel.round().astype(int)
        np.testing.assert_allclose(
            straight[there[1], there[0]].astype(int), case.photos[0][row, column].astype(int), atol=20
        )


def test_background_is_reduced_to_the_size_asked_for(case):
    assert undistorted(case.photos[0].astype(np.uint16) * 257, case.model.cameras[0], 300).shape == (240, 200, 3)


def test_page_lies_upright_and_in_true_size(case, build):
    build()
    mesh = sheet_of("Brief ü").data
    positions = np.array([vertex.co[:] for vertex in mesh.vertices])
    top_left, top_right, bottom_left = positions[[0, 24, 30 * 25]]
    np.testing.assert_allclose(np.linalg.norm(top_right - top_left), 0.160, rtol=1e-5)
    assert top_right[0] > top_left[0]
    assert top_left[1] > bottom_left[1]
    assert positions[:, 2].min() == pytest.approx(0, abs=1e-7)
    assert all(polygon.normal.z > 0 for polygon in mesh.polygons)


def test_page_of_unknown_size_is_one_unit_high(case):
    flat_case = folded_sheet(fold=0.0)
    flat = replace(
        flat_case.flat, uv=flat_case.flat.uv / 200, width=0.8, height=1.0, unit="page heights", world_scale=None
    )
    placed = transform(document_frame(flat_case.sheet, flat), flat_case.sheet.vertices)
    np.testing.assert_allclose(np.ptp(placed, axis=0), [0.8, 1.0, 0.0], atol=1e-9)


def test_points_have_their_colours(build):
    points = next(candidate for candidate in build().objects if candidate.name == "Brief ü points")
    color = points.data.attributes["color"].data[3].color_srgb
    np.testing.assert_allclose(color[:3], np.array([200, 100, 50]) / 255, atol=0.003)


def test_same_name_replaces_the_document_and_leaves_nothing_behind(build):
    import bpy

    kinds = ("objects", "meshes", "cameras", "materials", "images", "collections")
    build("other")
    build()
    before = {kind: sorted(item.name for item in getattr(bpy.data, kind)) for kind in kinds}
    build()
    assert {kind: sorted(item.name for item in getattr(bpy.data, kind)) for kind in kinds} == before


def test_removing_a_document_leaves_what_the_user_put_into_it(build):
    import bpy

    collection = build()
    made = set(bpy.data.objects)
    own_mesh = sheet_of("Brief ü").copy()
    own_mesh.data = bpy.data.meshes.new("own mesh")
    del own_mesh["origami_document"]
    curve = bpy.data.objects.new("own curve", bpy.data.curves.new("own curve", "CURVE"))
    light = bpy.data.objects.new("own light", bpy.data.lights.new("own light", "SUN"))
    empty = bpy.data.objects.new("own empty", None)
    own = {own_mesh, curve, light, empty}
    elsewhere = bpy.data.collections.new("elsewhere")
    nested = bpy.data.collections.new("nested")
    collection.children.link(nested)
    for each in own:
        collection.objects.link(each)
    elsewhere.objects.link(light)
    own_material = bpy.data.materials.new("own material")
    sheet_of("Brief ü").data.materials.append(own_material)
    own_mesh.data.materials.append(bpy.data.materials["Brief ü page"])
    assert len(made) == 8  # origin, two cameras, points, outline, sheet, page and its frame

    remove_document("Brief ü")
    assert set(bpy.data.objects) == own
    assert light.users_collection == (elsewhere,)
    for each in own - {light}:
        assert each.users_collection == (bpy.context.scene.collection,)
    assert list(bpy.context.scene.collection.children) == [nested]
    assert [material.name for material in bpy.data.materials] == ["Brief ü page", "own material"]
    assert [image.name for image in bpy.data.images] == ["Brief ü page"]
    assert [mesh.name for mesh in bpy.data.meshes] == ["own mesh"]
    assert len(bpy.data.cameras) == 0


def test_render_shows_the_page_as_bright_as_it_is(build, case, tmp_path):
    import bpy

    picture = tmp_path / "Ausgabe ü 1" / "page.jpg"
    write_jpeg(picture, np.full((100, 80, 3), (200, 128, 40), np.uint8), 100)
    build()
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = 4
    scene.cycles.use_denoising = False
    scene.render.resolution_percentage = 10
    scene.render.filepath = str(tmp_path / "render.png")
    bpy.ops.render.render(write_still=True)
    rendered = bpy.data.images.load(scene.render.filepath)
    pixels = np.array(rendered.pixels[:]).reshape(rendered.size[1], rendered.size[0], -1)
    middle = pixels[30:42, 24:36, :3].mean(axis=(0, 1)) * 255
    np.testing.assert_allclose(middle, (200, 128, 40), atol=12)


def test_light_of_the_scene_is_kept(build):
    import bpy

    world = bpy.context.scene.world = bpy.data.worlds.new("own world")
    build()
    assert bpy.context.scene.world == world
    assert len(bpy.data.worlds) == 1


def test_saved_file_opens_elsewhere_with_its_pictures(build, tmp_path):
    import bpy

    build()
    folder = tmp_path / "Ausgabe ü 1"
    save_document(folder / "document.blend")
    assert all("//" not in image.filepath for image in bpy.data.images)
    assert sorted(path.name for path in folder.iterdir()) == ["cameras", "document.blend", "page.jpg"]
    elsewhere = tmp_path / "moved"
    (tmp_path / "Fotos").rename(tmp_path / "Fotos-")
    (tmp_path / "Fotos-").rename(tmp_path / "Fotos")
    folder.rename(elsewhere)
    bpy.ops.wm.open_mainfile(filepath=str(elsewhere / "document.blend"))
    assert sheet_of("Brief ü") is not None
    for image in bpy.data.images:
        assert image.filepath.startswith("//")
        assert len(image.pixels) > 0
        assert image.has_data, image.filepath


def test_unwritable_place_is_reported(build, tmp_path):
    build()
    (tmp_path / "document.blend").mkdir()
    with pytest.raises(StepFailed, match=r"document\.blend could not be written"):
        save_document(tmp_path / "document.blend")


def test_missing_document_is_reported(empty_scene):
    with pytest.raises(StepFailed, match="no document"):
        find_document("nothing")
