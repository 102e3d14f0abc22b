from __future__ import annotations

import numpy as np
import pytest
from flat_scene import CORNERS, SIZE, distance_to, draw, model
from origami.core.contour import smooth_sides, take_short_cuts, trace_mask
from origami.core.errors import StepFailed
from origami.core.outline import find_outline
from origami.core.polygon import inside_polygon, resample, signed_area


@pytest.mark.parametrize(
    ("paper", "desk", "texture"),
    [
        ((225, 222, 214), (120, 85, 60), 0.0),
        ((225, 222, 214), (120, 85, 60), 0.35),
        ((225, 222, 214), (2, 2, 2), 0.0),
        ((190, 60, 50), (150, 150, 150), 0.2),
        ((225, 222, 214), (180, 182, 185), 0.05),
    ],
)
def test_follows_the_true_edge_on_any_desk(paper, desk, texture):
    outline = find_outline(draw(paper=paper, desk=desk, texture=texture), model(), 0)
    true = resample(CORNERS, 1.0)
    assert np.sqrt((distance_to(outline.polygon, true) ** 2).mean()) < 0.5
    assert distance_to(CORNERS, outline.polygon).max() < 2.0
    assert outline.confidence > 0.9
    assert outline.notes == ()


def test_is_clockwise_and_holds_every_print():
    scene = model()
    outline = find_outline(draw(), scene, 0)
    assert signed_area(outline.polygon) > 0
    assert inside_polygon(scene.observed_pixel[scene.observed_camera == 0], outline.polygon).all()


def test_corners_are_kept_sharp():
    outline = find_outline(draw(), model(), 0)
    assert np.linalg.norm(outline.polygon[:, None] - CORNERS, axis=2).min(axis=0).max() < 1.5


def test_faint_edge_lowers_confidence_and_is_told():
    outline = find_outline(draw(desk=(222, 219, 211)), model(), 0)
    assert outline.confidence < 0.9
    assert any("hardly differs" in note for note in outline.notes)
    scene = model()
    assert inside_polygon(scene.observed_pixel[scene.observed_camera == 0], outline.polygon).mean() > 0.98


def test_sheet_that_leaves_the_photo_is_told():
    corners = CORNERS - np.array([90.0, 0.0])
    outline = find_outline(draw(corners), model(corners), 0)
    assert any("border of the photo" in note for note in outline.notes)
    assert (outline.polygon >= 0).all() and (outline.polygon <= SIZE[::-1]).all()


def test_too_few_points_is_a_typed_failure():
    with pytest.raises(StepFailed, match="outline by hand"):
        find_outline(draw(), model(count=10), 0)


def test_two_runs_agree():
    first, second = (find_outline(draw(), model(), 0).polygon for _ in range(2))
    assert np.array_equal(first, second)


def test_trace_mask_goes_round_the_outside():
    mask = np.zeros((6, 8), bool)
    mask[1:4, 2:7] = True
    mask[2, 4] = False
    border = trace_mask(mask)
    assert signed_area(border) == 15
    assert border.min(axis=0).tolist() == [2, 1] and border.max(axis=0).tolist() == [7, 4]


def test_smooth_sides_removes_noise_and_keeps_the_corner():
    random = np.random.default_rng(0)
    square = np.array([[0.0, 0.0], [200.0, 0.0], [200.0, 200.0], [0.0, 200.0]])
    points = resample(square, 2.0)
    smooth = smooth_sides(points + random.normal(scale=0.3, size=points.shape), np.ones(len(points)), 20)
    assert np.sqrt((distance_to(square, smooth) ** 2).mean()) < 0.2
    assert np.linalg.norm(smooth[:, None] - square, axis=2).min(axis=0).max() < 1.0


@pytest.mark.parametrize("depth", [14.0, -14.0])
def test_short_cut_takes_out_a_bump_or_notch_where_the_edge_runs_on(depth):
    square = np.array([[40.0, 40.0], [240.0, 40.0], [240.0, 240.0], [40.0, 240.0]])
    patch = np.array([[130.0, 40.0], [130.0, 40.0 - depth], [150.0, 40.0 - depth], [150.0, 40.0]])
    gradient = np.zeros((280, 280), np.float32)
    gradient[39:41, 40:240] = gradient[239:241, 40:240] = 5
    gradient[40:240, 39:41] = gradient[40:240, 239:241] = 5
    with_detour = resample(np.vstack([square[:1], patch, square[1:]]), 1.0)
    assert distance_to(square, take_short_cuts(with_detour, gradient)).max() < 1.5
    kept = take_short_cuts(with_detour, np.zeros_like(gradient))
    assert distance_to(square, kept).max() > abs(depth) - 1
    assert np.linalg.norm(kept[:, None] - square, axis=2).min(axis=0).max() < 1.0
