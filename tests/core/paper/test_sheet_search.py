from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from origami.core.errors import StepFailed
from origami.core.numeric.polygon import filled_polygon, smallest_rectangle
from origami.core.paper.orthophoto import orthophoto
from origami.core.paper.other_sheets import other_sheets
from origami.core.paper.reference_outline import find_reference_outline
from origami.core.paper.sheet_evidence import Surroundings
from origami.core.paper.sheet_hypotheses import COARSE, Hypothesis, rectangles, sheet_hypotheses
from origami.core.paper.sheet_search import find_sheets
from origami.core.paper.sides_search import polished_quadrilateral
from table_scene import flat_sheet, folded_sheet, letter_found, letter_on_wood, page, plain, table_scene, wood

BROWN, WHITE = (120, 85, 60), (226, 224, 218)


def overlap(scene, index=2):
    return overlap_of(find_sheets(scene.model, scene.reduced)[0], scene, index)


def overlap_of(sheet, scene, index=2):
    outline = find_reference_outline(scene.model, scene.photos, [], sheet, reference=index).outline
    return scene.overlap(index, outline.polygon), outline


@pytest.mark.parametrize(
    ("sheet", "table", "table_points"),
    [
        pytest.param(
            *(flat_sheet(turn=-31.0, scale=0.8), wood(11, (70, 50, 40)), 900),
            id="smaller on dark wood",
            marks=pytest.mark.slow,
        ),
        pytest.param(flat_sheet(), plain(BROWN), 0, id="flat on a plain table"),
        pytest.param(folded_sheet(40.0), wood(), 600, id="folded on wood"),
        pytest.param(
            *(folded_sheet(25.0), plain((60, 90, 60)), 0), id="folded on a plain table", marks=pytest.mark.slow
        ),
    ],
)
def test_the_sheet_and_only_it_is_found_on_any_table(sheet, table, table_points):
    share, outline = overlap(table_scene([(sheet, page())], table, table_points))
    assert share > 0.985
    assert outline.notes == ()


def test_the_sheet_and_only_it_is_found_on_wood():
    share, outline = overlap_of(letter_found()[0], letter_on_wood())
    assert share > 0.985
    assert outline.notes == ()


def test_a_sheet_with_hardly_any_print_is_found_among_the_tables_points():
    share, outline = overlap(table_scene([(flat_sheet(), page(0.15))], wood(), table_points=900, sheet_points=60))
    assert share > 0.985
    assert outline.notes == ()


def test_dark_paper_on_a_light_table_is_found():
    share, _ = overlap(table_scene([(flat_sheet(), 255 - page())], wood(color=(200, 180, 150))))
    assert share > 0.98


def test_white_on_white_is_right_or_reported():
    share, outline = overlap(table_scene([(flat_sheet(), page(0.3))], plain(WHITE), table_points=0))
    assert share > 0.98 or outline.notes


def test_two_sheets_are_both_found_the_one_in_the_middle_first():
    first, second = flat_sheet((-0.2, 0.0), 5.0, 0.6), flat_sheet((0.5, 0.1), -20.0, 0.5)
    scene = table_scene([(first, page(0.5)), (second, page(0.5, seed=4))], wood())
    sheets = find_sheets(scene.model, scene.reduced)
    assert len(sheets) == 2
    middle = [sheet.outline.mean(axis=0)[:2] for sheet in sheets]
    assert np.allclose(middle[0], [-0.2, 0.0], atol=0.05)
    assert np.allclose(middle[1], [0.5, 0.1], atol=0.05)


def test_points_within_the_outline_are_the_sheets():
    scene, sheet = letter_on_wood(), letter_found()[0]
    on_sheet = scene.model.points[:, 2] > 0.001
    assert (sheet.points == on_sheet).mean() > 0.98
    assert 0.5 < sheet.probability <= 1


def test_two_runs_agree_to_the_bit():
    scene = letter_on_wood()
    again = find_sheets(scene.model, scene.reduced)[0]
    assert np.array_equal(letter_found()[0].outline, again.outline)


def test_hardly_any_points_is_a_typed_failure():
    scene = letter_on_wood()
    with pytest.raises(StepFailed, match="too few to find a sheet"):
        find_sheets(scene.model.select(np.arange(len(scene.model.points)) < 10), scene.reduced)


def test_photos_without_any_edge_are_a_typed_failure():
    scene = letter_on_wood()
    with pytest.raises(StepFailed, match="outline by hand"):
        find_sheets(scene.model, [np.full_like(photo, 0.5) for photo in scene.reduced])


@pytest.fixture(scope="module")
def letter():
    scene = table_scene([(flat_sheet(), page(0.5))], wood())
    ortho = orthophoto(scene.model, scene.reduced)
    corner, right, down, _ = flat_sheet()[0]
    corners = ortho.from_world(np.array([corner, corner + right, corner + right + down, corner + down]))
    return scene, ortho, corners


