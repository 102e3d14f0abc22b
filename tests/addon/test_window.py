"""The window's buttons, through the operators behind them: rectify, edit by hand, re-run from there."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from meshes import ensure_pins


def draw_outline(margin: float) -> None:
    """Make the outline a rectangle with some points along its sides, inset by a distance into the reference photo."""
    from origami.origami_addon.scene.document import documents
    from origami.origami_addon.scene.outline_curve import set_outline
    from origami.origami_addon.state import Found

    (document,) = documents()
    camera = document.reached(Found).reference
    corners = np.array([[margin, margin], [1 - margin, margin], [1 - margin, 1 - margin], [margin, 1 - margin]])
    set_outline(document.object("outline"), corners * (camera.width, camera.height), camera, 1.0)


@pytest.fixture(scope="module")
def finished(lasting_add_on, small_set, colmap_model, tmp_path_factory) -> Path:
    """A .blend with the small set rectified by the big button."""
    import bpy

    folder = tmp_path_factory.mktemp("window") / "Brief ü"
    shutil.copytree(small_set.photos[0].path.parent, folder)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert bpy.ops.origami.add_photos(directory=f"{folder}/", preset="letter", new=True) == {"FINISHED"}
    settings = bpy.data.collections["Brief ü"].origami.settings
    settings.colmap_model = str(colmap_model)
    settings.surface.grid_rows = 40
    # The default judges creases by many fits; what the window does with a surface is the same for all methods.
    settings.surface.method = "ridge_aware"
    # These photos only show the sheet: no edge can be found in them, so it is drawn.
    assert bpy.ops.origami.run_stage(stage="place") == {"FINISHED"}
    assert bpy.ops.origami.run_stage(stage="find") == {"FINISHED"}
    draw_outline(0.08)
    assert bpy.ops.origami.rectify() == {"FINISHED"}
    path = folder.parent / "finished.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture
def document(finished, reopen):
    """The finished document, reopened."""
    return reopen(finished)


def stages(document) -> dict:
    group = document.collection.origami
    return {name: getattr(group, name) for name in ("place", "find", "surface", "unwrap", "lay_out", "page")}


def test_every_stage_is_done_and_shown(document):
    assert all(stage.done for stage in stages(document).values())
    roles = [each["origami_role"] for each in document.collection.objects]
    assert set(roles) == {"origin", "camera", "outline", "page", "page frame", "points", "sheet"}
    assert roles.count("camera") == json.loads(stages(document)["place"].figures)["photos_placed"] == 6
    sheet = document.object("sheet")
    assert {"page", "photo"} <= {layer.name for layer in sheet.data.uv_layers}
    assert sheet.data.materials[0]["use"] == "page"


def test_the_scene_keeps_its_own_settings(document):
    """Even one without a camera, a world and units of the user's."""
    import bpy

    scene = bpy.context.scene
    assert scene.camera is None and scene.world is None
    factory = bpy.data.scenes.new("factory")
    for group, names in {
        "render": ("resolution_x", "resolution_y", "resolution_percentage"),
        "view_settings": ("view_transform", "look", "exposure"),
        "unit_settings": ("system", "length_unit", "scale_length"),
    }.items():
        for name in names:
            assert getattr(getattr(scene, group), name) == getattr(getattr(factory, group), name), name


def test_pictures_are_part_of_the_file(document):
    import bpy

    shown = [image for image in bpy.data.images if image.get("origami_document") and "photo" not in image.name]
    assert len(shown) == 7
    assert all(image.packed_file is not None and image.size[0] > 0 for image in shown)


def test_what_nobody_touched_comes_back_to_the_last_bit(document):
    from origami.origami_addon.plan import first_stale
    from origami.origami_addon.scene.known import known_of
    from origami.origami_addon.scene.read_back import read_back
    from origami.origami_addon.state import state_arrays

    read = read_back(document)
    assert read.edited == frozenset()
    assert first_stale(known_of(document)) is None
    kept, back = state_arrays(document.state), state_arrays(read.state)
    assert kept.keys() == back.keys()
    for name, array in kept.items():
        np.testing.assert_array_equal(array, back[name])


