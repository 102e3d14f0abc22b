"""Geometry of single triangles."""

from __future__ import annotations

import numpy as np
from origami.core.numeric.triangles import areas, directed_edges, gradient_rows, local_coordinates, signed_areas

VERTICES = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 0.0, 4.0], [0.0, 0.0, 4.0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


def test_a_triangle_in_its_own_plane():
    np.testing.assert_allclose(local_coordinates(VERTICES, TRIANGLES)[0], [[0, 0], [3, 0], [3, 4]], atol=1e-12)
    np.testing.assert_allclose(local_coordinates(VERTICES, TRIANGLES)[1], [[0, 0], [5, 0], [3.2, 2.4]], atol=1e-12)


def test_areas_and_their_signs():
    np.testing.assert_allclose(areas(VERTICES, TRIANGLES), [6, 6])
    flat = VERTICES[:, [0, 2]]
    np.testing.assert_allclose(signed_areas(flat, TRIANGLES), [6, 6])
    np.testing.assert_allclose(signed_areas(flat, TRIANGLES[:, ::-1]), [-6, -6])


def test_gradients_of_a_linear_function_are_exact():
    along_x, along_y = gradient_rows(VERTICES, TRIANGLES)
    values = 2 * VERTICES[:, 0] - VERTICES[:, 2] + 7
    np.testing.assert_allclose(along_x @ values, [2, (2 * 3 - 4) / 5], atol=1e-12)
    np.testing.assert_allclose((along_x @ values) ** 2 + (along_y @ values) ** 2, [5, 5], atol=1e-12)


def test_each_triangle_has_three_directed_edges():
    edges = directed_edges(TRIANGLES)
    assert len(edges) == 6
    assert [0, 2] in edges.tolist()
    assert [2, 0] in edges.tolist()
