"""Surfaces with given creases: sharp there, in place although drawn by hand, and harmless where there is no fold."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from origami.core.creases.creases import crease_figures
from origami.core.surface.mesh import build_sheet
from origami.core.surface.surface import Surface, reconstruct
from origami.core.surface.surface_settings import SurfaceMethod, SurfaceSettings

VIEW = sheets.camera()


def _surface(
    sheet: sheets.SyntheticSheet,
    creases: list[np.ndarray] | None,
    method: SurfaceMethod = "developable",
) -> Surface:
    points, _ = sheets.sample_points(sheet, VIEW, 1500, noise=0.0005)
    given = None if creases is None else np.array([VIEW.project(sheet.in_space(ends)) for ends in creases])
    polygon = sheets.outline_pixels(sheet, VIEW)
    return reconstruct(points, VIEW, polygon, SurfaceSettings(method, grid_rows=45), creases=given)


def _errors(surface: Surface, sheet: sheets.SyntheticSheet) -> tuple[float, float]:
    """Root mean square distance from the truth along the ray: of all places, and of those beside creases."""
    mesh, flat = sheets.mesh(sheet)
    inner = (np.abs(flat - [0.35, 0.5]) < [0.33, 0.48]).all(1)
    plane, inverse_depth = surface.grid.frame.from_world(mesh.vertices[inner])
    error = surface.grid.interpolate(surface.inverse_depth, plane) - inverse_depth
    beside = np.zeros(len(flat), bool) if sheet.creases else np.ones(len(flat), bool)
    for start, end in sheet.creases:
        share = np.clip((flat - start) @ (end - start) / ((end - start) @ (end - start)), 0, 1)
        beside |= np.linalg.norm(flat - start - share[:, None] * (end - start), axis=1) < 0.02
    return float(np.sqrt((error**2).mean())), float(np.sqrt((error[beside[inner]] ** 2).mean()))


def _drawn_by_hand(sheet: sheets.SyntheticSheet, error: float, seed: int = 3) -> list[np.ndarray]:
    random = np.random.default_rng(seed)
    return [ends + error * random.uniform(-1, 1, (2, 2)) for ends in sheet.creases]


@pytest.mark.parametrize("method", ["developable", "ridge_aware", "poisson"])
def test_a_given_crease_is_sharp_whatever_the_method(method):
    sheet = sheets.two_folds()
    without = _errors(_surface(sheet, None, method), sheet)
    given = _errors(_surface(sheet, list(sheet.creases), method), sheet)
    assert given[0] < without[0]
    assert given[1] < 0.6 * without[1]


@pytest.mark.parametrize("make", [sheets.oblique_fold, sheets.curved_folds, sheets.cross])
def test_creases_of_all_kinds_help(make):
    sheet = make()
    without, given = _errors(_surface(sheet, None), sheet), _errors(_surface(sheet, list(sheet.creases)), sheet)
    assert given[1] < 0.8 * without[1]


def test_a_crease_drawn_beside_its_place_moves_there():
    sheet = sheets.two_folds()
    drawn = _drawn_by_hand(sheet, 0.006)
    surface = _surface(sheet, drawn)
    assert _errors(surface, sheet)[1] < 0.4 * _errors(_surface(sheet, None), sheet)[1]

    def beside(line: np.ndarray, true: np.ndarray) -> np.ndarray:
        """Distance of a line's ends from a crease, page lengths."""
        first, last = surface.grid.frame.from_pixels(VIEW.project(sheet.in_space(true)))
        along = (last - first) / np.linalg.norm(last - first)
        return np.abs((line - first) @ [-along[1], along[0]])

    before = [surface.grid.frame.from_pixels(VIEW.project(sheet.in_space(ends))) for ends in drawn]
    pairs = zip(before, surface.creases, sheet.creases, strict=True)
    offsets = np.array([(beside(old, true), beside(new, true)) for old, new, true in pairs])
    assert offsets[:, 1].mean() < 0.75 * offsets[:, 0].mean()


def test_a_crease_where_there_is_none_does_no_harm():
    sheet = sheets.cylinder()
    made_up = [np.array([[0.0, 0.3], [0.7, 0.6]])]
    surface = _surface(sheet, made_up)
    assert _errors(surface, sheet)[0] < 1.3 * _errors(_surface(sheet, None), sheet)[0]


def test_an_empty_list_is_a_sheet_without_creases():
    sheet = sheets.one_fold()
    without = _surface(sheet, None)
    empty = reconstruct(
        sheets.sample_points(sheet, VIEW, 1500, noise=0.0005)[0],
        VIEW,
        sheets.outline_pixels(sheet, VIEW),
        SurfaceSettings(grid_rows=45),
        creases=np.zeros((0, 2, 2)),
    )
    assert empty.creases == ()
    np.testing.assert_array_equal(empty.inverse_depth, without.inverse_depth)


def test_the_mesh_has_the_creases_with_their_angles_up_to_the_edge():
    sheet = sheets.two_folds()
    surface = _surface(sheet, _drawn_by_hand(sheet, 0.003))
    polygon = sheets.outline_pixels(sheet, VIEW)
    built = build_sheet(surface, polygon, list(surface.creases))
    assert len(built.ridges) == 2
    for ridge, crease, fold in zip(built.ridges, crease_figures(built), (0.7, -0.6), strict=True):
        assert np.isin(ridge[[0, -1]], built.boundary).all()
        assert crease.fold_angle == pytest.approx(-np.degrees(fold), abs=1.5)
        assert crease.length == pytest.approx(sheets.WIDTH, rel=0.02)


def test_crossing_creases_become_four_that_meet():
    sheet = sheets.cross()
    surface = _surface(sheet, _drawn_by_hand(sheet, 0.002))
    built = build_sheet(surface, sheets.outline_pixels(sheet, VIEW), list(surface.creases))
    assert len(built.ridges) == 4
    assert len(set.intersection(*(set(ridge.tolist()) for ridge in built.ridges))) == 1
    angles = sorted(crease.fold_angle for crease in crease_figures(built))
    np.testing.assert_allclose(angles, [-42, -41, -11, 11], atol=2)
