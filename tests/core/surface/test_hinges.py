"""Hinges: a surface that turns at known creases is as exact as one without creases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sheets
from origami.core.surface.depth_grid import DepthGrid, frame_for, grid_over
from origami.core.surface.hinges import Hinges

# Three planes over the grid, one in each sector around a vertex; the highest shows.
SLOPES = np.array([[0.4, 0.0], [-0.3, 0.35], [-0.2, -0.3]])
VERTEX = np.array([0.013, -0.021])


def _three_planes(positions: np.ndarray) -> np.ndarray:
    return ((positions - VERTEX) @ SLOPES.T).max(-1)


def _creases_between_planes() -> tuple[np.ndarray, np.ndarray]:
    """The three rays from the vertex (3, 2, 2), longer than the grid, and the jump of slope at each."""
    ends, turns = [], []
    for one, other, third in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        jump = SLOPES[one] - SLOPES[other]
        ray = np.array([-jump[1], jump[0]]) / np.linalg.norm(jump)
        ray *= np.sign(ray @ (SLOPES[one] - SLOPES[third]))
        ends.append([VERTEX, VERTEX + 2 * ray])
        turns.append(np.linalg.norm(jump))
    return np.array(ends), np.array(turns)


@pytest.fixture(scope="module")
def grid() -> DepthGrid:
    sheet, view = sheets.plane(), sheets.camera()
    polygon = sheets.outline_pixels(sheet, view)
    frame = frame_for(sheets.mesh(sheet)[0].vertices, view, polygon)
    return grid_over(frame, frame.from_pixels(polygon), 25)


@pytest.fixture(scope="module")
def folded(grid: DepthGrid) -> tuple[DepthGrid, np.ndarray]:
    """The grid with hinges between the three planes, and the values of all its unknowns."""
    ends, turns = _creases_between_planes()
    values = np.concatenate([_three_planes(grid.node_positions()), turns])
    return replace(grid, hinges=Hinges(ends)), values


def test_planes_that_meet_at_hinges_are_exact_everywhere(folded):
    grid, values = folded
    random = np.random.default_rng(2)
    nodes = grid.node_positions()
    anywhere = nodes.min(0) + random.random((3000, 2)) * np.ptp(nodes, axis=0)
    on_creases = np.concatenate([VERTEX + share * (grid.hinges.ends[:, 1] - VERTEX) for share in (0.0, 0.05, 0.13)])
    positions = np.concatenate([anywhere, on_creases, nodes])
    positions = positions[grid.sampling_rows(positions)[1]]
    assert len(positions) > 2000
    np.testing.assert_allclose(grid.interpolate(values, positions), _three_planes(positions), atol=1e-8)


def test_without_hinges_the_same_creases_are_rounded(grid):
    on_crease = VERTEX + 0.05 * (_creases_between_planes()[0][:, 1] - VERTEX)
    error = grid.interpolate(_three_planes(grid.node_positions()), on_crease) - _three_planes(on_crease)
    assert np.abs(error).max() > 1e-3


def test_what_turns_at_hinges_is_not_bent(folded):
    grid, values = folded
    differences = grid.second_differences()
    for stencil in (differences.xx, differences.yy, differences.xy, differences.falling, differences.rising):
        assert np.abs(stencil.rows @ values).max() < 1e-8
        assert np.abs((stencil.rows @ values) - (stencil.rows[:, : grid.size] @ values[: grid.size])).max() > 1e-3
    for rows in grid.hessian_rows()[:3]:
        assert np.abs(rows @ values).max() < 1e-5


def test_a_hinge_ends_where_it_ends(grid):
    short = replace(grid, hinges=Hinges(np.array([[[-0.1, 0.013], [0.1, 0.013]]])))
    columns = short.second_differences().yy.rows[:, grid.size :].toarray()[:, 0]
    crossed = grid.node_positions()[short.second_differences().yy.nodes[columns != 0]]
    assert len(crossed) > 4
    assert np.abs(crossed[:, 0]).max() <= 0.1
    assert np.abs(crossed[:, 1] - 0.013).max() <= grid.step


def test_lifts_move_hinges_to_where_the_surface_turns(grid):
    """A line drawn beside a crease: the planes differ there by turn times distance, which the lifts take up."""
    true = Hinges(np.array([[[-0.8, 0.02], [0.8, -0.03]]]))
    slope = 0.7
    values = slope / 2 * np.abs((grid.node_positions() - true.ends[0, 0]) @ true.normals[0])
    drawn = Hinges(np.array([[[-0.8, 0.027], [0.8, -0.026]]]), movable=True)
    hinged = replace(grid, hinges=drawn)
    differences = hinged.second_differences()
    rows = np.vstack([each.rows.toarray() for each in (differences.xx, differences.yy, differences.xy)])
    nodes, hinge = rows[:, : grid.size], rows[:, grid.size :]
    # Nodes between the drawn line and the true one are on the wrong side for this to be exact.
    fit = np.linalg.lstsq(hinge, -nodes @ values, rcond=None)[0]
    moved = drawn.moved(fit, 1.0)
    assert np.abs(moved.displacement(drawn) - true.displacement(drawn)).max() < 0.002
    assert np.abs(true.displacement(drawn)).max() > 0.003
    np.testing.assert_allclose(fit[0], slope, rtol=0.1)


def test_hinges_that_meet_still_meet_when_moved():
    ends, turns = _creases_between_planes()
    hinges = Hinges(ends, movable=True)
    shift = np.array([0.004, -0.003])
    lifts = turns * (hinges.normals @ shift)
    moved = hinges.moved(np.concatenate([turns, lifts, lifts]), 1.0)
    assert len(np.unique(moved.ends[:, 0], axis=0)) == 1
    np.testing.assert_allclose(moved.ends[0, 0] - VERTEX, shift, rtol=0.1)
    np.testing.assert_allclose(((moved.ends[:, 1] - ends[:, 1]) * hinges.normals).sum(1), hinges.normals @ shift)
    np.testing.assert_allclose(np.linalg.norm(hinges.moved(np.tile([1.0, 9, 9], 3), 0.01).ends - ends, axis=2), 0.01)


def test_the_nearest_hinge_and_its_distance():
    hinges = Hinges(np.array([[[0.0, 0], [1, 0]], [[0, 1], [1, 1]]]))
    nearest, distance = hinges.nearest(np.array([[0.5, 0.2], [0.5, 0.9], [2.0, 1.0]]))
    assert nearest.tolist() == [0, 1, 1]
    np.testing.assert_allclose(distance, [0.2, 0.1, 1.0])