def test_the_sheets_rectangle_is_among_the_hypotheses(letter):
    _, ortho, corners = letter
    found = sheet_hypotheses(ortho, 450.0)
    true = filled_polygon(corners / COARSE, found[0].mask.shape)
    best = max((each.mask & true).sum() / (each.mask | true).sum() for each in found)
    assert best > 0.95


def test_a_drawn_rectangle_is_the_first_that_is_found():
    color = np.zeros((160, 200, 3), np.float32)
    color += np.random.default_rng(0).normal(scale=2.0, size=color.shape)
    corners = np.array([[50.0, 40.0], [150.0, 60.0], [134.0, 140.0], [34.0, 120.0]])
    color[filled_polygon(corners, color.shape)] += (30, 0, 0)
    found = rectangles(color, np.ones((160, 200), bool))[0]
    assert min(np.abs(np.roll(found, k, axis=0) - corners).max() for k in range(4)) < 3.0


def test_the_true_outline_has_more_evidence_than_its_print_its_half_or_the_table_around_it(letter):
    scene, ortho, corners = letter
    surroundings = Surroundings(ortho, scene.model)
    middle = corners.mean(axis=0)
    shape = sheet_hypotheses(ortho, 450.0)[0].mask.shape

    def score(polygon):
        evidence = surroundings.evidence(Hypothesis(polygon, filled_polygon(polygon / COARSE, shape)))
        return evidence.score()

    half = np.array([corners[0], corners[1], corners[[1, 2]].mean(axis=0), corners[[0, 3]].mean(axis=0)])
    true = score(corners)
    for other in (middle + 0.8 * (corners - middle), middle + 1.4 * (corners - middle), half, corners + 25.0):
        assert score(other) < true - 1


def test_a_side_across_a_grained_table_has_places_without_a_step(letter):
    scene, ortho, corners = letter
    surroundings = Surroundings(ortho, scene.model)
    shape = sheet_hypotheses(ortho, 450.0)[0].mask.shape
    further = corners.copy()
    further[1:3] += 0.5 * (corners[1] - corners[0])

    def figures(polygon):
        evidence = surroundings.evidence(Hypothesis(polygon, filled_polygon(polygon / COARSE, shape)))
        return evidence.side_without_step, evidence.without_step

    right, right_mean = figures(corners)
    wrong, wrong_mean = figures(further)
    assert right < 0.1
    assert wrong > right + 0.2
    assert wrong_mean > right_mean + 0.05


def test_a_block_of_print_has_print_at_its_edge_and_paper_beyond(letter):
    scene, ortho, corners = letter
    surroundings = Surroundings(ortho, scene.model)
    shape = sheet_hypotheses(ortho, 450.0)[0].mask.shape
    middle = corners.mean(axis=0)
    figure = [
        surroundings.evidence(Hypothesis(polygon, filled_polygon(polygon / COARSE, shape))).print_at_edge
        for polygon in (corners, middle + 0.76 * (corners - middle))
    ]
    assert figure[0] < 0.02
    assert figure[1] > 0.25


def test_a_rough_quadrilateral_is_moved_onto_the_edges(letter):
    scene, ortho, corners = letter
    rough = corners + np.array([[6.0, -4.0], [-5.0, 5.0], [4.0, 6.0], [-6.0, -3.0]])
    polished = polished_quadrilateral(Surroundings(ortho, scene.model).color, rough)
    off = np.linalg.norm(polished - corners, axis=1)
    assert np.median(off) < 2
    assert off.max() < 3


def test_the_smallest_rectangle_around_a_turned_one_is_itself():
    angle = np.radians(24)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    corners = np.array([[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0]]) @ turn + [40.0, 50.0]
    found = smallest_rectangle(corners)
    assert min(np.abs(np.roll(found, k, axis=0) - corners).max() for k in range(4)) < 1e-9


def test_the_end_of_a_sheet_that_rises_without_points_is_found():
    sheet = folded_sheet(60.0)
    scene = table_scene([(sheet, page())], wood())
    # no point of its highest third
    high = scene.model.points[:, 2] > 0.66 * scene.model.points[:, 2].max()
    scene = replace(scene, model=scene.model.select(~high))
    found = find_sheets(scene.model, scene.reduced)[0]
    assert overlap_of(found, scene)[0] > 0.98


def test_hypotheses_that_agree_say_how_exact_the_outline_is():
    clear = letter_found()[0]
    assert 0.5 < clear.agreement <= 1
    assert clear.agreement <= clear.probability + 1e-9


def test_other_regions_come_one_after_the_other_and_none_twice():
    scene, sheet = letter_on_wood(), letter_found()[0]
    first, second = other_sheets(scene.model, scene.reduced, [sheet.outline], 2)
    assert first.probability >= second.probability > 0
    camera = scene.model.cameras[2]
    shares = [scene.overlap(2, camera.project(each.outline)) for each in (sheet, first, second)]
    assert shares[0] > 0.95
    assert max(shares[1:]) < 0.75
    (again,) = other_sheets(scene.model, scene.reduced, [sheet.outline, first.outline], 1)
    np.testing.assert_allclose(again.outline, second.outline)
