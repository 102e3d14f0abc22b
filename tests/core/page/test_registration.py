"""A displacement by a few pixels is found."""

from __future__ import annotations

import numpy as np
from origami.core.page.registration import displacement
from scipy import ndimage


def printed(seed=0, size=(300, 260)):
    rng = np.random.default_rng(seed)
    return ndimage.gaussian_filter((rng.random(size) > 0.9).astype(np.float32), 1.5) * 4


def moved_by(picture, x, y):
    rows, columns = np.indices(picture.shape)
    return ndimage.map_coordinates(picture, [rows - y, columns - x], order=3, mode="nearest").astype(np.float32)


def test_a_shift_is_found_in_spite_of_other_light():
    fixed = printed()
    shade = np.linspace(-0.5, 0.4, fixed.shape[1])[None]
    moving = 0.7 * moved_by(fixed, 1.8, -2.4) + shade.astype(np.float32)
    found = displacement(fixed, moving, np.ones(fixed.shape, bool), 8)
    np.testing.assert_allclose(found[30:-30, 30:-30].reshape(-1, 2).mean(axis=0), [1.8, -2.4], atol=0.1)
    assert found[30:-30, 30:-30].std(axis=(0, 1)).max() < 0.15


def test_a_changing_shift_is_followed():
    fixed = printed(1)
    x = 1.5 * np.sin(np.linspace(0, np.pi, fixed.shape[0]))[:, None] * np.ones(fixed.shape)
    found = displacement(fixed, moved_by(fixed, x, 0), np.ones(fixed.shape, bool), 8)
    assert np.abs(found[..., 0] - x)[30:-30, 30:-30].mean() < 0.2


def test_blank_paper_and_pictures_of_nothing_stay_in_place():
    blank = np.zeros((100, 100), np.float32)
    assert np.abs(displacement(blank, blank + 0.3, np.ones(blank.shape, bool), 8)).max() < 1e-3
    fixed = printed(2)
    nothing = np.zeros(fixed.shape, bool)
    assert not displacement(fixed, moved_by(fixed, 1, 1), nothing, 8).any()


def test_what_is_unknown_moves_with_the_print_around():
    fixed = printed(2)
    moving = moved_by(fixed, 1.5, -1)
    known = np.ones(fixed.shape, bool)
    known[120:180, 100:160] = False
    moving[~known] = 5
    found = displacement(fixed, moving, known, 8)
    np.testing.assert_allclose(found[~known], np.broadcast_to([1.5, -1], found[~known].shape), atol=0.2)
