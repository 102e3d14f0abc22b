"""Quadrilaterals whose sides lie on other edges than those they begin at."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.paper.parallel_edges import evenness, quadrilaterals_on_parallel_edges

PAPER = np.array([[60.0, 40.0], [180.0, 40.0], [180.0, 200.0], [60.0, 200.0]])
PRINT = np.array([[75.0, 60.0], [165.0, 60.0], [165.0, 185.0], [75.0, 185.0]])


def a_sheet(step: float) -> np.ndarray:
    """A map of a table with a sheet that is lighter by ``step``, and rows of dark blocks on it."""
    color = np.full((240, 240, 3), 70.0, np.float32)
    color[..., 1:] = 0
    color[40:200, 60:180, 0] += step
    for top in range(60, 180, 25):
        for left in range(75, 160, 24):
            color[top : top + 15, left : left + 14, 0] = 10
    return color


@pytest.mark.parametrize("step", [20, 3])
def test_the_edge_of_the_paper_is_found_from_that_of_its_print_however_faint(step):
    found = quadrilaterals_on_parallel_edges(a_sheet(step), PRINT, 5)
    assert min(np.abs(each - PAPER).max() for each in found) < 2


def test_the_sheet_is_found_from_a_board_around_it():
    color = a_sheet(15)
    board = np.array([[30.0, 20.0], [210.0, 20.0], [210.0, 230.0], [30.0, 230.0]])
    found = quadrilaterals_on_parallel_edges(color, board, 5)
    assert min(np.abs(each - PAPER).max() for each in found) < 2


def test_quadrilaterals_run_as_the_given_one_does_and_keep_a_part_of_its_depth():
    found = quadrilaterals_on_parallel_edges(a_sheet(10), PRINT, 200)
    assert 1 < len(found) <= 200
    for corners in found:
        side = np.roll(corners, -1, axis=0) - corners
        turn = side[:, 0] * np.roll(side[:, 1], -1) - side[:, 1] * np.roll(side[:, 0], -1)
        assert (turn > 0).all()
        assert np.linalg.norm(side, axis=1).min() > 0.25 * 90 - 1e-6


def test_nothing_is_found_where_nothing_is():
    assert not len(quadrilaterals_on_parallel_edges(np.zeros((240, 240, 3), np.float32), PRINT, 5))


def test_a_faint_edge_without_gaps_is_evener_than_a_strong_one_with_gaps():
    color = a_sheet(3)
    top_of_paper = evenness(color, np.array([60.0, 40.0]), np.array([180.0, 40.0]))
    top_of_print = evenness(color, np.array([75.0, 60.0]), np.array([165.0, 60.0]))
    assert top_of_paper > top_of_print + 0.1


def test_a_pen_across_an_edge_takes_little_from_it():
    color = a_sheet(20)
    whole = evenness(color, np.array([60.0, 40.0]), np.array([180.0, 40.0]))
    color[:, 100:115] = 5
    covered = evenness(color, np.array([60.0, 40.0]), np.array([180.0, 40.0]))
    assert 0.8 * whole < covered < whole
