"""Pieces of a mesh that can be laid flat, and the reasons why others cannot."""

from __future__ import annotations

import numpy as np
import pytest
from meshes import corners, quads, tube
from origami.core.errors import UnusableMesh
from origami.core.unwrap.islands import Island, find_islands


def flat(u, v):
    return np.stack([u, v, 0 * u], -1)


def islands_of(vertices, faces, seams=()) -> list[Island]:
    return find_islands(vertices, *corners(faces), np.array(seams, np.int64).reshape(-1, 2))


def test_each_side_of_a_seam_is_an_island_with_its_own_vertices():
    vertices, faces = quads(3, 2, flat)
    left, right = islands_of(vertices, faces, [(1, 4)])
    assert sorted(left.mesh_vertex) == [0, 1, 3, 4]
    assert sorted(right.mesh_vertex) == [1, 2, 4, 5]
    assert (left.corners.tolist(), right.corners.tolist()) == ([0, 1, 2, 3], [4, 5, 6, 7])
    for island in (left, right):
        np.testing.assert_array_equal(island.sheet.vertices, vertices[island.mesh_vertex])
        np.testing.assert_array_equal(island.mesh_vertex[island.vertex_of_corner], faces.ravel()[island.corners])
        assert sorted(island.sheet.boundary) == [0, 1, 2, 3]
    assert sorted([*left.mesh_triangle, *right.mesh_triangle]) == [0, 1, 2, 3]


def test_the_boundary_goes_around_counter_clockwise():
    vertices, faces = quads(4, 4, flat)
    (island,) = islands_of(vertices, faces)
    x, y = island.sheet.vertices[island.sheet.boundary, :2].T
    assert 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() == pytest.approx(1)


def test_a_hole_is_no_boundary():
    vertices, faces = quads(4, 4, flat)
    (island,) = islands_of(vertices, np.delete(faces, 4, axis=0))
    inner = {5, 6, 9, 10}
    assert set(island.mesh_vertex[island.sheet.boundary]) == set(range(16)) - inner


def test_the_value_at_a_corner_is_that_of_its_vertex():
    vertices, faces = quads(3, 2, flat)
    (island,) = islands_of(vertices, faces)
    np.testing.assert_array_equal(island.at_corners(island.sheet.vertices[:, :2]), vertices[faces.ravel(), :2])


def test_a_vertex_of_a_face_without_area_hangs_on_the_line_it_is_on():
    # 4 lies a quarter of the way along the edge from 1 to 2
    vertices = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [4, 1, 0]], float)
    triangles = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2]])
    (island,) = islands_of(vertices, triangles)
    assert island.mesh_triangle.tolist() == [0, 1]
    ((start, end, share),) = island.hanging
    along = vertices[island.mesh_vertex[[start, end]]]
    np.testing.assert_allclose((1 - share) * along[0] + share * along[1], vertices[4])
    np.testing.assert_allclose(island.at_corners(island.sheet.vertices[:, :2]), vertices[triangles.ravel(), :2])


def test_a_piece_without_area_is_left_out():
    vertices, _ = quads(2, 2, flat)
    line = np.array([[5, 0, 0], [6, 0, 0], [7, 0, 0]], float)
    triangles = np.array([[0, 1, 3], [0, 3, 2], [4, 5, 6]])
    (island,) = islands_of(np.concatenate([vertices, line]), triangles)
    assert sorted(island.mesh_vertex) == [0, 1, 2, 3]


def test_a_tube_needs_a_seam_along_it():
    vertices, faces, seam = tube(16, 5)
    with pytest.raises(UnusableMesh, match=r"The mesh is a tube: mark a seam along it"):
        islands_of(vertices, faces)
    (island,) = islands_of(vertices, faces, seam)
    assert len(island.sheet.vertices) == len(vertices) + 5


def test_a_closed_piece_is_named_by_a_vertex():
    vertices, _ = quads(2, 2, flat)
    ball = np.array([[9, 0, 0], [10, 0, 0], [9, 1, 0], [9, 0, 1]], float)
    solid = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]) + 4
    triangles = np.concatenate([[[0, 1, 3], [0, 3, 2]], solid])
    with pytest.raises(UnusableMesh, match=r"The part at vertex [4-7] is closed: mark seams"):
        islands_of(np.concatenate([vertices, ball]), triangles)


def test_a_handle_is_not_mistaken_for_a_hole():
    def ring(u, v):
        around, across = 2 * np.pi * u, 2 * np.pi * v
        return np.stack(
            [(3 + np.cos(across)) * np.cos(around), (3 + np.cos(across)) * np.sin(around), np.sin(across)], 1
        )

    vertices, faces = quads(12, 9, ring, around=True)
    faces = np.where(faces >= 12 * 8, faces - 12 * 8, faces)  # the last row is the first one again
    with pytest.raises(UnusableMesh, match="has a handle"):
        islands_of(vertices[: 12 * 8], faces[1:])


def test_what_hangs_together_at_one_vertex_can_turn():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [2, -2, 0]], float)
    # two triangles with a vertex in common, held together by a line from one to the other
    triangles = np.array([[0, 1, 2], [0, 3, 4]])
    assert len(islands_of(vertices, triangles)) == 2