def test_looking_is_no_edit_and_moving_is(document):
    """The panel shows this without reading the scene: it survives undo and reopening the file."""
    import bpy
    from origami.origami_addon.scene.edits import edits

    sheet = document.object("sheet")
    for each in ("outline", "sheet", "page frame"):
        bpy.context.view_layer.objects.active = document.object(each)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.view_layer.update()
    assert bpy.ops.origami.show_sheet(by="VERTEX") == {"FINISHED"}
    bpy.context.view_layer.update()
    assert edits(document) == frozenset()
    height = sheet.data.vertices[200].co.z
    sheet.data.vertices[200].co.z += 0.01
    sheet.data.update()
    bpy.context.view_layer.update()
    assert edits(document) == {"vertices"}
    sheet.data.vertices[200].co.z = height
    sheet.data.update()
    bpy.context.view_layer.update()
    assert edits(document) == frozenset()


def test_an_edit_is_known_after_the_file_was_opened(document, tmp_path):
    import bpy
    from origami.origami_addon.scene.document import documents
    from origami.origami_addon.scene.edits import edits

    document.object("sheet").data.vertices[200].co.z += 0.01
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "edited.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "edited.blend"))
    (opened,) = documents()
    assert edits(opened) == {"vertices"}


def test_a_moved_vertex_is_unwrapped_again(document):
    import bpy
    from origami.origami_addon.plan import first_stale
    from origami.origami_addon.scene.known import known_of
    from origami.origami_addon.scene.read_back import read_back

    vertex = document.object("sheet").data.vertices[200]
    vertex.co.z += 0.01
    before = document.state
    read = read_back(document)
    assert read.edited == {"vertices"}
    assert first_stale(known_of(document)) == "unwrap"
    assert bpy.ops.origami.rectify() == {"FINISHED"}
    after = document.state
    moved = np.linalg.norm(after.sheet.vertices - before.sheet.vertices, axis=1) * document.frame[0, 0]
    assert np.flatnonzero(moved > 1e-4).tolist() == [200] or moved[200] == moved.max() > 1e-4
    assert np.abs(after.flat.uv - before.flat.uv).max() > 0.1  # mm
    np.testing.assert_array_equal(after.region.outline.polygon, before.region.outline.polygon)
    assert read_back(document).edited == frozenset()


def test_a_moved_outline_cuts_the_sheet_again(document):
    import bpy
    from origami.origami_addon.plan import first_stale
    from origami.origami_addon.scene.known import known_of
    from origami.origami_addon.scene.read_back import read_back
    from origami.origami_addon.state import Surfaced

    before = document.state
    points = document.object("outline").data.splines[0].points
    assert len(points) == 4
    lowest = min(points, key=lambda point: point.co.x + point.co.y)
    lowest.co.x *= 0.9
    lowest.co.y *= 0.9
    read = read_back(document)
    assert read.edited == {"outline"}
    assert first_stale(known_of(document)) == "surface"
    assert bpy.ops.origami.run_stage(stage="surface") == {"FINISHED"}
    after = document.state
    kept = set(map(tuple, before.region.outline.polygon)) & set(map(tuple, after.region.outline.polygon))
    assert len(kept) == 3
    assert type(after) is Surfaced
    assert [name for name, stage in stages(document).items() if stage.done] == ["place", "find", "surface"]
    assert bpy.ops.origami.rectify() == {"FINISHED"}
    assert document.state.flat.width / document.state.flat.height != before.flat.width / before.flat.height


def delete_points(document, count: int) -> None:
    import bmesh

    points = document.object("points")
    edited = bmesh.new()
    edited.from_mesh(points.data)
    edited.verts.ensure_lookup_table()
    bmesh.ops.delete(edited, geom=edited.verts[:count], context="VERTS")
    edited.to_mesh(points.data)
    edited.free()


def test_deleted_points_do_not_count(document):
    import bpy
    from origami.origami_addon.scene.read_back import read_back

    count = len(document.object("points").data.vertices)
    delete_points(document, 20)
    read = read_back(document)
    assert read.edited == {"points"}
    assert len(read.state.model.points) == count - 20
    assert bpy.ops.origami.run_stage(stage="surface") == {"FINISHED"}
    assert len(document.state.model.points) == count - 20
    assert read_back(document).edited == frozenset()


