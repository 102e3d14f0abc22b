"""What a user edits by hand counts: a run reads it back, and begins where it matters."""

from __future__ import annotations

import json

import numpy as np
import pytest
from finished_document import stages
from meshes import ensure_pins


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
    assert moved.argmax() == 200
    assert moved[200] > 1e-4
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
    cut = document.state.flat
    assert cut.width / cut.height != pytest.approx(before.flat.width / before.flat.height, rel=1e-3)


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
