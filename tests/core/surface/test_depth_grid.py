"""The grid of inverse depths: planes are exact, derivatives and interpolation have their known values."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from origami.core.surface.depth_grid import DepthGrid, ViewFrame, frame_for, grid_over


@pytest.fixture
def grid() -> DepthGrid:
    sheet, view = sheets.plane(), sheets.camera()
    polygon = sheets.outline_pixels(sheet, view)
    frame = frame_for(sheets.mesh(sheet)[0].vertices, view, polygon)
    return grid_over(frame, frame.from_pixels(polygon), 40)


def _frame() -> ViewFrame:
    return ViewFrame(sheets.camera(), 2.0, 0.5)


def test_world_to_plane_and_back():
    points = np.random.default_rng(0).uniform(-0.3, 0.3, (100, 3))
    frame = _frame()
    plane, inverse_depth = frame.from_world(points)
    np.testing.assert_allclose(frame.to_world(plane, inverse_depth), points, atol=1e-12)


def test_plane_coordinates_agree_with_pixels():
    points = np.random.default_rng(0).uniform(-0.3, 0.3, (100, 3))
    frame = _frame()
    plane, _ = frame.from_world(points)
    np.testing.assert_allclose(frame.from_pixels(frame.camera.project(points)), plane, atol=1e-9)


def test_a_plane_has_linear_inverse_depth(grid: DepthGrid):
    vertices = sheets.mesh(sheets.plane())[0].vertices
    plane, inverse_depth = grid.frame.from_world(vertices)
    design = np.column_stack([plane, np.ones(len(plane))])
    fit = design @ np.linalg.lstsq(design, inverse_depth, rcond=None)[0]
    np.testing.assert_allclose(fit, inverse_depth, atol=1e-12)


def test_unit_is_the_page_as_the_view_shows_it(grid: DepthGrid):
    assert grid.frame.unit == pytest.approx(1.0, rel=0.1)


def test_sampling_rows_interpolate_linear_functions_exactly(grid: DepthGrid):
    nodes = grid.node_positions()
    values = 3 + nodes @ [2.0, -1.0]
    inside_page = np.random.default_rng(2).uniform(-0.2, 0.2, (50, 2))
    rows, inside = grid.sampling_rows(inside_page)
    assert inside.all()
    np.testing.assert_allclose(rows @ values, 3 + inside_page @ [2.0, -1.0], atol=1e-12)


def test_interpolation_is_exact_for_quadratics(grid: DepthGrid):
    def bent(p: np.ndarray) -> np.ndarray:
        return 2 + p @ [0.3, -0.2] + 4 * p[:, 0] ** 2 - 3 * p[:, 1] ** 2 + p[:, 0] * p[:, 1]

    places = np.random.default_rng(2).uniform(-0.2, 0.2, (50, 2))
    np.testing.assert_allclose(grid.interpolate(bent(grid.node_positions()), places), bent(places), atol=1e-12)
    with pytest.raises(ValueError, match="off the grid"):
        grid.interpolate(np.zeros(grid.size), np.array([[9.0, 9.0]]))


def test_positions_off_the_grid_are_distinguished(grid: DepthGrid):
    rows, inside = grid.sampling_rows(np.array([[0.0, 0.0], [9.0, 9.0]]))
    assert inside.tolist() == [True, False]
    assert rows.shape[0] == 1


def test_hessian_rows_give_the_second_derivatives_of_a_quadratic(grid: DepthGrid):
    x, y = grid.node_positions().T
    values = 1.5 * x**2 - 0.7 * x * y + 0.25 * y**2 + x - 2
    xx, xy, yy, nodes = grid.hessian_rows()
    assert 0 < len(nodes) < grid.size
    np.testing.assert_allclose(xx @ values, 3.0, atol=1e-9)
    np.testing.assert_allclose(xy @ values, -0.7, atol=1e-9)
    np.testing.assert_allclose(yy @ values, 0.5, atol=1e-9)


def test_second_differences_along_each_direction(grid: DepthGrid):
    x, y = grid.node_positions().T
    values = 1.5 * x**2 - 0.7 * x * y + 0.25 * y**2
    differences = grid.second_differences()
    square = grid.step**2
    np.testing.assert_allclose(differences.xx.rows @ values / square, 3.0, atol=1e-9)
    np.testing.assert_allclose(differences.yy.rows @ values / square, 0.5, atol=1e-9)
    np.testing.assert_allclose(differences.xy.rows @ values / square, -0.7, atol=1e-9)
    # Along (1, 1)/sqrt 2 the second derivative is (3 + 0.5)/2 - 0.7, along (-1, 1)/sqrt 2 it is (3 + 0.5)/2 + 0.7.
    np.testing.assert_allclose(differences.falling.rows @ values / square, 1.05, atol=1e-9)
    np.testing.assert_allclose(differences.rising.rows @ values / square, 2.45, atol=1e-9)


def test_node_values_as_an_image(grid: DepthGrid):
    image = grid.to_image(np.arange(grid.size, dtype=float))
    assert image.shape == grid.index.shape
    np.testing.assert_array_equal(image[grid.index >= 0], grid.index[grid.index >= 0])
    assert np.isnan(image[grid.index < 0]).all()


def test_the_grid_covers_the_outline(grid: DepthGrid):
    polygon = grid.frame.from_pixels(sheets.outline_pixels(sheets.plane(), sheets.camera()))
    assert grid.sampling_rows(polygon)[1].all()