def test_finding_the_sheet_again_forgets_the_drawn_outline_and_deleted_points_wait_for_the_surface(document):
    import bpy
    from origami.origami_addon.scene.read_back import read_back

    assert len(document.state.region.outline.polygon) == 4
    count = len(document.object("points").data.vertices)
    delete_points(document, 20)
    assert bpy.ops.origami.run_stage(stage="find") == {"FINISHED"}
    assert len(document.state.region.outline.polygon) > 100
    assert len(document.state.model.points) == count
    assert read_back(document).edited == {"points"}
    with pytest.raises(RuntimeError, match="Build Surface is not done yet"):
        bpy.ops.origami.turn_page(clockwise=True)


def test_a_step_begins_where_something_was_edits(document):
    import bpy
    from origami.origami_addon.scene.read_back import read_back

    count = len(document.object("points").data.vertices)
    delete_points(document, 20)
    assert bpy.ops.origami.run_stage(stage="page") == {"FINISHED"}
    assert len(document.state.model.points) == count - 20
    assert read_back(document).edited == frozenset()
    assert all(stage.done for stage in stages(document).values())


def test_a_paper_size_that_was_meant_in_inches_is_asked_about(document):
    import bpy

    page = document.collection.origami.settings.page
    page.paper, page.width, page.height = "other", 8.5, 11
    with pytest.raises(RuntimeError, match=r"did you mean Letter or 8\.5x11in"):
        bpy.ops.origami.rectify()
    page.width, page.height = 80, 0
    assert bpy.ops.origami.rectify() == {"FINISHED"}


def test_a_step_without_those_before_it_says_which(document):
    import bpy

    assert bpy.ops.origami.run_stage(stage="place") == {"FINISHED"}
    for stage in ("surface", "unwrap", "page"):
        with pytest.raises(RuntimeError, match="Find Sheet is not done yet: run it first"):
            bpy.ops.origami.run_stage(stage=stage)


def test_edit_mode_meanwhile_is_left(document, monkeypatch):
    import bpy
    from origami.origami_addon.jobs.process import Job
    from origami.origami_addon.scene.modes import set_mode

    said = Job.messages

    def messages(job, wait=0.0):
        set_mode(document.object("sheet"), "EDIT")
        return said(job, wait)

    monkeypatch.setattr(Job, "messages", messages)
    document.collection.origami.settings.surface.grid_rows = 36
    assert bpy.ops.origami.rectify() == {"FINISHED"}
    assert all(stage.done for stage in stages(document).values())


def test_a_deleted_camera_is_reported_before_anything_changes(document):
    import bpy

    before = document.state_digest()
    bpy.data.objects.remove(document.objects("camera")[1])
    with pytest.raises(RuntimeError, match=r"The camera of .* is no longer in the collection"):
        bpy.ops.origami.run_stage(stage="unwrap")
    assert document.state_digest() == before


def test_a_deleted_sheet_comes_back_with_the_page(document):
    import bpy

    bpy.data.objects.remove(document.object("sheet"))
    assert bpy.ops.origami.run_stage(stage="page") == {"FINISHED"}
    assert document.object("sheet") is not None


def test_a_result_that_no_longer_fits_is_not_taken(document, monkeypatch):
    import bpy
    from origami.origami_addon.jobs.process import Job

    said = Job.messages

    def messages(job, wait=0.0):
        stages(document)["surface"].done = False  # as Undo leaves it
        return said(job, wait)

    monkeypatch.setattr(Job, "messages", messages)
    before = document.state_digest()
    with pytest.raises(RuntimeError, match="changed while the work ran"):
        bpy.ops.origami.run_stage(stage="unwrap")
    assert document.state_digest() == before


