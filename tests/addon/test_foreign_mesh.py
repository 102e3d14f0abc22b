"""A mesh of the user's own as arrays, and a flat map back into it."""

from __future__ import annotations

import numpy as np
import pytest
from meshes import ensure_pins, quads
from origami.core.errors import UnusableMesh


@pytest.fixture
def grid(empty_scene):
    """Three quads in a row, 3 x 1, with vertices 0 to 3 in the lower row and 4 to 7 above."""
    return made_of(4, 2)


def made_of(across: int, up: int):
    """The active object, a grid of so many vertices, a unit apart."""
    import bpy

    vertices, faces = quads(across, up, lambda u, v: np.stack([(across - 1) * u, (up - 1) * v, 0 * u], -1))
    mesh = bpy.data.meshes.new("grid")
    mesh.from_pydata(vertices.tolist(), [], faces.tolist())
    made = bpy.data.objects.new("grid", mesh)
    bpy.context.scene.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    made.select_set(True)
    return made


def read(mesh_object, ridges="none"):
    from origami.origami_addon.scene.foreign_mesh import read_mesh

    return read_mesh(mesh_object, ridges)


def mark(mesh, name: str, *edges: set[int]) -> None:
    for edge in mesh.edges:
        setattr(edge, name, set(edge.vertices) in edges)


def test_all_faces_as_triangles_of_corners(grid):
    arrays = read(grid).arrays
    np.testing.assert_allclose(arrays["vertices"][[0, 3, 7]], [[0, 0, 0], [3, 0, 0], [3, 1, 0]], atol=1e-6)
    assert arrays["corner_vertex"].tolist() == [0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6]
    assert arrays["triangles"].shape == (6, 3)
    for face in range(3):  # each quad's two triangles are of its own corners
        assert set(arrays["triangles"][2 * face : 2 * face + 2].ravel()) == set(range(4 * face, 4 * face + 4))
    assert not arrays["pinned"].any()
    assert arrays["uv"].shape == (12, 2) and not arrays["uv"].any()
    assert len(arrays["seams"]) == len(arrays["ridges"]) == len(arrays["ridge_lengths"]) == 0


def test_the_scale_counts_and_the_place_does_not(grid):
    import bpy

    grid.scale, grid.location = (2, 3, 1), (5, 5, 5)
    bpy.context.view_layer.update()
    np.testing.assert_allclose(np.ptp(read(grid).arrays["vertices"], axis=0), [6, 3, 0], atol=1e-5)
    assert read(grid).arrays["vertices"].min() == pytest.approx(0, abs=1e-6)


def test_in_edit_mode_the_selected_faces_alone(grid):
    import bmesh
    import bpy

    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    edited = bmesh.from_edit_mesh(grid.data)
    for face in edited.faces:
        face.select_set(face.index == 1)
    bmesh.update_edit_mesh(grid.data)
    arrays = read(grid).arrays
    assert grid.mode == "EDIT"
    assert set(arrays["triangles"].ravel()) == {4, 5, 6, 7}
    bpy.ops.mesh.select_all(action="DESELECT")
    with pytest.raises(UnusableMesh, match="No face is selected"):
        read(grid)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(read(grid).arrays["triangles"]) == 6


def test_seams_are_pairs_of_vertices(grid):
    mark(grid.data, "use_seam", {1, 5}, {2, 6})
    assert sorted(sorted(pair) for pair in read(grid).arrays["seams"].tolist()) == [[1, 5], [2, 6]]


def test_places_and_pins_are_those_of_the_active_map(grid):
    ensure_pins(grid.data.uv_layers.new(name="own"))
    layer = grid.data.uv_layers["own"]
    layer.uv[3].vector = (0.25, 0.75)
    layer.pin.foreach_set("value", [corner in (3, 5) for corner in range(12)])
    arrays = read(grid).arrays
    assert arrays["uv"][3].tolist() == [0.25, 0.75]
    assert np.flatnonzero(arrays["pinned"]).tolist() == [3, 5]


def test_sharp_edges_make_runs(grid):
    mark(grid.data, "use_edge_sharp", {0, 1}, {1, 2}, {3, 7})
    found = read(grid, "sharp")
    runs = np.split(found.arrays["ridges"], np.cumsum(found.arrays["ridge_lengths"])[:-1])
    assert sorted(sorted(run.tolist()) for run in runs) == [[0, 1, 2], [3, 7]]
    assert found.warning is None
    assert len(read(grid, "none").arrays["ridges"]) == 0


def test_a_painted_band_makes_a_run(empty_scene):
    wide = made_of(9, 5)
    assert len(read(wide, "group").arrays["ridges"]) == 0  # there is no group
    row = list(range(9, 18))
    wide.vertex_groups.new(name="fold").add(row, 1.0, "REPLACE")
    assert sorted(read(wide, "group").arrays["ridges"].tolist()) == row
    assert len(read(wide, "none").arrays["ridges"]) == 0


def test_a_flat_map_goes_into_the_active_layer_or_a_new_one(grid):
    from origami.origami_addon.scene.foreign_mesh import write_uv

    uv = np.arange(24).reshape(12, 2) / 32
    write_uv(grid, uv)
    assert [layer.name for layer in grid.data.uv_layers] == ["UVMap"]
    np.testing.assert_array_equal(read(grid).arrays["uv"], uv)
    grid.data.uv_layers.new(name="own")
    grid.data.uv_layers.active = grid.data.uv_layers["own"]
    write_uv(grid, uv + 0.25)
    np.testing.assert_array_equal([corner.vector[:] for corner in grid.data.uv_layers["own"].uv], uv + 0.25)
    np.testing.assert_array_equal([corner.vector[:] for corner in grid.data.uv_layers["UVMap"].uv], uv)


def test_a_mesh_that_was_changed_meanwhile(grid):
    from origami.origami_addon.scene.foreign_mesh import write_uv

    with pytest.raises(UnusableMesh, match="changed while it was unwrapped"):
        write_uv(grid, np.zeros((8, 2)))


def test_a_mesh_without_faces_says_so(empty_scene):
    import bpy

    mesh = bpy.data.meshes.new("points")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    points = bpy.data.objects.new("points", mesh)
    with pytest.raises(UnusableMesh, match="The mesh has no faces"):
        read(points)
