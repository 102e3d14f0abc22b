from __future__ import annotations

import numpy as np
from flat_scene import sparse_model
from origami.core.gutter import facing_page
from origami.core.reference_view import prominence


def _valley(x):
    return -0.25 * np.exp(-np.abs(x) / 0.2)


def _book(frame_ends_at=0.3, profile=_valley, seed=0):
    """A page left of a gutter at x = 0 and a part of the next, of which most photos see what lies before an x.

    Both pages go down into the gutter, or as ``profile`` says. Returns the model and the points' distance from it.
    """
    random = np.random.default_rng(seed)
    plane = random.uniform([-1.2, -0.8], [0.6, 0.8], (900, 2))
    # 600 px at 3 units' distance: half a photo is 0.9 units wide
    centres = [[frame_ends_at - 0.9 - 0.01 * i, 0.0, 0.0] for i in range(4)] + [[-0.2, 0.02 * i, 0.0] for i in range(3)]
    return sparse_model(np.column_stack([plane, 3 - profile(plane[:, 0])]), centres, 1000.0, (600, 600)), plane[:, 0]


def test_what_lies_beyond_a_valley_and_out_of_the_photos_is_the_facing_page():
    model, x = _book()
    facing = facing_page(model, prominence(model))
    seen = model.views_per_point() >= 3
    assert facing[seen & (x > 0.06)].all()
    assert not facing[x < -0.06].any()
    assert not facing[~seen].any()


def test_a_fold_of_a_sheet_that_the_photos_show_whole_is_none():
    model, _ = _book(frame_ends_at=0.7)
    assert not facing_page(model, np.ones(len(model.points))).any()


def test_neither_is_a_ridge_nor_a_plane():
    for profile in (lambda x: -0.3 * np.abs(x), np.zeros_like):
        model, _ = _book(profile=profile)
        assert not facing_page(model, prominence(model)).any()


def test_points_without_prominence_are_left_out():
    model, x = _book()
    weight = np.where(x > 0, 0.0, prominence(model))
    assert not facing_page(model, weight).any()
    few = np.where(np.arange(len(x)) < 20, 1.0, 0.0)
    assert not facing_page(model, few).any()
