from __future__ import annotations

from dataclasses import replace

import numpy as np
from flat_scene import CORNERS, model, without
from origami.core.numeric.polygon import resample
from origami.core.paper.outline import Outline
from origami.core.paper.sheet_points import points_on_sheet

OUTLINE = Outline(resample(CORNERS, 3.0), 1.0, ())


def test_desk_beside_and_under_the_sheet_stays_out():
    scene = model(count=400, desk_points=600, bend=0.3)
    found = points_on_sheet(scene, 0, OUTLINE)
    assert not found[400:].any()
    assert found[:400].mean() > 0.95


def test_points_not_seen_in_the_reference_join_if_they_lie_on_the_surface():
    scene = model(count=400, desk_points=0, bend=0.3)
    lost = (scene.observed_camera == 0) & (scene.observed_point < 60)
    assert points_on_sheet(without(scene, lost), 0, OUTLINE)[:60].mean() > 0.8


def test_two_views_are_not_enough():
    scene = model()
    lost = (scene.observed_point == 5) & (scene.observed_camera >= 2)
    found = points_on_sheet(without(scene, lost), 0, OUTLINE)
    assert not found[5]
    assert np.delete(found, 5).mean() > 0.95


def test_print_that_repeats_leaves_the_reference_few_points_and_the_others_are_in_one_plane():
    scene = model(count=400, desk_points=100)
    jitter = np.random.default_rng(1).normal(scale=0.001, size=scene.points.shape)
    scene = replace(scene, points=scene.points + jitter)
    lost = (scene.observed_camera == 0) & (scene.observed_point >= 5) & (scene.observed_point < 400)
    known = without(scene, lost)
    found = points_on_sheet(known, 0, OUTLINE)
    assert not found[400:].any()
    assert found[:400][known.views_per_point()[:400] >= 3].mean() > 0.95


def test_a_handful_of_points_says_nothing_about_a_plane():
    scene = model(count=8)
    unseen = without(scene, scene.observed_camera == 0)
    assert not points_on_sheet(unseen, 0, OUTLINE).any()
