"""Where paper goes on in shade beyond an outline."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.image import COLOR_WEIGHTS, perceptual
from origami.core.paper.shade import paper_in_shade

PLACES = 200
WHITE, PINK = (0.8, 0.8, 0.78), (0.85, 0.6, 0.62)
WOOD, GRAY = (0.35, 0.2, 0.1), (0.6, 0.6, 0.6)


def color(linear) -> np.ndarray:
    return perceptual(np.array(linear, np.float32)) * COLOR_WEIGHTS


def shaded(paper, table, beyond, part: float) -> np.ndarray:
    """What counts as shade where ``part`` of the outline has a colour ``beyond`` it, and the rest the table."""
    inside = np.tile(color(paper), (PLACES, 1))
    outside = np.where((np.arange(PLACES) < part * PLACES)[:, None], color(beyond), color(table))
    return paper_in_shade(inside, outside)


@pytest.mark.parametrize(("paper", "table"), [(WHITE, WOOD), (PINK, GRAY), (PINK, WOOD)])
def test_the_half_of_a_sheet_that_is_turned_from_the_lamp(paper, table):
    found = shaded(paper, table, 0.5 * np.array(paper), 0.25)
    np.testing.assert_array_equal(found, np.arange(PLACES) < 0.25 * PLACES)


def test_the_shadow_of_the_sheet_on_the_table_is_not_paper():
    assert not shaded(WHITE, WOOD, 0.5 * np.array(WOOD), 0.25).any()


def test_another_paper_of_another_colour_or_in_more_light_is_not_its_shade():
    assert not shaded(WHITE, WOOD, PINK, 0.25).any()
    assert not shaded(PINK, WOOD, 1.1 * np.array(PINK), 0.25).any()


def test_white_squares_of_a_cloth_are_shorter_than_a_side():
    assert not shaded(WHITE, WOOD, 0.6 * np.array(WHITE), 0.05).any()


def test_a_table_of_the_colour_of_the_paper_says_nothing():
    assert not shaded(WHITE, 0.7 * np.array(WHITE), 0.5 * np.array(WHITE), 0.25).any()


def test_print_that_crosses_the_edge_does_not_break_it():
    inside = np.tile(color(WHITE), (PLACES, 1))
    outside = np.tile(color(WOOD), (PLACES, 1))
    outside[:60] = color(0.5 * np.array(WHITE))
    outside[29] = color((0.02, 0.02, 0.02))
    assert paper_in_shade(inside, outside)[:60].all()
