"""Inexactly drawn creases meet each other and the paper's edge."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.creases.drawn_creases import crease_lines

SQUARE = np.array([[-0.4, -0.5], [0.4, -0.5], [0.4, 0.5], [-0.4, 0.5]])
STEP = 0.012


def _lines(*drawn: list[list[float]]) -> np.ndarray:
    return crease_lines(np.array(drawn), SQUARE, STEP)


def test_a_crease_that_ends_shortly_before_the_edge_goes_on_beyond_it():
    (line,) = _lines([[-0.38, 0.1], [0.37, 0.1]])
    assert line[0, 0] < -0.4 - 3 * STEP
    assert line[1, 0] > 0.4 + 3 * STEP
    np.testing.assert_allclose(line[:, 1], 0.1)


def test_a_crease_that_ends_within_the_paper_stays_as_it_is():
    (line,) = _lines([[-0.1, 0.1], [0.2, 0.0]])
    np.testing.assert_allclose(line, [[-0.1, 0.1], [0.2, 0.0]])


def test_crossing_creases_share_one_place():
    lines = _lines([[-0.38, 0.0], [0.38, 0.0]], [[0.1, -0.48], [0.1, 0.48]])
    assert len(lines) == 4
    places, times = np.unique(lines.reshape(-1, 2), axis=0, return_counts=True)
    np.testing.assert_allclose(places[times == 4], [[0.1, 0.0]], atol=1e-12)


@pytest.mark.parametrize("slip", [-0.008, 0.0, 0.008])
def test_a_crease_that_ends_at_another_ends_on_it(slip):
    """Drawn a little too short or too long."""
    lines = _lines([[-0.38, 0.0], [0.38, 0.05]], [[0.1, 0.0313 + slip], [0.1, 0.48]])
    assert len(lines) == 3
    places, times = np.unique(lines.reshape(-1, 2), axis=0, return_counts=True)
    assert sorted(times.tolist()) == [1, 1, 1, 3]
    np.testing.assert_allclose(places[times == 3], [[0.1, 0.0316]], atol=1e-3)


def test_half_creases_around_a_vertex_meet_in_it():
    random = np.random.default_rng(4)
    outer = np.array([[-0.39, 0.1], [0.39, -0.05], [0.0, 0.48], [0.1, -0.49]])
    drawn = [[end, [0.05, 0.02] + 0.002 * random.standard_normal(2)] for end in outer]
    lines = crease_lines(np.array(drawn), SQUARE, STEP)
    assert len(lines) == 4
    places, times = np.unique(lines.reshape(-1, 2), axis=0, return_counts=True)
    assert sorted(times.tolist()) == [1, 1, 1, 1, 4]
    np.testing.assert_allclose(places[times == 4], [[0.05, 0.02]], atol=0.004)


def test_three_creases_through_nearly_one_place_meet_in_one():
    lines = _lines([[-0.39, 0.003], [0.39, 0.0]], [[0.0, -0.49], [0.004, 0.49]], [[-0.3, -0.3], [0.3, 0.306]])
    assert len(lines) == 6
    assert np.unique(lines.reshape(-1, 2), axis=0, return_counts=True)[1].max() == 6


def test_what_lies_off_the_paper_is_left_out():
    assert len(_lines([[0.5, 0.0], [0.9, 0.3]])) == 0
    assert len(crease_lines(np.zeros((0, 2, 2)), SQUARE, STEP)) == 0
    assert len(_lines([[0.5, 0.0], [0.9, 0.3]], [[-0.9, 0.2], [0.9, 0.2]])) == 1


def test_parallel_creases_do_not_meet():
    assert len(_lines([[-0.3, 0.0], [0.3, 0.0]], [[-0.3, 0.2], [0.3, 0.2]])) == 2
