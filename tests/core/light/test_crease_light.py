"""Beside a crease the light is taken from the blank paper along it, and print stays."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.light.crease_light import light_beside_creases
from origami.core.numeric.image import encoded, linear_light
from origami.core.sheet import FlatMap, Sheet

HEIGHT, WIDTH = 800, 600
SLOPE = 0.03  # of the crease, which runs across the page through its middle
PAPER = 0.6


def creased():
    """A flat sheet whose crease runs across it, slightly askew, and its flat map in pixels of the page."""
    x = np.linspace(0, WIDTH, 21)
    y = [np.zeros(21), HEIGHT / 2 + SLOPE * (x - WIDTH / 2), np.full(21, HEIGHT)]
    uv = np.stack([np.tile(x, 3), np.concatenate(y)], axis=1)
    number = np.arange(63).reshape(3, 21)
    a, b, c, d = number[:-1, :-1].ravel(), number[1:, :-1].ravel(), number[:-1, 1:].ravel(), number[1:, 1:].ravel()
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([c, b, d], 1)])
    boundary = np.concatenate([number[:, 0], number[-1, 1:], number[1::-1, -1], number[0, -2:0:-1]])
    sheet = Sheet(np.column_stack([uv, np.zeros(63)]), triangles, (number[1],), boundary)
    return sheet, FlatMap(uv, float(WIDTH), float(HEIGHT), "mm", 1.0)


def across():
    """The distance (H, W) of each pixel of the page from the crease, pixels, positive below it."""
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    return (y - HEIGHT / 2 - SLOPE * (x - WIDTH / 2)) / np.hypot(1, SLOPE)


def rounded():
    """Logarithm of the light (H, W) less that of a model with a sharp edge: brighter above the crease, darker below."""
    return 0.15 * np.sign(across()) * np.exp(-((across() / 2.5) ** 2)) * -1


def corrected(reflectance, light, dtype=np.uint8):
    """What is left of the light (H, W) on the page, divided by the model's and by its correction beside the crease."""
    noise = np.random.default_rng(0).normal(0, 0.005, (HEIGHT, WIDTH, 1))
    page = np.asarray(reflectance)[..., None] * PAPER * np.exp(light)[..., None] * (1 + noise)
    image = encoded(np.repeat(page, 3, axis=-1).astype(np.float32), dtype)
    sheet, flat = creased()

    def model(rows):
        return np.full((rows.stop - rows.start, WIDTH, 3), PAPER, np.float32)

    creases = light_beside_creases(image, sheet, flat, model)
    out = model(slice(0, HEIGHT))
    for top in (0, 300):  # by parts of the page, as it is made
        creases.correct(out[top : 300 if top == 0 else HEIGHT], top)
    return np.log(linear_light(image) / out).mean(axis=-1)


def near():
    return np.abs(across()) < 5


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_paper_that_bends_in_a_curve_becomes_even(dtype):
    before = rounded()
    after = corrected(np.ones((HEIGHT, WIDTH)), rounded(), dtype)
    assert before[near()].std() > 0.07
    assert after[near()].std() < 0.012  # half of it is the noise
    assert np.abs(after[near()].mean()) < 0.005


def test_light_that_changes_along_the_crease_is_followed():
    grows = np.linspace(0.4, 1.0, WIDTH) * rounded()
    assert corrected(np.ones((HEIGHT, WIDTH)), grows)[near()].std() < 0.015


def test_print_across_the_crease_keeps_its_contrast():
    reflectance = np.ones((HEIGHT, WIDTH))
    reflectance[:, 100:400:12] = 0.2
    reflectance[:, 101:400:12] = 0.2
    after = corrected(reflectance, rounded())
    ink, paper = near() & (reflectance < 1), near() & (reflectance == 1)
    assert np.abs(np.median(after[paper])) < 0.01
    assert np.abs(np.median(after[ink]) - np.log(0.2)) < 0.03
    assert np.quantile(np.abs(after[paper]), 0.9) < 0.05


@pytest.mark.parametrize("begins", [0, 3])
def test_a_tinted_row_of_a_table_beside_the_crease_stays(begins):
    reflectance = np.ones((HEIGHT, WIDTH))
    tinted = across() > begins
    tinted[:, :90] = tinted[:, -90:] = False
    reflectance[tinted] = 0.9
    after = corrected(reflectance, rounded())
    assert np.abs(np.median(after[tinted & near()]) - np.log(0.9)) < 0.02
    assert np.abs(np.median(after[~tinted & near()])) < 0.01


def test_a_side_that_is_tinted_all_along_stays_as_it_is():
    reflectance = np.where(across() > 0, 0.88, 1.0)
    after = corrected(reflectance, np.zeros((HEIGHT, WIDTH)))
    below = near() & (across() > 1)
    assert np.abs(after[below] - np.log(0.88)).mean() < 0.01


def test_a_rule_along_the_crease_stays():
    reflectance = np.where(np.abs(across() - 3) < 1, 0.3, 1.0)
    after = corrected(reflectance, np.zeros((HEIGHT, WIDTH)))
    assert np.median(after[np.abs(across() - 3) < 0.5]) < np.log(0.35)


def test_away_from_the_crease_nothing_changes():
    light = np.full((HEIGHT, WIDTH), -0.3)
    after = corrected(np.ones((HEIGHT, WIDTH)), light)
    assert np.abs(after[np.abs(across()) > 12] + 0.3).mean() < 0.01


def test_a_sheet_without_creases_has_no_light_beside_them():
    sheet, flat = creased()
    image = np.full((HEIGHT, WIDTH, 3), 200, np.uint8)
    smooth = Sheet(sheet.vertices, sheet.triangles, (), sheet.boundary)
    creases = light_beside_creases(image, smooth, flat, lambda rows: np.ones((1, 1, 3), np.float32))
    assert len(creases.pixels) == 0