def test_dragged_uvs_make_the_page_as_dragged(document):
    import bpy
    from origami.origami_addon.plan import first_stale
    from origami.origami_addon.scene.known import known_of
    from origami.origami_addon.scene.read_back import read_back
    from origami.origami_addon.window.stage_text import state_of

    blank = json.loads(stages(document)["page"].figures)["blank_share"]
    layer = document.object("sheet").data.uv_layers["page"]
    for corner in layer.uv:
        corner.vector.x = 0.5 + 0.9 * (corner.vector.x - 0.5)
    read = read_back(document)
    assert read.edited == {"page"}
    assert first_stale(known_of(document)) == "page"
    document.object("sheet").data.update_tag()
    bpy.context.view_layer.update()
    edited = [stage for stage in stages(document) if state_of(document, stage).icon == "FILE_REFRESH"]
    assert edited == ["page"]  # Unwrap would discard the drag
    assert bpy.ops.origami.rectify() == {"FINISHED"}
    after = json.loads(stages(document)["page"].figures)["blank_share"]
    assert 1 - after == pytest.approx(0.9 * (1 - blank), rel=0.01)
    assert read_back(document).edited == frozenset()


def test_turning_the_page(document):
    import bpy
    from origami.origami_addon.scene.sheet_materials import page_image

    width, height = page_image(document).size
    assert bpy.ops.origami.turn_page(clockwise=True) == {"FINISHED"}
    assert tuple(page_image(document).size) == (height, width)
    assert bpy.ops.origami.turn_page(clockwise=False) == {"FINISHED"}
    assert tuple(page_image(document).size) == (width, height)


def test_the_frame_of_the_page_cuts_it(document):
    import bpy
    from origami.origami_addon.scene.sheet_materials import page_image

    width = page_image(document).size[0]
    flat = document.state.flat
    frame = document.object("page frame").data
    for corner in (0, 3):
        frame.vertices[corner].co.x += 0.25 * flat.width * 1e-3
    bpy.context.view_layer.update()
    assert bpy.ops.origami.apply_page_frame() == {"FINISHED"}
    assert page_image(document).size[0] == pytest.approx(0.75 * width, abs=2)
    assert document.state.flat.width == pytest.approx(0.75 * flat.width)


def test_settings_decide_where_a_run_begins(document):
    from origami.origami_addon.plan import first_stale
    from origami.origami_addon.scene.known import known_of

    group = document.collection.origami
    for change, stage in (
        (lambda: setattr(group.settings.image, "source", "reference"), "page"),
        (lambda: setattr(group.settings.page, "turn", "90"), "lay_out"),
        (lambda: setattr(group.settings.flatten, "ridge_rows", True), "unwrap"),
        (lambda: setattr(group.settings.surface, "grid_rows", 41), "surface"),
        (lambda: setattr(group.settings, "reference", group.photos[1].name), "find"),
        (lambda: setattr(group.photos[0], "use", False), "place"),
    ):
        change()
        assert first_stale(known_of(document)) == stage


def test_a_sheet_torn_in_two_is_reported(document):
    import bmesh
    import bpy

    mesh = document.object("sheet").data
    edited = bmesh.new()
    edited.from_mesh(mesh)
    middle = [face for face in edited.faces if abs(face.calc_center_median().y) < 0.02]
    bmesh.ops.delete(edited, geom=middle, context="FACES_ONLY")
    edited.to_mesh(mesh)
    edited.free()
    with pytest.raises(RuntimeError, match="one piece of paper"):
        bpy.ops.origami.run_stage(stage="unwrap")
    assert all(stage.done for stage in stages(document).values())


def test_lost_photos_are_reported(document):
    import bpy

    group = document.collection.origami
    lost = [str(Path(path).with_name("lost.jpg")) for path in json.loads(group.photos_placed)]
    group.photos_placed = json.dumps(lost)
    with pytest.raises(RuntimeError, match=r"lost\.jpg .*Find Photos"):
        bpy.ops.origami.run_stage(stage="find")


def test_buttons_say_why_they_are_grey(lasting_add_on, empty_scene):
    import bpy

    for operator, why in (
        (bpy.ops.origami.rectify, "Add the photos"),
        (bpy.ops.origami.run_stage, "Add the photos"),
        (bpy.ops.origami.edit_outline, "find the sheet first"),
        (bpy.ops.origami.look_through, "place the photos first"),
        (bpy.ops.origami.turn_page, "no page yet"),
        (bpy.ops.origami.edit_page_frame, "no page yet"),
        (bpy.ops.origami.apply_page_frame, "no page yet"),
        (bpy.ops.origami.show_as, "no page yet"),
        (bpy.ops.origami.remove_photo, "no photo"),
        (bpy.ops.origami.apply_preset, "Add the photos"),
        (bpy.ops.origami.stop, "Nothing is running"),
        (bpy.ops.origami.cancel, "Nothing is running"),
    ):
        with pytest.raises(RuntimeError, match=why):
            operator()


