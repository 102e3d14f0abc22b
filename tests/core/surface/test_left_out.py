"""Left-out patches show how stiff a sheet is, and which folds are there."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from origami.core.surface.left_out import STIFFNESS, Assessment, assess, stiffest
from origami.core.surface.surface_settings import SurfaceSettings

VIEW = sheets.camera()


def _assess(
    sheet: sheets.SyntheticSheet, creases: np.ndarray | None = None, count: int = 2500, **sampling
) -> Assessment:
    points, _ = sheets.sample_points(sheet, VIEW, count, noise=0.0005, **sampling)
    return assess(points, VIEW, sheets.outline_pixels(sheet, VIEW), SurfaceSettings(), creases)


def _pixels(sheet: sheets.SyntheticSheet, *lines: list[list[float]]) -> np.ndarray:
    """Lines between flat positions, in pixels of the photo."""
    return np.array([VIEW.project(sheet.in_space(np.array(line))) for line in lines])


def _true_creases(sheet: sheets.SyntheticSheet) -> np.ndarray:
    return np.array([VIEW.project(sheet.in_space(crease)) for crease in sheet.creases])


@pytest.mark.parametrize("make", [sheets.plane, sheets.one_fold, sheets.two_folds])
def test_paper_that_is_flat_between_its_folds_is_stiff(make):
    sheet = make()
    assert _assess(sheet, _true_creases(sheet) if sheet.creases else None).stiffness >= 30


def test_paper_with_a_fold_that_nobody_knows_of_is_less_stiff_than_with_it():
    """Two creases that cross, one of them unknown: a stiff surface would flatten it."""
    sheet = sheets.cross()
    known = _true_creases(sheet)
    assert _assess(sheet, known[:1]).stiffness < _assess(sheet, known).stiffness


def test_folds_are_sure_and_lines_on_smooth_paper_are_not():
    folded = sheets.two_folds()
    assert (_assess(folded, _true_creases(folded)).confidence > 0.99).all()
    smooth = sheets.cylinder()
    lines = _pixels(smooth, [[0.1, 0.2], [0.6, 0.25]], [[0.2, 0.1], [0.25, 0.9]])
    assert (_assess(smooth, lines).confidence < 0.9).all()


def test_a_line_on_blank_paper_is_not_sure():
    """The margin of this sheet is a quarter of its height, and the line is in it."""
    sheet = sheets.plane()
    line = _pixels(sheet, [[0.05, 0.08], [0.65, 0.08]])
    assert (_assess(sheet, line, margin=0.25).confidence < 0.9).all()


def test_outliers_do_not_matter():
    sheet = sheets.one_fold()
    with_outliers = _assess(sheet, _true_creases(sheet), outliers=0.2)
    assert with_outliers.stiffness >= 30
    assert (with_outliers.confidence > 0.99).all()


def test_the_same_points_give_the_same_answer():
    sheet = sheets.two_folds()
    one, other = (_assess(sheet, _true_creases(sheet)) for _ in range(2))
    assert one.stiffness == other.stiffness
    np.testing.assert_array_equal(one.confidence, other.confidence)


def test_a_handful_of_points_is_enough_to_go_on():
    sheet = sheets.plane()
    assert _assess(sheet, count=40, outliers=0.0).stiffness in STIFFNESS


@pytest.mark.parametrize("seed", range(3))
def test_a_few_noisy_points_of_flat_paper_do_not_bend_it(seed):
    sheet = sheets.plane()
    points, _ = sheets.sample_points(sheet, VIEW, 70, noise=0.005, outliers=0.0, seed=seed)
    edge = sheets.outline_pixels(sheet, VIEW)
    assert assess(points, VIEW, edge, SurfaceSettings()).stiffness >= 30


def test_the_stiffest_surface_that_is_not_clearly_worse_is_taken():
    best, noise = np.ones(100), np.tile([-0.2, 0.2], 50)
    # the standard error is .02
    assert stiffest([best, best + 0.009 + noise, best + 0.1 + noise]) == 1
    assert stiffest([best, best + 0.011 + noise, best + 0.1 + noise]) == 0
    assert stiffest([best + 0.1 + noise, best, best + 0.001]) == 1
    assert stiffest([best, best + 0.1 + noise, best + 0.009 + noise]) == 2
    assert stiffest([best]) == 0


def test_a_crease_has_the_confidence_of_its_surest_piece():
    pieces = np.array([[[0.0, 0.0], [0.4, 0.0]], [[0.4, 0.0], [0.7, 0.0]], [[0.4, -0.5], [0.4, 0.0]]])
    assessment = Assessment(1.0, pieces, np.array([0.3, 0.9, 0.6]))
    assert assessment.confidence_of(np.array([[0.01, 0.0], [0.69, 0.0]])) == 0.9
    assert assessment.confidence_of(np.array([[0.4, -0.4], [0.4, -0.01]])) == 0.6
