from __future__ import annotations

import numpy as np
import pytest
from origami.core.paper.ground_frame import GroundFrame
from origami.core.paper.plane_sweep import in_company, swept_samples
from table_scene import flat_sheet, folded_sheet, letter_on_wood, page, plain, table_scene

CELL = 0.01
SHAPE = (300, 300)
CORNER = np.array([-1.5, -1.5])
# Right, down and up of the drawn table, whose plane is z = 0.
FRAME = GroundFrame(np.zeros(3), np.array([[1.0, 0, 0], [0, -1.0, 0], [0, 0, 1.0]]), 1.0)


def swept(scene, photos=None):
    return swept_samples(scene.model.cameras, photos or scene.reduced, FRAME, CORNER, CELL, SHAPE, 60)


def test_a_grained_table_and_a_sheet_on_it_lie_at_their_height():
    samples = swept(letter_on_wood())
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
    scene = letter_on_wood()
    assert swept(scene, [np.full_like(photo, level) for photo in scene.reduced]).shape == (0, 3)


def test_two_photos_are_too_few_to_agree():
    scene = letter_on_wood()
    few = swept_samples(scene.model.cameras[:2], scene.reduced[:2], FRAME, CORNER, CELL, SHAPE, 60)
    assert len(few) == 0


def test_what_only_one_photo_has_gives_hardly_any_samples():
    scene = table_scene([(flat_sheet(), page())], plain((120, 85, 60)), count=8)
    before = len(swept(scene))
    scene.photos[2][:200, :200] = (220, 170, 150)
    assert len(swept(scene)) < 1.1 * before


def test_places_count_where_enough_others_lie_beside_them_at_their_level():
    clear = np.zeros((30, 30), bool)
    level = np.full(clear.shape, 5)
    clear[2:10, 2:10] = True  # a surface that rises
    level[2:10] += np.arange(8)[:, None] // 2
    clear[15:20, 15:20] = True  # one square, as a reflection gives it
    clear[20:28, 2:10] = True  # many places, at levels that have nothing in common
    level[20:28, 2:10] = np.random.default_rng(0).permutation(64).reshape(8, 8) + 10
    kept = in_company(clear, level, 80)
    assert kept[2:10, 2:10].all()
    assert kept.sum() == 64
