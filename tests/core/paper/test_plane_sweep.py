from __future__ import annotations

import numpy as np
import pytest
from origami.core.paper.ground_frame import GroundFrame
from origami.core.paper.plane_sweep import swept_samples
from table_scene import flat_sheet, folded_sheet, page, plain, table_scene, wood

CELL = 0.01
SHAPE = (300, 300)
CORNER = np.array([-1.5, -1.5])
# Right, down and up of the drawn table, whose plane is z = 0.
FRAME = GroundFrame(np.zeros(3), np.array([[1.0, 0, 0], [0, -1.0, 0], [0, 0, 1.0]]), 1.0)


def swept(scene, photos=None):
    return swept_samples(scene.model.cameras, photos or scene.reduced, FRAME, CORNER, CELL, SHAPE, 60)


def test_a_grained_table_and_a_sheet_on_it_lie_at_their_height():
    samples = swept(table_scene([(flat_sheet(), page())], wood()))
    height = np.abs(samples[np.abs(samples[:, :2]).max(axis=1) < 0.6, 2])
    assert len(height) > 300
    assert np.median(height) < CELL
    assert np.quantile(height, 0.9) < 3 * CELL


@pytest.mark.parametrize("count", [5, 8])
def test_the_edges_of_a_blank_folded_sheet_lie_at_their_heights(count):
    sheet = folded_sheet(50.0)
    samples = swept(table_scene([(sheet, page(0.0))], plain((120, 85, 60)), count=count))
    corner, right, down, _ = sheet[0]
    assert (corner + down)[2] > 20 * CELL
    for side in (0.0, 1.0):
        true = corner + side * right + np.linspace(0.15, 0.85, 40)[:, None] * down
        away = np.linalg.norm(samples[:, None, :2] * [1, -1] - true[None, :, :2], axis=2)
        near, at = np.nonzero(away < 3 * CELL)
        assert len(set(at)) >= 20
        assert np.median(np.abs(samples[near, 2] - true[at, 2])) < 1.5 * CELL


@pytest.mark.parametrize("level", [0.0, 0.5])
def test_photos_that_show_nothing_give_no_samples(level):
    scene = table_scene([(flat_sheet(), page())], wood())
    assert swept(scene, [np.full_like(photo, level) for photo in scene.reduced]).shape == (0, 3)


def test_two_photos_are_too_few_to_agree():
    scene = table_scene([(flat_sheet(), page())], wood())
    few = swept_samples(scene.model.cameras[:2], scene.reduced[:2], FRAME, CORNER, CELL, SHAPE, 60)
    assert len(few) == 0


def test_what_only_one_photo_has_gives_hardly_any_samples():
    scene = table_scene([(flat_sheet(), page())], plain((120, 85, 60)), count=8)
    before = len(swept(scene))
    scene.photos[2][:200, :200] = (220, 170, 150)
    assert len(swept(scene)) < 1.1 * before
