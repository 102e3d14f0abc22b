from __future__ import annotations

import numpy as np
import pytest
from flat_scene import CORNERS, draw, model, sparse_model, without
from origami.core.numeric.image import reduced
from origami.core.numeric.polygon import resample
from origami.core.paper.reference_view import prominence, rank_references
from scipy import ndimage


def ranked(scene, photos, on_sheet=None):
    camera = scene.cameras[0]
    edge = resample(CORNERS, 5.0)
    outline = camera.to_world_frame(np.column_stack([camera.undistort(edge), np.ones(len(edge))]))
    on_sheet = np.ones(len(scene.points), bool) if on_sheet is None else on_sheet
    return rank_references(scene, [reduced(photo) for photo in photos], outline, on_sheet).tolist()


def test_the_sharp_photo_wins_over_blurred_ones():
    sharp = draw()
    blurred = np.round(ndimage.gaussian_filter(sharp.astype(float), (2.5, 2.5, 0))).astype(np.uint8)
    assert ranked(model(), [blurred, sharp, blurred, blurred])[0] == 1


def test_the_photo_that_cuts_the_sheet_off_comes_last():
    order = ranked(model(), [draw()] * 4)
    assert sorted(order) == [0, 1, 2, 3]
    # the cameras move to the right, and the sheet out of the picture
    assert order[-1] == 3


def test_a_photo_in_which_a_fold_hides_half_of_the_sheet_is_not_chosen():
    scene = model()
    hidden = (scene.observed_camera == 0) & (scene.observed_point % 2 == 0)
    assert ranked(without(scene, hidden), [draw()] * 4)[0] != 0


def test_points_of_the_table_do_not_count():
    scene = model(desk_points=600)
    on_sheet = np.arange(len(scene.points)) < 400
    best = ranked(scene, [draw()] * 4, on_sheet)[0]
    bare = without(scene, (scene.observed_camera == best) & ~on_sheet[scene.observed_point])
    assert ranked(bare, [draw()] * 4, on_sheet)[0] == best
    assert ranked(bare, [draw()] * 4)[0] != best  # where they do count, the photo hides more than half


def test_prominence_is_highest_in_the_middle_and_nothing_for_two_views():
    # four cameras in one place see the middle, twice a place a quarter of the width beside it, and the middle again
    focal_length, size = 400.0, (300, 400)
    beside = 0.25 * size[1] / focal_length
    points = [[0, 0, 1], [beside, 0, 1], [beside, 0, 1], [0, 0, 1]]
    scene = sparse_model(points, [[0.0, 0.0, 0.0]] * 4, focal_length, size, [False, False, True, False])
    scene = without(scene, (scene.observed_point == 3) & (scene.observed_camera > 1))
    assert scene.views_per_point().tolist() == [4, 4, 3, 2]
    np.testing.assert_allclose(prominence(scene), [1, np.exp(-0.5), 0.75 * np.exp(-0.5), 0])


def test_photos_and_cameras_must_match():
    with pytest.raises(ValueError, match="cameras"):
        ranked(model(), [draw()])
