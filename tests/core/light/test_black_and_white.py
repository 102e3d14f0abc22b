"""Ink and paper are distinguished, however thin or light the strokes, and blank paper stays blank."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.light import black_and_white
from origami.core.light.black_and_white import find_ink
from origami.core.numeric.image import encoded
from scipy import ndimage

SHAPE = (400, 300)
BLUR = 0.8  # pixels


def page() -> np.ndarray:
    """Reflectance of blank paper."""
    return np.ones(SHAPE, np.float32)


def photographed(reflectance, light=1.0, noise=0.012, dtype=np.uint8):
    blurred = ndimage.gaussian_filter(reflectance, BLUR) * light
    blurred = blurred + np.random.default_rng(1).normal(0, noise, SHAPE) * np.sqrt(np.maximum(blurred, 0.05))
    return encoded(blurred.astype(np.float32), np.dtype(dtype))


def uneven():
    return np.linspace(1, 0.45, SHAPE[1]) * np.linspace(1, 0.9, SHAPE[0])[:, None]


@pytest.mark.parametrize("light", [1.0, 0.88, uneven()], ids=["white", "paper", "as photographed"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_blank_paper_stays_blank(light, dtype):
    for noise in (0.0, 0.012, 0.03):
        assert find_ink(photographed(page(), light, noise, dtype)).sum() <= 10


@pytest.mark.parametrize("light", [1.0, uneven()], ids=["white", "as photographed"])
@pytest.mark.parametrize(("width", "tone"), [(1, 0.04), (1, 0.5), (2, 0.6), (0.5, 0.04)])
def test_hairlines_stay(light, width, tone):
    reflectance = page()
    share = min(width, 1) * (1 - tone)  # of the light that a pixel of the line loses
    rows = slice(200, 200 + max(1, round(width)))
    reflectance[rows, 20:280] -= share
    reflectance[40:180, 150:152] = 0.04  # beside bold print
    ink = find_ink(photographed(reflectance, light))
    assert ink[199:203, 25:275].any(axis=0).mean() > 0.98
    assert ink[210:].sum() <= 4
    assert ink[198:204].any(axis=1).sum() <= 4


def test_thin_strokes_between_bold_ones_stay():
    reflectance = page()
    for left in range(20, 280, 16):
        reflectance[100:130, left : left + 4] = 0.04
        reflectance[114, left : left + 14] = 0.4
    ink = find_ink(photographed(reflectance))
    between = ink[113:116, 30:34] | ink[113:116, 46:50]
    assert between.any(axis=0).all()
    assert not ink[104:110, 27:33].any()  # the space between the stems


def test_a_tinted_box_is_paper_and_its_print_is_ink():
    reflectance = page()
    reflectance[100:300, 50:250] = 0.6
    reflectance[150:154, 100:200] = 0.04
    ink = find_ink(photographed(reflectance))
    assert ink[151:153, 102:198].all()
    ink[147:157, 97:203] = False
    assert ink.sum() <= 10


def test_dark_areas_are_solid_and_keep_white_letters():
    reflectance = page()
    reflectance[100:300, 50:250] = 0.04
    reflectance[200:203, 80:220] = 1.0
    ink = find_ink(photographed(reflectance))
    assert not ink[201, 82:218].any()
    ink[198:205] = True
    assert ink[103:297, 53:247].all()
    assert not ink[:97].any()


def test_the_trace_of_a_fold_and_a_dark_edge_of_the_page_are_paper():
    reflectance = page()
    reflectance[200] = 0.9
    reflectance[:, 0] = 0.8
    assert not find_ink(photographed(reflectance, noise=0.005)).any()


def test_bands_of_rows_do_not_show(monkeypatch):
    rng = np.random.default_rng(3)
    grey = photographed(1 - 0.9 * (ndimage.gaussian_filter(rng.normal(size=SHAPE), 2) > 0.15))
    whole = find_ink(grey)
    monkeypatch.setattr(black_and_white, "_ROWS", 64)
    np.testing.assert_array_equal(find_ink(grey), whole)


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (40, 2)])
@pytest.mark.parametrize("level", [0, 128, 255])
def test_tiny_pages(shape, level):
    assert find_ink(np.full(shape, level, np.uint8)).shape == shape
