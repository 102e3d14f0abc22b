from __future__ import annotations

import numpy as np
import pytest
from flat_scene import CORNERS, SIZE, distance_to, draw, model, sparse_model
from origami.core.contour import smooth_sides, take_short_cuts, trace_mask
from origami.core.errors import StepFailed
from origami.core.outline import find_outline
from origami.core.polygon import inside_polygon, resample, signed_area
from origami.core.reference_view import prominence
from origami.core.support_plane import height_above_desk


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


@pytest.mark.parametrize("desk", [(222, 219, 211), (225, 222, 214)])
def test_desk_that_cannot_be_told_from_the_paper_is_kept_and_told(desk):
    scene = model()
    outline = find_outline(draw(desk=desk), scene, 0)
    assert outline.confidence < 0.5
    assert any("whole photo" in note for note in outline.notes)
    assert inside_polygon(scene.observed_pixel[scene.observed_camera == 0], outline.polygon).all()


def test_faint_edge_is_followed_but_lowers_confidence_and_is_told():
    outline = find_outline(draw(desk=(217, 214, 206)), model(), 0)
    assert outline.confidence < 0.9
    assert any("hardly differs" in note for note in outline.notes)
    assert distance_to(outline.polygon, resample(CORNERS, 1.0)).max() < 2.0


def test_sheet_that_leaves_the_photo_is_told():
    corners = CORNERS - np.array([90.0, 0.0])
    outline = find_outline(draw(corners), model(corners), 0)
    assert any("border of the photo" in note for note in outline.notes)
    assert (outline.polygon >= 0).all() and (outline.polygon <= SIZE[::-1]).all()


def _rectangle(left, top, right, bottom):
    return np.array([[left, top], [right, top + 1.3], [right - 1.2, bottom], [left, bottom - 0.7]])


def _pixels():
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    return np.stack([x.ravel(), y.ravel()], axis=1) + 0.5


def _in_frame(corners):
    return np.clip(corners, 0, SIZE[::-1])


@pytest.mark.parametrize("texture", [0.0, 0.35], ids=["plain", "textured"])
@pytest.mark.parametrize(
    ("corners", "reaches_frame"),
    [
        (_rectangle(-40.0, -40.0, 250.0, 400.0), True),
        (_rectangle(-40.0, 70.0, 400.0, 400.0), True),
        (_rectangle(-40.0, -40.0, 270.0, 520.0), True),
        (_rectangle(-40.0, -40.0, 400.0, 520.0), True),
        (_rectangle(-40.0, -40.0, 356.0, 476.0), True),
        (_rectangle(3.0, 3.0, 357.0, 475.0), False),
        (_rectangle(5.0, 5.0, 355.0, 473.0), False),
        (_rectangle(8.0, 8.0, 352.0, 471.0), False),
    ],
    ids=["two", "two sides and two corners", "three", "four", "two, narrow margins", "3 px", "5 px", "8 px"],
)
def test_sheet_that_fills_the_photo_is_kept_whole(corners, reaches_frame, texture):
    outline = find_outline(draw(corners, texture=texture), model(_in_frame(corners)), 0)
    true, found = inside_polygon(_pixels(), corners), inside_polygon(_pixels(), outline.polygon)
    assert (true & found).sum() > 0.99 * true.sum()
    assert (found & ~true).sum() < 0.01 * true.sum()
    assert bool(outline.notes) == reaches_frame
    assert (outline.confidence < 0.5) == reaches_frame


def test_points_of_the_desk_around_a_raised_sheet_do_not_widen_the_outline():
    scene = model(desk_points=600)
    outline = find_outline(draw(texture=0.35), scene, 0)
    assert np.sqrt((distance_to(outline.polygon, resample(CORNERS, 1.0)) ** 2).mean()) < 0.5
    assert height_above_desk(scene, prominence(scene)) is not None


def test_facing_page_is_left_out_at_the_gutter():
    spread = _rectangle(30.0, 60.0, 420.0, 420.0)
    photo = draw(spread)
    photo[60:421, 249:252] //= 3
    random = np.random.default_rng(0)
    pixels = random.uniform([40.0, 70.0], [415.0, 410.0], (1200, 2))
    # both pages go down into the gutter at x = 250
    depth = 1 + 0.1 * np.exp(-np.abs(pixels[:, 0] - 250) / 40)
    points = np.column_stack([(pixels - [180.0, 240.0]) / 528.0 * depth[:, None], depth])
    centres = [[0.004 * i, 0.004 * i, 0.0] for i in range(5)] + [[0.15, 0.01 * i, 0.0] for i in range(3)]
    outline = find_outline(photo, sparse_model(points, centres, 528.0, SIZE), 0)
    page = np.array([[30.0, 60.0], [250.0, 60.7], [250.0, 419.7], [30.0, 419.3]])
    true, found = inside_polygon(_pixels(), page), inside_polygon(_pixels(), outline.polygon)
    assert (true & found).sum() > 0.98 * true.sum()
    assert (found & ~true).sum() < 0.02 * true.sum()
    assert any("facing page" in note for note in outline.notes)


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
