"""The gutter of a drawn book, whose pages differ a little in shade; print beside it is ten times as strong."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.polygon import inside_polygon, resample
from origami.core.paper.straight_side import longest_stretch, straight_side

SHAPE = (300, 260)
# The right page's corners, clockwise from the gutter's upper end.
PAGE = np.array([[80.0, 40.0], [220.0, 50.0], [210.0, 260.0], [60.0, 250.0]])


def book(step: float, valley: float = 0.0) -> np.ndarray:
    """Lightness (h, w) of two pages beside the gutter, with lines of print on both."""
    rows, columns = np.indices(SHAPE) + 0.5
    gutter = PAGE[3, 0] + (PAGE[0, 0] - PAGE[3, 0]) * (rows - PAGE[3, 1]) / (PAGE[0, 1] - PAGE[3, 1])
    right = np.clip(columns - gutter + 0.5, 0, 1)
    lightness = 80 + step * right - valley * np.exp(-(((columns - gutter) / 4) ** 2))
    print_ = (rows % 14 < 4) & (np.abs(columns - gutter) > 12) & (np.abs(columns - gutter) < 120)
    noise = np.random.default_rng(3).normal(scale=0.3, size=SHAPE)
    return (lightness - 30 * print_ + noise).astype(np.float32)


def followed() -> tuple[np.ndarray, np.ndarray]:
    """An outline that follows the beginnings of lines in place of the gutter, and where it is open."""
    outline = resample(PAGE, 2.0)
    along = PAGE[0] - PAGE[3]
    off = np.abs((outline[:, 0] - PAGE[3, 0]) * along[1] - (outline[:, 1] - PAGE[3, 1]) * along[0])
    on_gutter = off / np.linalg.norm(along) < 1
    ragged = outline + np.where(on_gutter, 10 + 3 * np.sin(outline[:, 1] / 3), 0)[:, None] * [1, 0]
    return ragged, on_gutter


@pytest.mark.parametrize(("step", "valley"), [(3.0, 0.0), (-3.0, 0.0), (0.0, 4.0)])
def test_a_gutter_is_found_beside_print(step, valley):
    outline, is_open = followed()
    side = straight_side(book(step, valley), outline, is_open, size=180.0)
    assert side is not None
    assert side.distance(PAGE[[0, 3]]).max() < 1.5
    beyond = side.beyond(SHAPE)
    page = inside_polygon(np.stack(np.indices(SHAPE)[::-1], -1).reshape(-1, 2) + 0.5, PAGE).reshape(SHAPE)
    assert beyond[page].mean() < 0.02
    assert beyond[150, 20]


@pytest.mark.parametrize("step", [0.0, 3.0])
def test_the_ruled_border_of_a_table_is_no_side(step):
    outline, is_open = followed()
    lightness = book(step)
    rows, columns = np.indices(SHAPE) + 0.5
    border = PAGE[3, 0] + 9 + (PAGE[0, 0] - PAGE[3, 0]) * (rows - PAGE[3, 1]) / (PAGE[0, 1] - PAGE[3, 1])
    lightness[np.abs(columns - border) < 0.75] -= 40
    side = straight_side(lightness, outline, is_open, size=180.0)
    if step:
        assert side is not None
        assert side.distance(PAGE[[0, 3]]).max() < 1.5
    else:
        assert side is None


def test_print_alone_is_no_side():
    outline, is_open = followed()
    assert straight_side(book(0.0), outline, is_open, size=180.0) is None


def test_an_outline_that_is_hardly_open_has_none():
    outline, is_open = followed()
    few = is_open & (np.cumsum(is_open) <= 5)
    assert straight_side(book(3.0), outline, few, size=180.0) is None


def test_an_open_stretch_around_a_corner_has_none():
    outline, _ = followed()
    middle = outline[:, 1] < 150
    assert straight_side(book(3.0), outline, middle, size=180.0) is None


def test_the_longest_stretch_runs_over_the_end_and_over_short_gaps():
    marked = np.zeros(100, bool)
    marked[[*range(92, 100), *range(6), *range(8, 12), *range(40, 50)]] = True
    np.testing.assert_array_equal(longest_stretch(marked), [*range(92, 100), *range(12)])
    assert len(longest_stretch(np.zeros(10, bool))) == 0
    np.testing.assert_array_equal(longest_stretch(np.ones(10, bool)), np.arange(10))
