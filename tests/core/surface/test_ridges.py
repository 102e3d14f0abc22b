"""Crease lines are found where the sheet is folded, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from origami.core.surface.ridges import find_ridges, straight_in_space
from origami.core.surface.surface import Surface, reconstruct
from origami.core.surface.surface_settings import SurfaceSettings


def _surface(sheet: sheets.SyntheticSheet) -> Surface:
    view = sheets.camera()
    points, _ = sheets.sample_points(sheet, view, 3000, noise=0.0005, lines=False)
    return reconstruct(points, view, sheets.outline_pixels(sheet, view), SurfaceSettings(grid_rows=70))


def _true_creases(surface: Surface, sheet: sheets.SyntheticSheet) -> list[np.ndarray]:
    return [surface.grid.frame.from_world(sheet.in_space(crease))[0] for crease in sheet.creases]


def _angle_and_offset(found: np.ndarray, true: np.ndarray) -> tuple[float, float]:
    direction = (true[1] - true[0]) / np.linalg.norm(true[1] - true[0])
    normal = np.array([-direction[1], direction[0]])
    span = found[1] - found[0]
    angle = abs(np.degrees(np.arcsin(span @ normal / np.linalg.norm(span))))
    return angle, float(np.abs((found - true[0]) @ normal).max())


@pytest.mark.parametrize("make", [sheets.one_fold, sheets.two_folds, sheets.oblique_fold])
def test_each_fold_is_found_once_and_in_place(make):
    sheet = make()
    surface = _surface(sheet)
    ridges = find_ridges(surface)
    assert len(ridges) == len(sheet.creases)
    for true in _true_creases(surface, sheet):
        angle, offset = min((_angle_and_offset(ridge.ends, true) for ridge in ridges), key=lambda pair: pair[1])
        assert angle < 1.5
        assert offset < 0.006


@pytest.mark.parametrize("make", [sheets.plane, sheets.cylinder, sheets.cone])
def test_smooth_sheets_have_no_ridges(make):
    assert find_ridges(_surface(make())) == ()


def test_mountain_and_valley_have_opposite_signs():
    ridges = find_ridges(_surface(sheets.two_folds()))
    assert {np.sign(ridge.curvature) for ridge in ridges} == {-1.0, 1.0}


def test_a_line_that_bends_along_the_line_of_sight_is_split_where_it_does():
    sheet = sheets.one_fold()
    surface = _surface(sheet)
    (crease,) = _true_creases(surface, sheet)
    (along,) = straight_in_space(surface, crease)
    np.testing.assert_array_equal(along, crease)
    across = surface.grid.frame.from_world(sheet.in_space(np.array([[0.35, 0.1], [0.35, 0.9]])))[0]
    before, after = straight_in_space(surface, across)
    np.testing.assert_array_equal(before[1], after[0])
    normal = np.array([crease[0, 1] - crease[1, 1], crease[1, 0] - crease[0, 0]])
    assert abs((before[1] - crease[0]) @ normal) / np.linalg.norm(normal) < 0.02
