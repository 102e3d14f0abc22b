"""Which way up a page is read: right, or openly unsure."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.page.upright import reading_direction
from scipy import ndimage


def page_of_text(seed=0, x_height=12, above=0.3, below=0.1, size=(1200, 900)):
    """Rows of simple letters: bodies of strokes, some with a stroke upwards, fewer with one downwards."""
    rng = np.random.default_rng(seed)
    page = np.full(size, 230.0)
    stroke = max(2, x_height // 5)
    for base in range(4 * x_height, size[0] - 3 * x_height, int(2.6 * x_height)):
        left = 60
        while left < size[1] - 80 - rng.integers(0, 60):
            for _ in range(rng.integers(2, 9)):
                wide = int(x_height * rng.uniform(0.5, 1.0))
                page[base - x_height : base, left : left + stroke] = 40
                page[base - x_height : base, left + wide - stroke : left + wide] = 40
                where = rng.choice([base - x_height, base - stroke])
                page[where : where + stroke, left : left + wide] = 40
                kind = rng.random()
                if kind < above:
                    page[base - int(1.6 * x_height) : base, left : left + stroke] = 40
                elif kind < above + below:
                    page[base : base + int(0.5 * x_height), left : left + stroke] = 40
                left += wide + stroke
            left += x_height // 2
    return ndimage.gaussian_filter(page, 0.7)


@pytest.mark.parametrize("turns", range(4))
@pytest.mark.parametrize("x_height", [7, 14])
def test_text_is_turned_upright(turns, x_height):
    turned = np.rot90(page_of_text(x_height=x_height), turns)  # counter-clockwise
    found, confidence = reading_direction(turned)
    assert found == turns
    assert confidence > 0.8


def test_shade_noise_and_a_slant_do_not_matter():
    page = ndimage.rotate(page_of_text(), 1.0, mode="nearest", reshape=False)
    page = page * np.linspace(0.5, 1, page.shape[1]) + np.random.default_rng(0).normal(0, 4, page.shape)
    found, confidence = reading_direction(np.rot90(page, 2))
    assert found == 2
    assert confidence > 0.5


def test_light_print_on_dark_paper_is_read_too():
    found, confidence = reading_direction(np.rot90(255 - page_of_text(), 1))
    assert found == 1
    assert confidence > 0.8


def test_letters_that_reach_up_and_down_alike_leave_it_open():
    for seed in range(3):
        assert reading_direction(page_of_text(seed, above=0.0, below=0.0))[1] < 0.5


@pytest.mark.parametrize("kind", ["blank", "noise", "clouds", "stripes", "one colour"])
def test_pages_without_text_leave_it_open(kind):
    rng = np.random.default_rng(1)
    noise = rng.random((900, 700))
    page = {
        "blank": 200 + noise,
        "noise": 255 * noise,
        "clouds": 255 * ndimage.gaussian_filter(noise, 6),
        "stripes": 100 + 100 * (np.arange(900)[:, None] // 9 % 2) + noise,
        "one colour": np.full((900, 700), 77),
    }[kind]
    assert reading_direction(page)[1] < 0.5
