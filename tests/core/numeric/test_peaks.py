"""Peaks between samples."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.peaks import peak_offset


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_parabola_has_its_peak_where_it_is(dtype):
    peak = np.linspace(-0.5, 0.5, 11)
    before, here, after = (dtype(7) - 3 * (at - peak.astype(dtype)) ** 2 for at in (-1, 0, 1))
    assert np.allclose(peak_offset(before, here, after), peak, atol=1e-5)


def test_a_valley_a_slope_and_a_plain_have_no_peak():
    before, here, after = np.array([[4.0, 1.0, 4.5], [1.0, 2.0, 3.0], [2.0, 2.0, 2.0]]).T
    assert np.array_equal(peak_offset(before, here, after), np.zeros(3))