def test_a_folder_without_photos_is_reported(lasting_add_on, empty_scene, tmp_path):
    import bpy

    with pytest.raises(RuntimeError, match="no photos in"):
        bpy.ops.origami.add_photos(directory=f"{tmp_path}/", new=True)
    assert not bpy.data.collections


def test_two_photos_are_too_few(lasting_add_on, empty_scene, small_set):
    import bpy

    folder = small_set.photos[0].path.parent
    files = [{"name": photo.path.name} for photo in small_set.photos[:2]]
    bpy.ops.origami.add_photos(directory=f"{folder}/", files=files, new=True)
    with pytest.raises(RuntimeError, match="photos"):
        bpy.ops.origami.rectify()
    (collection,) = bpy.data.collections
    assert len(collection.origami.photos) == 2
    assert not collection.origami.place.done


def test_methods_are_compared_in_uv_maps_of_their_own(document):
    import bpy

    sheet = document.object("sheet")
    before = np.array([corner.vector[:] for corner in sheet.data.uv_layers["page"].uv])
    assert bpy.ops.origami.compare_methods() == {"FINISHED"}
    names = [layer.name for layer in sheet.data.uv_layers]
    assert names == [
        "page",
        "photo",
        "page arap",
        "page conformal_l1",
        "page lscm",
        "page geodesic",
        "page least_stretch",
    ]
    own, lscm = (
        np.array([corner.vector[:] for corner in sheet.data.uv_layers[name].uv]) for name in ("page arap", "page lscm")
    )
    np.testing.assert_allclose(own, before, atol=1e-6)
    assert 1e-6 < np.abs(own - lscm).max() < 0.1
    assert sheet.data.uv_layers.active.name == "page"


def test_pinned_vertices_keep_their_place_on_the_page(document):
    import bpy

    mesh = document.object("sheet").data
    ensure_pins(mesh.uv_layers["page"])
    layer = mesh.uv_layers["page"]
    before = document.state
    corners = [int(before.sheet.boundary[place]) for place in (0, 60, 120)]
    moved = 3 * np.array([1.0, 0.5])  # mm
    pinned = [loop.vertex_index in corners for loop in mesh.loops]
    layer.pin.foreach_set("value", pinned)
    for loop in mesh.loops:
        if loop.vertex_index == corners[0]:
            layer.uv[loop.index].vector.x += moved[0] / before.flat.width
            layer.uv[loop.index].vector.y -= moved[1] / before.flat.height
    assert bpy.ops.origami.run_stage(stage="unwrap") == {"FINISHED"}
    after = document.state.flat
    np.testing.assert_allclose(after.uv[corners[0]], before.flat.uv[corners[0]] + moved, atol=1e-3)
    np.testing.assert_allclose(after.uv[corners[1:]], before.flat.uv[corners[1:]], atol=1e-3)
    change = np.linalg.norm(after.uv - before.flat.uv, axis=1)
    assert np.median(change) < np.linalg.norm(moved)
    assert change.max() > 0.5 * np.linalg.norm(moved)
    assert (after.width, after.height) == (before.flat.width, before.flat.height)
    left = [False] * len(pinned)
    mesh.uv_layers["page"].pin.foreach_get("value", left)
    assert left == pinned


