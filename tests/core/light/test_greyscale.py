"""Grey is the light of the colours, added up."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.light.greyscale import greyscale
from origami.core.numeric.image import linear_light

SHARES = (0.2126, 0.7152, 0.0722)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_neutral_levels_stay(dtype):
    levels = np.linspace(0, np.iinfo(dtype).max, 256).astype(dtype).reshape(16, 16)
    grey = greyscale(levels[..., None].repeat(3, axis=2), SHARES)
    assert grey.dtype == dtype
    assert np.abs(grey.astype(int) - levels).max() <= (0 if dtype == np.uint8 else 2)


def test_light_adds_up():
    colors = np.random.default_rng(0).integers(0, 256, (600, 9, 3), dtype=np.uint8)
    expected = linear_light(colors) @ np.array(SHARES, np.float32)
    np.testing.assert_allclose(linear_light(greyscale(colors, SHARES))[..., 0], expected, atol=0.005)
