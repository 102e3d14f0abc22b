"""The three priors: what they allow and what they restrain."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from origami.core.surface.curvature import PrincipalCurvature
from origami.core.surface.depth_grid import DepthGrid, frame_for, grid_over
from origami.core.surface.smoothness import developable_smoothness, isotropic_smoothness, ridge_smoothness


@pytest.fixture(scope="module")
def grid() -> DepthGrid:
    sheet, view = sheets.plane(), sheets.camera()
    polygon = sheets.outline_pixels(sheet, view)
    frame = frame_for(sheets.mesh(sheet)[0].vertices, view, polygon)
    return grid_over(frame, frame.from_pixels(polygon), 30)


def _energy(form, values) -> float:
    return float(values @ (form @ values))


def _turned(grid: DepthGrid, degrees: float) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates along and across a direction, at the nodes."""
    x, y = grid.node_positions().T
    angle = np.radians(degrees)
    return np.cos(angle) * x + np.sin(angle) * y, -np.sin(angle) * x + np.cos(angle) * y


def _all_along(grid: DepthGrid, degrees: float, across: float) -> PrincipalCurvature:
    nodes = grid.hessian_rows()[3]
    angle = np.radians(degrees)
    direction = np.tile([np.cos(angle), np.sin(angle)], (len(nodes), 1))
    return PrincipalCurvature(nodes, np.zeros(len(nodes)), np.full(len(nodes), across), direction)


def test_planes_cost_nothing(grid):
    x, y = grid.node_positions().T
    plane = 3 + 2 * x - y
    nodes = np.arange(grid.size)
    differences = grid.second_differences()
    forms = (
        isotropic_smoothness(differences),
        ridge_smoothness(grid.size, differences, nodes, np.tile([1.0, 0.0], (grid.size, 1)), 10.0),
        developable_smoothness(grid, _all_along(grid, 30, 0.0)),
    )
    for form in forms:
        assert abs(_energy(form, plane)) < 1e-13 * form.diagonal().sum() * (plane**2).max()


def test_isotropic_smoothness_does_not_care_for_direction(grid):
    form = isotropic_smoothness(grid.second_differences())
    energies = [_energy(form, _turned(grid, degrees)[1] ** 2) for degrees in (0, 30, 45, 90)]
    # Fewer stencils fit along the rim in one direction than in another.
    np.testing.assert_allclose(energies, energies[0], rtol=0.1)


def test_without_candidates_ridge_smoothness_is_the_isotropic_one(grid):
    differences = grid.second_differences()
    form = ridge_smoothness(grid.size, differences, np.zeros(0, int), np.zeros((0, 2)), 10.0)
    assert abs(form - isotropic_smoothness(differences)).max() < 1e-12


@pytest.mark.parametrize("degrees", [0, 45, 90])
def test_a_ridge_may_bend_across_itself_and_not_along(grid, degrees):
    differences = grid.second_differences()
    along, across = _turned(grid, degrees)
    direction = np.tile([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))], (grid.size, 1))
    form = ridge_smoothness(grid.size, differences, np.arange(grid.size), direction, 100.0)
    assert _energy(form, across**2) < 0.1 * _energy(form, along**2)


@pytest.mark.parametrize("degrees", [0, 20, 45, 90])
def test_the_developable_prior_holds_rulings_and_frees_creases(grid, degrees):
    along, across = _turned(grid, degrees)
    at_a_crease = developable_smoothness(grid, _all_along(grid, degrees, 40.0))
    assert _energy(at_a_crease, across**2) < 1e-3 * _energy(at_a_crease, along**2)
    assert _energy(at_a_crease, across**2) < 0.05 * _energy(at_a_crease, along * across)
    where_flat = developable_smoothness(grid, _all_along(grid, degrees, 0.0))
    assert _energy(at_a_crease, across**2) < 0.05 * _energy(where_flat, across**2)
