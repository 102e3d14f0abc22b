"""A sheet survives conversion to a mesh and back."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from folded import folded_sheet
from origami.core.errors import StepFailed
from origami.origami_addon.scene.document_frame import document_frame
from origami.origami_addon.scene.sheet_mesh import object_to_sheet, put_groups, put_sheet, sheet_to_object


@pytest.fixture
def case(empty_scene):
    return folded_sheet()


@pytest.fixture
def mesh_object(case):
    import bpy

    made = sheet_to_object("sheet", case.sheet, case.flat, case.model.cameras[0], document_frame(case.sheet, case.flat))
    bpy.context.scene.collection.objects.link(made)
    return made


def test_round_trip_is_exact(case, mesh_object):
    sheet, flat = object_to_sheet(mesh_object)
    np.testing.assert_allclose(sheet.vertices, case.sheet.vertices, atol=1e-6)
    np.testing.assert_array_equal(sheet.triangles, case.sheet.triangles)
    np.testing.assert_array_equal(sheet.boundary, case.sheet.boundary)
    assert len(sheet.ridges) == 2
    for read, made in zip(sheet.ridges, case.sheet.ridges, strict=True):
        np.testing.assert_array_equal(read, made)
    np.testing.assert_allclose(flat.uv, case.flat.uv, atol=1e-4)
    assert (flat.width, flat.height, flat.unit, flat.world_scale) == (160, 200, "mm", 40)


def test_unknown_size_comes_back_as_unknown(case):
    from dataclasses import replace

    flat = replace(case.flat, unit="page heights", world_scale=None)
    made = sheet_to_object("sheet", case.sheet, flat, case.model.cameras[0], np.eye(4))
    assert object_to_sheet(made)[1].world_scale is None


def test_round_trip_survives_saving(case, mesh_object, tmp_path):
    import bpy

    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    sheet, _ = object_to_sheet(bpy.data.objects["sheet"])
    np.testing.assert_array_equal(sheet.boundary, case.sheet.boundary)
    np.testing.assert_array_equal(sheet.ridges[1], case.sheet.ridges[1])


def test_edits_by_hand_are_read(case, mesh_object):
    mesh_object.data.vertices[40].co.z += 0.01
    mesh_object.vertex_groups["ridge"].remove(case.sheet.ridges[1].tolist()[:5])
    mesh_object.vertex_groups["ridge"].add(case.sheet.ridges[0].tolist(), 1.0, "REPLACE")
    sheet, _ = object_to_sheet(mesh_object)
    moved = np.linalg.norm(sheet.vertices - case.sheet.vertices, axis=1)
    assert moved[40] == pytest.approx(0.01 * 1000 / 40, rel=1e-3)
    assert np.sum(moved > 1e-5) == 1
    np.testing.assert_array_equal(sheet.ridges[1], case.sheet.ridges[1][5:])


def test_weight_of_a_ridge_is_its_fold(case, mesh_object):
    put_groups(mesh_object, folded_sheet(fold=0.3).sheet)
    group = mesh_object.vertex_groups["ridge"]
    sharp, flat = (np.unique([group.weight(vertex) for vertex in ridge[1:-1]]) for ridge in case.sheet.ridges)
    np.testing.assert_allclose(sharp, np.degrees(0.6) / 90, rtol=1e-4)
    # A flat crease stays in the group; where the two meet, the sharper one counts.
    np.testing.assert_allclose(flat, [0.05, np.degrees(0.6) / 90], rtol=1e-4)


def test_shading_is_sharp_at_creases_and_smooth_elsewhere(case, mesh_object):
    mesh = mesh_object.data
    sharp = {tuple(sorted(edge.vertices)) for edge in mesh.edges if edge.use_edge_sharp}
    along = {tuple(sorted(pair)) for ridge in case.sheet.ridges for pair in pairwise(ridge)}
    assert sharp == along
    normal = np.array([corner.vector for corner in mesh.corner_normals])
    fold = np.arctan(np.abs(normal[:, 1] / normal[:, 2]))
    np.testing.assert_allclose(fold, 0.5, atol=1e-4)  # on both sides of the crease, up to it


def test_groups_layers_and_attributes_have_their_names(case, mesh_object):
    assert [group.name for group in mesh_object.vertex_groups] == ["ridge", "boundary"]
    assert [layer.name for layer in mesh_object.data.uv_layers] == ["page", "photo"]
    assert mesh_object.data.uv_layers.active.name == "page"
    stretch = [item.value for item in mesh_object.data.attributes["stretch"].data]
    assert max(stretch) < 1e-6  # the flat map of the folded sheet is exact


def test_the_bound_is_an_attribute_in_the_unit_of_the_page_and_goes_with_the_sheet_that_has_it(case, mesh_object):
    mesh, view, frame = mesh_object.data, case.model.cameras[0], np.array(mesh_object["origami_frame"]).reshape(4, 4)
    bound = np.linspace(0, 0.02, len(case.sheet.vertices))
    put_sheet(mesh_object, replace(case.sheet, bound=bound), case.flat, view, frame)
    shown = [item.value for item in mesh.attributes["page_bound"].data]
    np.testing.assert_allclose(shown, 40 * bound, rtol=1e-4, atol=1e-6)
    least, most = (case.sheet.triangles.ravel().tolist().index(vertex) for vertex in (0, len(bound) - 1))
    blue, red = (mesh.color_attributes["page bound color"].data[corner].color_srgb for corner in (least, most))
    assert blue[2] > 0.9 > 0.2 > blue[0]
    assert red[0] > 0.9 > 0.2 > red[2]
    put_sheet(mesh_object, case.sheet, case.flat, view, frame)
    assert not {"page_bound", "page bound color"} & {each.name for each in mesh.attributes}


def test_photo_layer_has_the_lens_distortion(case, mesh_object):
    camera = case.model.cameras[0]
    corner = 17
    vertex = mesh_object.data.loops[corner].vertex_index
    u, v = mesh_object.data.uv_layers["photo"].uv[corner].vector
    pixel = camera.project(case.sheet.vertices[vertex])
    np.testing.assert_allclose([u * camera.width, (1 - v) * camera.height], pixel, atol=1e-3)


def test_crease_beside_the_edges_of_the_mesh_comes_back(case):
    from dataclasses import replace

    # Every other vertex only: no edge of the mesh joins them.
    sheet = replace(case.sheet, ridges=(case.sheet.ridges[0][::2],))
    read, _ = object_to_sheet(sheet_to_object("sheet", sheet, case.flat, case.model.cameras[0], np.eye(4)))
    np.testing.assert_array_equal(read.ridges[0], sheet.ridges[0])


def test_what_is_no_sheet_is_refused(case, mesh_object):
    import bpy

    with pytest.raises(StepFailed, match="not a sheet"):
        object_to_sheet(bpy.data.objects.new("cube", bpy.data.meshes.new("cube")))


def test_a_sheet_that_is_not_flat_yet_has_no_flat_map(case, mesh_object):
    put_sheet(mesh_object, case.sheet, None, case.model.cameras[0], document_frame(case.sheet, case.flat))
    sheet, flat = object_to_sheet(mesh_object)
    assert flat is None
    assert [layer.name for layer in mesh_object.data.uv_layers] == ["photo"]
    np.testing.assert_array_equal(sheet.triangles, case.sheet.triangles)


def test_the_same_mesh_keeps_the_users_uv_layers_and_materials(case, mesh_object):
    import bpy

    mesh_object.data.uv_layers.new(name="own")
    mesh_object.data.materials.append(bpy.data.materials.new("own"))
    put_sheet(mesh_object, case.sheet, case.flat, case.model.cameras[1], np.eye(4))
    assert [layer.name for layer in mesh_object.data.uv_layers] == ["page", "photo", "own"]
    assert [material.name for material in mesh_object.data.materials] == ["own"]
    np.testing.assert_allclose(object_to_sheet(mesh_object)[0].vertices, case.sheet.vertices, atol=1e-5)


def test_fewer_creases_leave_nobody_in_the_group(case, mesh_object):
    from dataclasses import replace

    put_groups(mesh_object, replace(case.sheet, ridges=()))
    group = mesh_object.vertex_groups["ridge"].index
    assert not any(entry.group == group for vertex in mesh_object.data.vertices for entry in vertex.groups)
    assert object_to_sheet(mesh_object)[0].ridges == ()


def edit(mesh, change):
    import bmesh

    edited = bmesh.new()
    edited.from_mesh(mesh)
    edited.faces.ensure_lookup_table()
    edited.verts.ensure_lookup_table()
    change(edited)
    edited.to_mesh(mesh)
    edited.free()


def test_a_hole_cut_by_hand_is_left_out(case, mesh_object):
    import bmesh

    edit(mesh_object.data, lambda mesh: bmesh.ops.delete(mesh, geom=[mesh.faces[400]], context="FACES_ONLY"))
    sheet, flat = object_to_sheet(mesh_object)
    assert len(sheet.triangles) == len(case.sheet.triangles) - 1
    np.testing.assert_array_equal(sheet.boundary, case.sheet.boundary)
    np.testing.assert_allclose(flat.uv, case.flat.uv, atol=1e-4)


def test_vertices_left_alone_are_left_out(case, mesh_object):
    corner = int(case.sheet.boundary[5])

    def tear_off(mesh):
        for face in list(mesh.verts[corner].link_faces):
            mesh.faces.remove(face)

    edit(mesh_object.data, tear_off)
    sheet, flat = object_to_sheet(mesh_object)
    assert len(sheet.vertices) == len(flat.uv) == len(case.sheet.vertices) - 1
    assert sheet.triangles.max() == len(sheet.vertices) - 1
    assert len(set(sheet.boundary.tolist())) == len(sheet.boundary)


def test_faces_of_four_corners_are_cut(case, mesh_object):
    import bmesh

    edit(
        mesh_object.data,
        lambda mesh: bmesh.ops.join_triangles(
            mesh, faces=mesh.faces[:], angle_face_threshold=0.1, angle_shape_threshold=3.0
        ),
    )
    assert len(mesh_object.data.polygons) < len(case.sheet.triangles)
    sheet, flat = object_to_sheet(mesh_object)
    assert len(sheet.triangles) == len(case.sheet.triangles)
    np.testing.assert_allclose(flat.uv, case.flat.uv, atol=1e-4)


def test_a_sheet_in_two_parts_is_refused(case, mesh_object):
    import bmesh

    middle = [
        face for face in range(len(case.sheet.triangles)) if 14 * 25 <= case.sheet.triangles[face].min() < 15 * 25
    ]
    edit(
        mesh_object.data,
        lambda mesh: bmesh.ops.delete(mesh, geom=[mesh.faces[face] for face in middle], context="FACES_ONLY"),
    )
    with pytest.raises(StepFailed, match="one piece"):
        object_to_sheet(mesh_object)
