from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from flat_scene import CORNERS, SIZE, distance_to, draw, model
from origami.core.errors import StepFailed
from origami.core.numeric.image import linear_light
from origami.core.numeric.polygon import inside_polygon, resample, signed_area
from origami.core.paper.contour import take_short_cuts, trace_mask
from origami.core.paper.followed_edge import ReducedPhoto
from origami.core.paper.outline import follow_all
from origami.core.paper.reference_outline import find_reference_outline
from origami.core.paper.sheet_search import FoundSheet
from origami.core.paper.smooth_contour import smooth_sides


def about(corners=CORNERS, off=0.03, probability=1.0):
    """The sheet of `flat_scene.draw` as a search finds it: its corners wrong by a part of its side, as in space."""
    camera = model().cameras[0]
    middle = corners.mean(axis=0)
    random = np.random.default_rng(1)
    side = np.linalg.norm(corners[1] - corners[0])
    roughly = middle + (1 - off) * (corners - middle) + off * side * random.uniform(-0.5, 0.5, corners.shape)
    rays = np.column_stack([camera.undistort(resample(roughly, 4.0)), np.ones(len(resample(roughly, 4.0)))])
    return FoundSheet(camera.to_world_frame(rays), np.ones(400, bool), probability, 0.0)


def find(photo, corners=CORNERS, **options):
    return find_reference_outline(model(), [photo], [], about(corners, **options), reference=0).outline


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
    outline = find(draw(paper=paper, desk=desk, texture=texture))
    true = resample(CORNERS, 1.0)
    assert np.sqrt((distance_to(outline.polygon, true) ** 2).mean()) < 0.5
    assert distance_to(CORNERS, outline.polygon).max() < 2.0
    assert outline.confidence > 0.9
    assert outline.notes == ()


def test_is_clockwise_and_holds_every_print():
    scene = model()
    outline = find(draw())
    assert signed_area(outline.polygon) > 0
    assert inside_polygon(scene.observed_pixel[scene.observed_camera == 0], outline.polygon).all()


def test_corners_are_kept_sharp():
    outline = find(draw())
    assert np.linalg.norm(outline.polygon[:, None] - CORNERS, axis=2).min(axis=0).max() < 1.5


@pytest.mark.parametrize("desk", [(222, 219, 211), (225, 222, 214)])
def test_a_desk_that_looks_like_paper_leaves_the_sheet_where_it_is_expected_with_a_note(desk):
    outline = find(draw(desk=desk))
    assert outline.confidence < 0.5
    assert any("hardly differs" in note for note in outline.notes)
    true, found = inside_polygon(_pixels(), CORNERS), inside_polygon(_pixels(), outline.polygon)
    assert (true & found).sum() > 0.85 * (true | found).sum()


def test_a_sheet_in_a_pocket_ends_at_its_own_edge():
    """The pocket looks more like the sheet than like the desk, but the sheet was found without it."""
    pocket = CORNERS.mean(axis=0) + 1.14 * (CORNERS - CORNERS.mean(axis=0))
    around = draw(pocket, paper=(175, 174, 170), desk=(30, 22, 15))
    inside = inside_polygon(_pixels(), CORNERS).reshape(SIZE)
    outline = find(np.where(inside[..., None], draw(), around), off=0.0)
    true, found = inside_polygon(_pixels(), CORNERS), inside_polygon(_pixels(), outline.polygon)
    assert (true & found).sum() > 0.98 * (true | found).sum()


def test_which_region_is_the_sheet_may_be_unsure_and_is_noted():
    outline = find(draw(), probability=0.3)
    assert outline.confidence < 0.5
    assert any("uncertain which part" in note for note in outline.notes)


