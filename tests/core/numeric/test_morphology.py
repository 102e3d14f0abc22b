from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.morphology import dilated, eroded, fill_holes
from scipy import ndimage


@pytest.mark.parametrize("radius", [0, 1, 2.5, 7, 60.3, 200])
def test_dilation_and_erosion_are_by_euclidean_distance(radius):
    mask = np.zeros((60, 90), bool)
    mask[20:, 30:70] = True
    mask ^= np.random.default_rng(0).random(mask.shape) < 0.01
    np.testing.assert_array_equal(dilated(mask, radius), ndimage.distance_transform_edt(~mask) <= radius)
    np.testing.assert_array_equal(eroded(mask, radius), ndimage.distance_transform_edt(mask) > radius)


def test_nothing_and_everything_stay_what_they_are():
    nothing = np.zeros((5, 8), bool)
    assert not dilated(nothing, 3).any()
    assert eroded(~nothing, 3).all()


def test_a_bay_at_the_frame_is_not_a_hole():
    ring = np.ones((7, 7), bool)
    ring[2:5, 2:5] = False
    ring[0, 0] = False
    filled = fill_holes(ring)
    assert not filled[0, 0]
    assert filled.sum() == 48