def test_an_erased_ridge_is_no_crease_and_a_painted_one_is(document):
    import bpy
    from origami.origami_addon.scene.read_back import read_back

    sheet = document.object("sheet")
    group = sheet.vertex_groups["ridge"]
    group.remove(range(len(sheet.data.vertices)))
    uv = document.state.flat.uv
    size = np.array([document.state.flat.width, document.state.flat.height])
    # A stroke where there is no crease.
    inner = (uv[:, 0] > 0.25 * size[0]) & (uv[:, 0] < 0.8 * size[0])
    step = np.sqrt(size.prod() / len(uv))
    along = np.abs(uv[:, 1] - 0.8 * size[1]) < 1.2 * step
    group.add(np.flatnonzero(inner & along).tolist(), 1.0, "REPLACE")
    read = read_back(document)
    assert read.edited == {"creases"}
    (ridge,) = read.state.sheet.ridges
    assert np.ptp(uv[ridge, 0]) > 0.45 * size[0]
    assert np.abs(uv[ridge, 1] - 0.8 * size[1]).max() < 1.5 * step
    document.collection.origami.settings.flatten.ridge_rows = True
    assert bpy.ops.origami.run_stage(stage="unwrap") == {"FINISHED"}
    line = document.state.flat.uv[document.state.sheet.ridges[0]]
    spread = np.linalg.svd(line - line.mean(axis=0))[1]
    assert spread[1] < 0.01 * spread[0]


def test_every_kind_of_file_is_written(document, tmp_path):
    import bpy
    from origami.origami_addon.export.outputs import KINDS, names_of

    assert bpy.ops.origami.export(directory=f"{tmp_path}/", kinds=set(KINDS), bits="16") == {"FINISHED"}
    written = {path.name: path.stat().st_size for path in tmp_path.iterdir()}
    assert written.pop(".origami") > 0
    assert written.keys() == set(names_of(KINDS.values()))
    assert min(written.values()) > 100
    assert written["page.tif"] == pytest.approx(document_pixels(document) * 6, rel=0.02)


def document_pixels(document) -> int:
    from origami.origami_addon.scene.sheet_materials import page_image

    width, height = page_image(document).size
    return width * height


def test_the_command_line_makes_the_same_page(document, finished, colmap_model, tmp_path, root):
    """From the exported settings and the same model, bit for bit."""
    import subprocess
    import sys

    import bpy

    assert bpy.ops.origami.export(directory=f"{tmp_path}/", kinds={"tiff"}) == {"FINISHED"}
    assert bpy.ops.origami.export_settings(filepath=str(tmp_path / "settings.json")) == {"FINISHED"}
    written = json.loads((tmp_path / "settings.json").read_text(encoding="utf-8"))
    assert len(written["outline"]) == 4
    command = [sys.executable, str(root / "headless" / "rectify.py"), str(finished.parent / "Brief ü")]
    options = ["-o", str(tmp_path / "out"), "--settings", str(tmp_path / "settings.json"), "-q"]
    done = subprocess.run([*command, *options], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "page.tif").read_bytes() == (tmp_path / "page.tif").read_bytes()


def test_a_page_that_is_not_up_to_date_is_not_exported(document, tmp_path):
    import bpy

    document.object("sheet").data.vertices[200].co.z += 0.01
    with pytest.raises(RuntimeError, match=r"\AError: The page is not up to date[^\n]*\n\Z"):
        bpy.ops.origami.export(directory=f"{tmp_path}/", kinds={"tiff"})
    assert not list(tmp_path.iterdir())


def test_an_export_replaces_its_own_files_alone(document, tmp_path):
    import bpy
    from origami.origami_addon.files.marker import claim

    (tmp_path / "page.jpg").write_text("mine")
    for kind in ("jpeg", "obj"):
        with pytest.raises(RuntimeError, match=r"page\.jpg, which Origami did not write"):
            bpy.ops.origami.export(directory=f"{tmp_path}/", kinds={kind})
    assert [path.name for path in tmp_path.iterdir()] == ["page.jpg"]
    for _ in range(2):
        assert bpy.ops.origami.export(directory=f"{tmp_path}/", kinds={"uv_svg"}) == {"FINISHED"}
    claim(tmp_path, ["uv_layout.svg"], "another")
    with pytest.raises(RuntimeError, match=r"uv_layout\.svg of the document another"):
        bpy.ops.origami.export(directory=f"{tmp_path}/", kinds={"uv_svg"})
    (tmp_path / ".origami").write_text("cranes and frogs")
    with pytest.raises(RuntimeError, match=r"\.origami, which Origami did not write"):
        bpy.ops.origami.export(directory=f"{tmp_path}/", kinds={"uv_svg"})
    assert (tmp_path / ".origami").read_text() == "cranes and frogs"


