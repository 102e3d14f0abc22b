from __future__ import annotations

import numpy as np
import pytest
from origami.core.paper.orthophoto import orthophoto
from table_scene import flat_sheet, folded_sheet, letter_on_wood, page, plain, table_scene, wood


@pytest.fixture(scope="module")
def flat():
    scene = letter_on_wood()
    return scene, orthophoto(scene.model, scene.reduced)


def test_the_frame_lies_in_the_table_with_up_towards_the_cameras(flat):
    _, ortho = flat
    assert np.allclose(ortho.frame.axes @ ortho.frame.axes.T, np.eye(3), atol=1e-9)
    assert ortho.frame.axes[2] @ [0, 0, 1] > np.cos(np.radians(0.5))
    assert np.linalg.det(np.array([ortho.frame.axes[0], -ortho.frame.axes[1], ortho.frame.axes[2]])) > 0


def test_positions_go_to_the_world_and_back(flat):
    _, ortho = flat
    positions = np.random.default_rng(0).uniform(20, 300, (50, 2))
    assert np.allclose(ortho.from_world(ortho.to_world(positions)), positions, atol=1e-6)


def test_a_flat_sheet_shows_in_its_true_proportions_whatever_the_photos_angles(flat):
    _, ortho = flat
    corner, right, down, _ = flat_sheet()[0]
    corners = ortho.from_world(np.array([corner, corner + right, corner + down]))
    sides = np.linalg.norm(corners[1:] - corners[0], axis=1)
    assert sides[1] / sides[0] == pytest.approx(np.linalg.norm(down) / np.linalg.norm(right), rel=2e-3)


def test_paper_and_table_have_their_colours_and_the_photos_agree_on_them(flat):
    scene, ortho = flat
    corner, right, down, _ = flat_sheet()[0]
    margin = ortho.from_world(corner + 0.03 * right + 0.5 * down)
    column, row = np.floor(margin).astype(int)
    assert ortho.color[row, column, 0] > 85
    assert ortho.disagreement[row, column] < 2
    assert ortho.coverage[row, column] == len(scene.photos)
    assert not ortho.known[ortho.coverage < 2].any()


def test_what_only_one_photo_has_is_not_in_the_map():
    scene = table_scene([(flat_sheet(), page())], plain((120, 85, 60)), table_points=300, count=7)
    clean = orthophoto(scene.model, scene.reduced)
    scene.photos[2][:200, :200] = (220, 170, 150)
    change = np.abs(orthophoto(scene.model, scene.reduced).color - clean.color)[clean.coverage == 7]
    assert (change > 3).mean() < 0.01


def test_the_height_of_a_fold_is_found_and_that_of_the_sheet_goes_on_beyond_its_print():
    sheet = folded_sheet(40.0)
    scene = table_scene([(sheet, page())], wood())
    ortho = orthophoto(scene.model, scene.reduced)
    corner, right, down, _ = sheet[0]
    ridge = corner + 0.5 * right + down
    height = ortho.frame.from_world(ortho.to_world(ortho.from_world(ridge)))[2]
    true = ortho.frame.from_world(ridge)[2]
    assert height == pytest.approx(true, abs=0.25 * ridge[2])
    outline = np.concatenate(
        [corner + np.outer([0, 0.5, 1], right), sheet[-1][0] + sheet[-1][2] + np.outer([1, 0.5, 0], right)]
    )
    alone = ortho.on_sheet(ortho.from_world(outline))
    edge = corner + 0.03 * right + 0.6 * down
    lifted = alone.to_world(alone.from_world(edge))
    assert np.linalg.norm(lifted - edge) < np.linalg.norm(ortho.to_world(ortho.from_world(edge)) - edge)


def test_a_raised_end_without_any_points_is_sharp():
    sheet = folded_sheet(50.0)
    scene = table_scene([(sheet, page(0.3))], wood())
    without = scene.model.select(scene.model.points[:, 2] < 0.3 * scene.model.points[:, 2].max())
    ortho = orthophoto(without, scene.reduced)
    corner, right, down, _ = sheet[0]
    side = corner + 0.01 * right + np.linspace(0.3, 0.9, 50)[:, None] * down
    off = ortho.frame.from_world(ortho.to_world(ortho.from_world(side)))[:, 2] - ortho.frame.from_world(side)[:, 2]
    assert np.median(np.abs(off)) < 3 * ortho.cell
    assert side[:, 2].max() > 25 * ortho.cell
    column, row = np.floor(ortho.from_world(side)).astype(int).T
    assert np.median(ortho.disagreement[row, column]) < 6
