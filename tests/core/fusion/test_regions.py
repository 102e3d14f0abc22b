"""Regions of a page are few and large, and taken from photos that show them."""

from __future__ import annotations

import numpy as np
from origami.core.fusion.regions import choose_regions
from scipy import ndimage


def test_regions_are_few_and_large_in_spite_of_noise():
    rng = np.random.default_rng(0)
    score = rng.uniform(0.8, 1.2, (3, 96, 72)).astype(np.float32)
    score[0, :48] += 0.3
    score[1, 48:] += 0.3
    label = choose_regions(score, np.ones(score.shape, bool))
    assert sum(ndimage.label(label == photo)[1] for photo in range(3)) <= 3
    assert (label[:40] == 0).all()
    assert (label[56:] == 1).all()


def test_regions_never_take_a_photo_that_sees_nothing_there():
    score = np.ones((2, 60, 60), np.float32)
    score[0] = 5
    visible = np.ones(score.shape, bool)
    visible[0, 20:24, 20:24] = False
    visible[:, 50:, 50:] = False
    label = choose_regions(score, visible)
    assert (label[20:24, 20:24] == 1).all()
    assert (label[50:, 50:] == -1).all()