@pytest.mark.parametrize("part", [0.55, 0.75])
def test_paper_that_goes_on_beyond_what_was_expected_is_found(part):
    """The search may miss the part beyond a steep fold: there the outline is no edge."""
    short = CORNERS.copy()
    short[2:] = CORNERS[[1, 0]] + part * (CORNERS[[2, 3]] - CORNERS[[1, 0]])
    outline = find(draw(texture=0.2), short, off=0.0)
    true, found = inside_polygon(_pixels(), CORNERS), inside_polygon(_pixels(), outline.polygon)
    assert (true & found).sum() > (0.98 if part > 0.6 else 0.5) * (true | found).sum()
    assert outline.notes == () or part < 0.6


def test_faint_edge_is_followed_but_lowers_confidence_with_a_note():
    outline = find(draw(desk=(217, 214, 206)))
    assert outline.confidence < 0.9
    assert any("hardly differs" in note for note in outline.notes)
    assert distance_to(outline.polygon, resample(CORNERS, 1.0)).max() < 2.0


def test_sheet_that_leaves_the_photo_is_noted():
    corners = CORNERS - np.array([90.0, 0.0])
    outline = find(draw(corners), corners)
    assert any("border of the photo" in note for note in outline.notes)
    assert (outline.polygon >= 0).all() and (outline.polygon <= SIZE[::-1]).all()


def _rectangle(left, top, right, bottom):
    return np.array([[left, top], [right, top + 1.3], [right - 1.2, bottom], [left, bottom - 0.7]])


def _pixels():
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    return np.stack([x.ravel(), y.ravel()], axis=1) + 0.5


FILLING = {
    "two": (_rectangle(-40.0, -40.0, 250.0, 400.0), True),
    "two sides and two corners": (_rectangle(-40.0, 70.0, 400.0, 400.0), True),
    "three": (_rectangle(-40.0, -40.0, 270.0, 520.0), True),
    "four": (_rectangle(-40.0, -40.0, 400.0, 520.0), True),
    "two, narrow margins": (_rectangle(-40.0, -40.0, 356.0, 476.0), True),
    "3 px": (_rectangle(3.0, 3.0, 357.0, 475.0), False),
    "5 px": (_rectangle(5.0, 5.0, 355.0, 473.0), False),
    "8 px": (_rectangle(8.0, 8.0, 352.0, 471.0), False),
}


@pytest.mark.parametrize(
    ("corners", "reaches_frame", "texture"),
    [
        pytest.param(*case, texture, id=f"{name}, {desk}", marks=() if in_turn % 2 == odd else pytest.mark.slow)
        for in_turn, (name, case) in enumerate(FILLING.items())
        for odd, (desk, texture) in enumerate({"plain": 0.0, "textured": 0.35}.items())
    ],
)
def test_sheet_that_fills_the_photo_is_kept_whole(corners, reaches_frame, texture):
    outline = find(draw(corners, texture=texture), corners)
    true, found = inside_polygon(_pixels(), corners), inside_polygon(_pixels(), outline.polygon)
    assert (true & found).sum() > 0.99 * true.sum()
    assert (found & ~true).sum() < 0.01 * true.sum()
    assert bool(outline.notes) == reaches_frame
    assert (outline.confidence < 0.5) == reaches_frame


def test_photo_that_hardly_shows_the_sheet_is_a_typed_failure():
    with pytest.raises(StepFailed, match="hardly shows the sheet"):
        find(draw(), CORNERS + np.array([600.0, 0.0]))


def test_rivals_are_followed_in_threads_as_they_are_one_by_one():
    camera, reduced = model().cameras[0], ReducedPhoto(linear_light(draw(texture=0.2)))
    wide = CORNERS + np.array([[-15, 0], [15, 0], [15, 0], [-15, 0]])
    narrow = CORNERS + np.array([[0, 90], [0, 90], [0, 0], [0, 0]])
    sheet = replace(about(), rivals=(about(wide), about(narrow)))
    one_by_one, signs = follow_all(reduced, camera, sheet)
    at_once, same = follow_all(reduced, camera, sheet, threads=3)
    assert signs == same
    assert len(at_once) == 3
    for one, other in zip(one_by_one, at_once, strict=True):
        np.testing.assert_array_equal(one.points, other.points)


def test_two_runs_agree():
    first, second = (find(draw()).polygon for _ in range(2))
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
