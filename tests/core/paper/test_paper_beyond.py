"""Where paper goes on beyond an outline: unchanged, in shade and under print."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.image import COLOR_WEIGHTS, perceptual
from origami.core.paper.paper_beyond import in_shade, unchanged, under_print

PLACES, WIDE = 200, 8
WHITE, PINK = (0.8, 0.8, 0.78), (0.85, 0.6, 0.62)
WOOD, GRAY, BLACK = (0.35, 0.2, 0.1), (0.6, 0.6, 0.6), (0.02, 0.02, 0.02)


def color(linear) -> np.ndarray:
    return perceptual(np.array(linear, np.float32)) * COLOR_WEIGHTS


def strips(linear) -> np.ndarray:
    """Strips of one colour beside all places of an outline."""
    return np.tile(color(linear), (PLACES, WIDE, 1))


def shaded(inside: np.ndarray, outside: np.ndarray) -> np.ndarray:
    """`in_shade`, of strips."""
    return in_shade(np.median(inside, axis=1), np.median(outside, axis=1))


def beyond(table, other, part: float) -> np.ndarray:
    """Strips of the table, and for ``part`` of the outline of another colour."""
    outside = strips(table)
    outside[: round(part * PLACES)] = color(other)
    return outside


def first(part: float) -> np.ndarray:
    return np.arange(PLACES) < round(part * PLACES)


@pytest.mark.parametrize("part", [0.02, 0.2])
def test_a_line_of_print_that_the_outline_follows(part):
    inside, outside = (np.median(each, axis=1) for each in (strips(WHITE), beyond(WOOD, WHITE, part)))
    np.testing.assert_array_equal(unchanged(inside, outside, color(WHITE)), first(part))


def test_paper_along_most_of_an_outline_is_the_table():
    inside, outside = (np.median(each, axis=1) for each in (strips(WHITE), beyond(WOOD, WHITE, 0.6)))
    assert not unchanged(inside, outside, color(WHITE)).any()


@pytest.mark.parametrize(("paper", "table"), [(WHITE, WOOD), (PINK, GRAY), (PINK, WOOD)])
def test_the_half_of_a_sheet_that_is_turned_from_the_lamp(paper, table):
    found = shaded(strips(paper), beyond(table, 0.5 * np.array(paper), 0.25))
    np.testing.assert_array_equal(found, first(0.25))


def test_the_shadow_of_the_sheet_on_the_table_is_not_paper():
    assert not shaded(strips(WHITE), beyond(WOOD, 0.5 * np.array(WOOD), 0.25)).any()


def test_another_paper_of_another_colour_or_in_more_light_is_not_its_shade():
    assert not shaded(strips(WHITE), beyond(WOOD, PINK, 0.25)).any()
    assert not shaded(strips(PINK), beyond(WOOD, 1.1 * np.array(PINK), 0.25)).any()


@pytest.mark.parametrize("sign", [shaded, under_print])
def test_white_squares_of_a_cloth_are_shorter_than_a_side(sign):
    assert not sign(strips(WHITE), beyond(WOOD, 0.95 * np.array(WHITE), 0.05)).any()


@pytest.mark.parametrize("sign", [shaded, under_print])
def test_a_table_of_the_colour_of_the_paper_says_nothing(sign):
    assert not sign(strips(WHITE), beyond(0.95 * np.array(WHITE), 0.9 * np.array(WHITE), 0.25)).any()


def test_print_that_crosses_the_edge_does_not_break_it():
    outside = beyond(WOOD, 0.5 * np.array(WHITE), 0.3)
    outside[29] = color(BLACK)
    assert shaded(strips(WHITE), outside)[:60].all()


def test_the_end_of_a_receipt_beyond_its_barcode():
    outside = beyond(WOOD, BLACK, 0.2)
    outside[:40:2] = color(WHITE)
    found = under_print(strips(WHITE), outside)
    assert found[:40].all()
    assert not found[44:-4].any()  # the ground is looked for two places around each


def test_a_dark_table_with_light_grain_is_not_paper_under_print():
    outside = beyond(WOOD, WOOD, 0.2)
    outside[:40:2] = color(GRAY)
    assert not under_print(strips(WHITE), outside).any()
