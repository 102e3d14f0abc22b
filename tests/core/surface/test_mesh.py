"""The mesh ends at the outline, has edges along creases, and faces the camera."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import sheets
from origami.core.numeric.triangles import areas, directed_edges, interior_edges, signed_areas
from origami.core.surface.mesh import build_sheet, triangulate
from origami.core.surface.surface import reconstruct
from origami.core.surface.surface_settings import SurfaceSettings

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
NODES = np.stack(np.meshgrid(np.arange(0.05, 1, 0.1), np.arange(0.05, 1, 0.1)), -1).reshape(-1, 2)


def _has_edge(triangles, start, end) -> bool:
    return bool((np.isin(triangles, start).any(1) & np.isin(triangles, end).any(1)).any())


def test_a_square_is_covered_exactly_and_turns_one_way():
    mesh = triangulate(SQUARE, [], 0.1, NODES)
    signed = signed_areas(mesh.positions, mesh.triangles)
    assert (signed > 0).all()
    assert signed.sum() == pytest.approx(1.0)


def test_boundary_is_a_closed_loop_of_edges_in_order():
    mesh = triangulate(SQUARE, [], 0.1, NODES)
    for start, end in zip(mesh.boundary, np.roll(mesh.boundary, -1), strict=True):
        assert _has_edge(mesh.triangles, start, end)
    edge = mesh.positions[mesh.boundary]
    assert np.linalg.norm(np.roll(edge, -1, axis=0) - edge, axis=1).sum() == pytest.approx(4.0)


def test_creases_are_edges_of_the_mesh_from_side_to_side():
    crease = np.array([[0.0, 0.33], [1.0, 0.58]])
    mesh = triangulate(SQUARE, [crease], 0.1, NODES)
    (line,) = mesh.lines
    for start, end in pairwise(line):
        assert _has_edge(mesh.triangles, start, end)
    np.testing.assert_allclose(mesh.positions[line[[0, -1]]], crease, atol=1e-9)
    assert np.isin(line[[0, -1]], mesh.boundary).all()
    direction = (crease[1] - crease[0]) / np.linalg.norm(crease[1] - crease[0])
    across = (mesh.positions[line] - crease[0]) @ [-direction[1], direction[0]]
    assert np.abs(across).max() < 1e-9


def test_a_crease_into_a_corner_ends_at_the_corner():
    crease = np.array([[0.0, 0.0], [1.0, 0.97]])
    mesh = triangulate(SQUARE, [crease], 0.1, NODES)
    (line,) = mesh.lines
    np.testing.assert_allclose(mesh.positions[line[0]], [0, 0], atol=1e-9)
    for corner in SQUARE:
        assert np.linalg.norm(mesh.positions[mesh.boundary] - corner, axis=1).min() < 1e-9


def test_crossing_creases_share_a_vertex():
    creases = [np.array([[0.0, 0.5], [1.0, 0.5]]), np.array([[0.5, 0.0], [0.5, 1.0]])]
    mesh = triangulate(SQUARE, creases, 0.1, NODES)
    assert len(np.intersect1d(*mesh.lines)) == 1


def test_an_outline_with_a_notch_is_not_filled():
    notched = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.6, 1.0], [0.6, 0.6], [0.4, 0.6], [0.4, 1.0], [0.0, 1.0]])
    mesh = triangulate(notched, [], 0.1, NODES)
    assert signed_areas(mesh.positions, mesh.triangles).sum() == pytest.approx(1 - 0.2 * 0.4, rel=1e-3)


def test_interior_edges_of_two_triangles():
    edges, opposite = interior_edges(np.array([[0, 1, 2], [2, 1, 3]]))
    assert edges.tolist() == [[1, 2]]
    assert sorted(opposite[0].tolist()) == [0, 3]


def test_sheet_has_the_true_size_and_its_normals_face_the_camera():
    sheet, view = sheets.two_folds(), sheets.camera()
    points, _ = sheets.sample_points(sheet, view, 2000, noise=0.0003)
    polygon = sheets.outline_pixels(sheet, view)
    surface = reconstruct(points, view, polygon, SurfaceSettings(grid_rows=60))
    built = build_sheet(surface, polygon, [])
    assert areas(built.vertices, built.triangles).sum() == pytest.approx(sheets.WIDTH * sheets.HEIGHT, rel=0.005)
    corners = built.vertices[built.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((normals * (view.center - corners[:, 0])).sum(1) > 0).all()


def test_a_ragged_outline_leaves_no_pinches_and_one_loop():
    random = np.random.default_rng(3)
    angle = np.linspace(0, 2 * np.pi, 160, endpoint=False)
    radius = 0.45 + 0.03 * random.standard_normal(160)
    ragged = 0.5 + radius[:, None] * np.c_[np.cos(angle), np.sin(angle)]
    mesh = triangulate(ragged, [np.array([[0.1, 0.42], [0.9, 0.55]])], 0.05, NODES)
    edges, times = np.unique(np.sort(directed_edges(mesh.triangles), axis=1), axis=0, return_counts=True)
    rim = edges[times == 1]
    assert (np.bincount(rim.ravel())[np.unique(rim)] == 2).all()
    assert len(mesh.boundary) == len(rim)
    assert len(np.unique(mesh.triangles)) == len(mesh.positions)


@pytest.mark.parametrize("make", [sheets.cross, sheets.three_folds])
def test_a_sheet_cannot_cut_itself_because_each_ray_of_the_reference_view_meets_it_once(make):
    sheet, view = make(), sheets.camera()
    points, _ = sheets.sample_points(sheet, view, 800, noise=0.01, outliers=0.3)
    outline = sheets.outline_pixels(sheet, view)
    surface = reconstruct(points, view, outline, SurfaceSettings(grid_rows=30, smoothness=0.01))
    built = build_sheet(surface, outline, [])
    ways = signed_areas(view.project(built.vertices), built.triangles)
    assert (ways > 0).all() or (ways < 0).all()
    x, y = outline.T
    inside = 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert np.abs(ways).sum() == pytest.approx(inside, rel=0.01)  # no part lies before another
