"""The slider that unfolds a sheet keeps its lengths, survives saving and exports, and spoils no edits."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from folded import folded_sheet
from origami.core.flat.distortion import measure_strain
from origami.core.sheet import FlatMap
from origami.origami_addon.export.models import write_glb, write_obj
from origami.origami_addon.scene.document_frame import document_frame, on_ground
from origami.origami_addon.scene.mesh_values import read_values
from origami.origami_addon.scene.shape_keys import UNFOLD, put_unfolding, shown_positions, unfold_slider
from origami.origami_addon.scene.sheet_mesh import is_unchanged, object_to_sheet, put_sheet, sheet_to_object
from origami.origami_addon.scene.unfolding import unfolding

MESH, FLAT_UV = sheets.mesh(sheets.sharp_letter(), 0.05)
FLAT = FlatMap(FLAT_UV, sheets.WIDTH, sheets.HEIGHT, "page heights", None)
FRAME = document_frame(MESH, FLAT)
SHAPES = unfolding(MESH, FLAT)


@pytest.fixture
def letter(empty_scene):
    """A letter folded in three by 120 degrees each."""
    import bpy
    from origami.origami_addon.scene.paper_material import paper_material

    made = sheet_to_object("letter", MESH, FLAT, sheets.camera(), FRAME)
    put_unfolding(made, SHAPES)
    made.data.materials.append(paper_material("page", bpy.data.images.new("page", 4, 4), "page"))
    bpy.context.scene.collection.objects.link(made)
    return made


def opened(sheet_object, share):
    """The vertices as shown with the slider at a share."""
    import bpy

    unfold_slider(sheet_object).value = share
    bpy.context.view_layer.update()
    return shown_positions(sheet_object).astype(float)


def lengths(positions, edges):
    return np.linalg.norm(positions[edges[:, 0]] - positions[edges[:, 1]], axis=1)


def test_a_sheet_is_folded_at_first(letter):
    assert unfold_slider(letter).value == 0
    np.testing.assert_allclose(shown_positions(letter), read_values(letter.data.vertices, "co", 3, np.float32))


def test_the_slider_leads_from_folded_to_flat_without_stretch(letter):
    folded = opened(letter, 0.0)
    for share in np.linspace(0.1, 0.9, 9):
        shown = opened(letter, share)
        assert measure_strain(shown, MESH.triangles, FLAT.uv).stretch.max() < 1e-4
        assert np.ptp(shown[:, 2]) > 1e-3
    np.testing.assert_allclose(opened(letter, 1.0), on_ground(FLAT), atol=1e-6)
    np.testing.assert_array_equal(opened(letter, 0.0), folded)


def test_blender_weighs_the_shapes_without_python(letter):
    drivers = letter.data.shape_keys.animation_data.drivers
    assert len(drivers) == 3
    assert all(each.driver.is_valid and each.driver.is_simple_expression for each in drivers)


def test_an_open_sheet_is_read_back_folded(letter):
    opened(letter, 0.7)
    assert is_unchanged(letter, MESH, FRAME)
    np.testing.assert_allclose(object_to_sheet(letter)[0].vertices, MESH.vertices, atol=1e-6)


def test_a_click_on_the_open_sheet_is_one_on_the_folded_sheet(letter):
    from mathutils import Vector
    from origami.origami_addon.operators.draw_crease import _on_folded

    shares = np.array([0.2, 0.3, 0.5])
    for share in (0.0, 0.6, 1.0):
        shown = opened(letter, share)
        for face in (0, 57):
            corners = list(letter.data.polygons[face].vertices)
            folded = np.array([letter.data.vertices[corner].co for corner in corners])
            found = _on_folded(letter, Vector(shares @ shown[corners]), face)
            np.testing.assert_allclose(found, shares @ folded, atol=1e-6)


def test_the_slider_survives_saving(letter, tmp_path):
    import bpy

    there = opened(letter, 0.3)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    read = bpy.data.objects["letter"]
    np.testing.assert_allclose(shown_positions(read), there, atol=1e-6)
    np.testing.assert_allclose(opened(read, 1.0), on_ground(FLAT), atol=1e-6)


def test_a_copy_has_its_own_slider(letter):
    import bpy

    copy = letter.copy()
    copy.data = letter.data.copy()
    bpy.context.scene.collection.objects.link(copy)
    there = opened(letter, 0.4)
    np.testing.assert_allclose(opened(copy, 1.0), on_ground(FLAT), atol=1e-6)
    np.testing.assert_array_equal(shown_positions(letter), there)


def test_a_new_run_keeps_the_slider_its_animation_and_keys_of_the_user(letter):

    unfold_slider(letter).keyframe_insert("value", frame=7)
    own = letter.shape_key_add(name="own", from_mix=False)
    own.data[3].co.z += 0.1
    put_sheet(letter, MESH, FLAT, sheets.camera(), np.diag([2.0, 2, 2, 1]) @ FRAME)
    put_unfolding(letter, 2 * SHAPES)
    keys = letter.data.shape_keys
    assert [key.name for key in keys.key_blocks].count(UNFOLD) == 1
    assert keys.animation_data.action is not None
    moved = read_values(own.data, "co", 3, np.float32) - read_values(letter.data.vertices, "co", 3, np.float32)
    assert moved[3, 2] == pytest.approx(0.1, abs=1e-6)
    assert np.abs(np.delete(moved, 3, axis=0)).max() < 1e-6
    keys.key_blocks["own"].mute = True
    keys.animation_data.action = None
    np.testing.assert_allclose(opened(letter, 1.0), 2 * on_ground(FLAT), atol=1e-6)


def test_a_new_surface_takes_the_slider_until_it_is_flat_and_then_returns_its_animation(letter):
    import bpy

    slider = unfold_slider(letter)
    for share, frame in ((0.0, 1), (1.0, 11)):
        slider.value = share
        slider.keyframe_insert("value", frame=frame)
    case = folded_sheet()
    frame = document_frame(case.sheet, case.flat)
    put_sheet(letter, case.sheet, None, case.model.cameras[0], frame)
    assert unfold_slider(letter) is None
    put_sheet(letter, case.sheet, case.flat, case.model.cameras[0], frame)
    put_unfolding(letter, unfolding(case.sheet, case.flat))
    bpy.context.scene.frame_set(11)
    np.testing.assert_allclose(shown_positions(letter), on_ground(case.flat), atol=1e-6)
    bpy.context.scene.frame_set(1)
    np.testing.assert_allclose(shown_positions(letter), read_values(letter.data.vertices, "co", 3, np.float32))


def test_gltf_holds_the_folded_sheet_and_its_opening(letter, tmp_path):
    import bpy

    opened(letter, 0.6)
    before = {*bpy.data.objects, *bpy.data.actions, *bpy.data.shape_keys}
    write_glb(tmp_path / "sheet.glb", letter)
    assert {*bpy.data.objects, *bpy.data.actions, *bpy.data.shape_keys} == before
    assert unfold_slider(letter).value == pytest.approx(0.6)
    bpy.ops.import_scene.gltf(filepath=str(tmp_path / "sheet.glb"))
    (read,) = (each for each in set(bpy.data.objects) - before if each.type == "MESH")
    edges = read_values(read.data.edges, "vertices", 2, np.int32)
    folded = read_values(read.data.vertices, "co", 3, np.float32)
    there = read_values(letter.data.vertices, "co", 3, np.float32)
    np.testing.assert_allclose(np.ptp(folded, axis=0), np.ptp(there, axis=0), rtol=1e-5)
    for frame in (0, 5, 17, 30, 48):
        bpy.context.scene.frame_set(frame)
        shown = read_values(
            read.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices, "co", 3, np.float32
        )
        assert np.abs(lengths(shown, edges) / lengths(folded, edges) - 1).max() < 1e-4
    assert np.ptp(shown[:, 2]) < 1e-6


def test_obj_holds_the_folded_sheet(letter, tmp_path):
    opened(letter, 1.0)
    write_obj(tmp_path / "sheet.obj", letter)
    lines = (line.split() for line in (tmp_path / "sheet.obj").read_text(encoding="utf-8").splitlines())
    positions = np.array([line[1:4] for line in lines if line[:1] == ["v"]], float)
    folded = read_values(letter.data.vertices, "co", 3, np.float32)
    assert np.ptp(positions[:, 1]) == pytest.approx(np.ptp(folded[:, 2]), rel=1e-5)  # y is up
