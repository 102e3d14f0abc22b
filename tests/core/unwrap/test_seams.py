"""A mesh falls apart where it is cut, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from meshes import corners, quads
from origami.core.unwrap.seams import Cut, cut_at_seams


def flat(u, v):
    return np.stack([u, v, 0 * u], -1)


def cut(vertices, faces, seams=()) -> Cut:
    return cut_at_seams(vertices, *corners(faces), np.array(seams, np.int64).reshape(-1, 2))


def test_without_a_seam_all_stays_together():
    vertices, faces = quads(3, 2, flat)
    whole = cut(vertices, faces)
    assert sorted(whole.vertex) == list(range(6))
    assert whole.piece.tolist() == [0, 0, 0, 0]
    assert whole.kept.tolist() == [0, 1, 2, 3]
    assert not whole.one_sided.any()
    np.testing.assert_array_equal(whole.vertex[whole.corner], faces.ravel())


def test_a_seam_from_edge_to_edge_makes_two_pieces():
    # vertices 1 and 4 lie in the middle of the lower and the upper row
    vertices, faces = quads(3, 2, flat)
    halves = cut(vertices, faces, [(1, 4)])
    assert sorted(halves.vertex) == [0, 1, 1, 2, 3, 4, 4, 5]
    left, right = halves.corner.reshape(2, 4)
    assert not set(left) & set(right)
    np.testing.assert_array_equal(halves.vertex[halves.corner], faces.ravel())
    assert len(np.unique(halves.piece)) == 2


def test_a_seam_that_ends_inside_only_slits():
    # from the middle of the lower edge to the middle vertex, 4
    vertices, faces = quads(3, 3, flat)
    slit = cut(vertices, faces, [(1, 4)])
    assert len(np.unique(slit.piece)) == 1
    assert sorted(slit.vertex) == [0, 1, 1, 2, 3, 4, 5, 6, 7, 8]


def test_three_triangles_at_an_edge_are_parted():
    vertices = np.array([[0, 0, 0], [0, 1, 0], [1, 0, 0], [-1, 0, 0], [0, 0, 1]], float)
    triangles = np.array([[0, 2, 1], [1, 3, 0], [0, 4, 1]])
    parted = cut(vertices, triangles)
    assert parted.piece.tolist() == [0, 1, 2]
    assert sorted(parted.vertex) == [0, 0, 0, 1, 1, 1, 2, 3, 4]


def test_a_face_the_wrong_way_round_is_turned_as_most_of_the_area():
    vertices, faces = quads(4, 2, flat)
    faces[1] = faces[1, ::-1]
    turned = cut(vertices, faces)
    a, b, c = (vertices[turned.vertex[turned.triangles[:, k]]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()


def test_a_twisted_ring_has_one_side():
    def twisted(u, v):
        turn, across = 2 * np.pi * u, v - 0.5
        radius = 2 + across * np.cos(turn / 2)
        return np.stack([radius * np.cos(turn), radius * np.sin(turn), across * np.sin(turn / 2)], -1)

    vertices, faces = quads(24, 2, twisted, around=True)
    faces[-1] = [23, 24, 0, 47]  # after a turn the lower edge meets the upper
    ring = cut(vertices, faces)
    assert ring.one_sided.all()
    assert not cut(vertices, faces, [(0, 24)]).one_sided.any()


def test_a_triangle_without_three_places_is_left_out():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [1, 1, 0]], float)
    triangles = np.array([[0, 1, 2], [3, 4, 2], [1, 3, 2]])
    solid = cut(vertices, triangles)
    assert solid.kept.tolist() == [0, 2]
    assert sorted(solid.vertex) == [0, 1, 2, 3]
    # its corners lie where the others have theirs
    np.testing.assert_array_equal(solid.vertex[solid.corner[3:6]], [3, 3, 2])


@pytest.mark.parametrize("seams", [[(0, 5)], [(2, 3)]])
def test_a_pair_that_is_no_edge_cuts_nothing(seams):
    vertices, faces = quads(3, 2, flat)
    assert len(cut(vertices, faces, seams).vertex) == 6
