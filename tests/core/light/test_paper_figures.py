"""The figures of blank paper: its colour, unevenness and noise are those that were put into the page."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.light.blank_paper import even_cells
from origami.core.light.paper_figures import measure_paper
from origami.core.numeric.cielab import cielab
from origami.core.numeric.image import encoded, linear_light

SIZE = (900, 1200)
TONE = np.array([0.80, 0.76, 0.66])


def page(light=1.0, noise=0.0, dtype=np.uint8, paper=TONE):
    """Toned paper with strokes on its left half, in a light (H, W), with noise in linear light."""
    reflectance = np.broadcast_to(paper, (SIZE[1], SIZE[0], 3)).copy()
    reflectance[60:1100:20, 60:450] *= 0.1
    random = np.random.default_rng(3).standard_normal((SIZE[1], SIZE[0], 1))
    return encoded(
        (reflectance * np.asarray(light)[..., None] * (1 + noise * random)).astype(np.float32), np.dtype(dtype)
    )


def figures(image):
    covered = np.ones(image.shape[:2], bool)
    blank = even_cells(image, covered).share > 0
    blank[:, : blank.shape[1] // 2] = False
    return measure_paper(image, covered, blank)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_the_papers_tone_is_measured(dtype):
    found = figures(page(dtype=dtype))
    np.testing.assert_allclose(found.color, cielab(TONE), atol=0.25)
    assert found.unevenness == pytest.approx(0, abs=0.01)
    assert found.noise == pytest.approx(0, abs=0.01)


def test_light_that_falls_off_is_uneven_and_not_noisy():
    light = np.broadcast_to(np.linspace(1.0, 0.8, SIZE[1])[:, None], (SIZE[1], SIZE[0]))
    found = figures(page(light=light, dtype=np.uint16))
    ends = cielab(TONE * 1.0)[0] - cielab(TONE * 0.8)[0]
    assert found.unevenness == pytest.approx(0.9 * ends, rel=0.03)
    assert found.noise == pytest.approx(0, abs=0.02)


def test_noise_is_that_of_a_pixel():
    image = page(noise=0.008, dtype=np.uint16)
    light = cielab(linear_light(image[600:1150, 500:880]))[..., 0]
    found = figures(image)
    assert found.noise == pytest.approx(light.std(), rel=0.05)
    assert found.unevenness < 0.5


def test_paper_that_is_nowhere_even_has_no_figures():
    image = page()
    covered = np.ones(image.shape[:2], bool)
    assert measure_paper(image, covered, np.zeros(even_cells(image, covered).share.shape, bool)) is None