def test_no_folder_to_export_to_is_reported(document, tmp_path):
    import bpy

    with pytest.raises(RuntimeError, match="There is no folder"):
        bpy.ops.origami.export(directory=str(tmp_path / "nowhere"), kinds={"tiff"})


def test_nothing_is_done_twice(document):
    import bpy

    kept = document.collection["origami_state"]
    assert bpy.ops.origami.rectify() == {"CANCELLED"}
    assert document.collection["origami_state"] == kept


def draw_crease(document) -> int:
    """Draw a crease, and return which of the document's creases it is."""
    import bpy
    from origami.origami_addon.operators.edit_creases import creases_in_photo

    before = creases_in_photo(document.state)
    drawn = (120.0, 480.0, 360.0, 470.0)
    assert bpy.ops.origami.draw_crease(start=drawn[:2], end=drawn[2:]) == {"FINISHED"}
    assert all(stage.done for stage in stages(document).values())
    there = np.array(creases_in_photo(document.state)).reshape(-1, 2, 2)
    assert len(there) >= len(before) + 1
    # There is a crease somewhere on the drawn line, wherever its ends are now.
    middle = np.array(drawn).reshape(2, 2).mean(axis=0)
    span = there[:, 1] - there[:, 0]
    share = np.clip(((middle - there[:, 0]) * span).sum(axis=1) / (span**2).sum(axis=1), 0, 1)
    distance = np.linalg.norm(there[:, 0] + share[:, None] * span - middle, axis=1)
    assert distance.min() < 8
    given = json.loads(document.collection.origami.creases)
    assert given[-1] == pytest.approx(drawn)
    angles = json.loads(stages(document)["surface"].figures)["fold_angles_degrees"]
    assert len(angles) == len(there)
    return int(distance.argmin())


def test_a_crease_is_drawn(document):
    draw_crease(document)


@pytest.mark.slow
def test_a_crease_is_drawn_and_dropped(document):
    import bpy
    from origami.origami_addon.operators.edit_creases import creases_in_photo
    from origami.origami_addon.scene.read_back import read_back

    document.collection.origami.settings.surface.method = "developable"
    assert bpy.ops.origami.rectify() == {"FINISHED"}
    drawn = draw_crease(document)
    assert read_back(document).edited == frozenset()
    there = creases_in_photo(document.state)
    assert bpy.ops.origami.drop_crease(index=drawn) == {"FINISHED"}
    assert len(creases_in_photo(document.state)) < len(there)
    with pytest.raises(RuntimeError, match="no longer on the sheet"):
        bpy.ops.origami.drop_crease(index=99)


def test_finding_ridges_again_forgets_the_drawn_ones(document):
    import bpy

    kept = document.state.sheet
    document.collection.origami.creases = json.dumps([[120.0, 480.0, 360.0, 470.0]])
    assert bpy.ops.origami.run_stage(stage="surface") == {"FINISHED"}
    assert document.collection.origami.creases == ""
    np.testing.assert_array_equal(document.state.sheet.vertices, kept.vertices)


def test_other_photos_become_a_page_beside_the_page(document, small_set, tmp_path):
    import bpy
    from other_light_scene import negative
    from PIL import Image

    folder = tmp_path / "ultraviolet"
    folder.mkdir()
    photo = np.array(Image.open(small_set.photos[2].path))
    Image.fromarray(negative(photo)).save(folder / "one.png")
    assert bpy.ops.origami.add_other_light(directory=f"{folder}/") == {"FINISHED"}
    other, page = document.object("other page"), bpy.data.images["Brief ü page"]
    image = bpy.data.images["Brief ü ultraviolet"]
    assert other["other_photos"] == "ultraviolet"
    assert tuple(image.size) == tuple(page.size)
    assert image.packed_file is not None
    grey = [np.array(each.pixels[:]).reshape(-1, 4)[:, :3].mean(axis=1) for each in (image, page)]
    shown = grey[0] < 0.98  # the photo does not show all of the page
    assert np.corrcoef(grey[0][shown], grey[1][shown])[0, 1] < -0.5
    with pytest.raises(RuntimeError, match="There is no file or folder"):
        bpy.ops.origami.add_other_light(directory=f"{tmp_path / 'gone'}/")
