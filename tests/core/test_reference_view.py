from __future__ import annotations

import numpy as np
import pytest
from flat_scene import draw, model
from origami.core.errors import UnusablePhotos
from origami.core.reference_view import choose_reference, prominence, rank_references
from scipy import ndimage


def test_the_sharp_photo_wins_over_blurred_ones():
    sharp = draw()
    blurred = np.round(ndimage.gaussian_filter(sharp.astype(float), (2.5, 2.5, 0))).astype(np.uint8)
    scene = model()
    assert choose_reference(scene, [blurred, sharp, blurred, blurred]) == 1


def test_the_photo_that_cuts_the_sheet_off_comes_last():
    scene = model()
    photos = [draw()] * 4
    ranked = rank_references(scene, photos)
    assert sorted(ranked.tolist()) == [0, 1, 2, 3]
    # the cameras move to the right, and the sheet out of the picture
    assert ranked[-1] == 3


def test_prominence_is_highest_in_the_middle_and_nothing_for_two_views():
    scene = model(desk_points=300)
    weight = prominence(scene)
    assert (weight[scene.views_per_point() < 3] == 0).all()
    assert weight[:400].mean() > weight[400:].mean()


def test_hardly_any_points_is_a_typed_failure():
    with pytest.raises(UnusablePhotos):
        rank_references(model(count=10), [draw()] * 4)


def test_photos_and_cameras_must_match():
    with pytest.raises(ValueError, match="cameras"):
        rank_references(model(), [draw()])
