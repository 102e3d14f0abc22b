"""A surface with detected creases is sharp where the sheet is folded, and smooth elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from origami.core.surface.creased_surface import reconstruct_with_creases
from origami.core.surface.surface import Surface, reconstruct
from origami.core.surface.surface_settings import SurfaceMethod, SurfaceSettings

VIEW = sheets.camera()
ROWS = 60


def _surfaces(sheet: sheets.SyntheticSheet, method: SurfaceMethod = "developable") -> tuple[Surface, Surface]:
    """Surfaces without and with detection of creases."""
    points, _ = sheets.sample_points(sheet, VIEW, 2500, noise=0.0005, lines=False)
    polygon, settings = sheets.outline_pixels(sheet, VIEW), SurfaceSettings(method, grid_rows=ROWS)
    smooth = reconstruct(points, VIEW, polygon, settings)
    return smooth, reconstruct_with_creases(points, VIEW, polygon, settings)


def _error_beside_creases(surface: Surface, sheet: sheets.SyntheticSheet) -> float:
    """Root mean square distance from the truth along the ray."""
    mesh, flat = sheets.mesh(sheet)
    beside = np.zeros(len(flat), bool)
    for start, end in sheet.creases:
        share = np.clip((flat - start) @ (end - start) / ((end - start) @ (end - start)), 0.05, 0.95)
        beside |= np.linalg.norm(flat - start - share[:, None] * (end - start), axis=1) < 0.02
    plane, inverse_depth = surface.grid.frame.from_world(mesh.vertices[beside])
    return float(np.sqrt(((surface.grid.interpolate(surface.inverse_depth, plane) - inverse_depth) ** 2).mean()))


@pytest.mark.parametrize("make", [sheets.one_fold, sheets.oblique_fold])
def test_creases_that_are_found_are_sharp(make):
    sheet = make()
    smooth, creased = _surfaces(sheet)
    assert len(creased.creases) == len(sheet.creases)
    assert _error_beside_creases(creased, sheet) < 0.6 * _error_beside_creases(smooth, sheet)


def test_creases_reach_the_papers_edge():
    sheet = sheets.one_fold()
    surface = _surfaces(sheet)[1]
    ends = np.concatenate(surface.creases)
    for crease in sheet.creases:
        for true in surface.grid.frame.from_world(sheet.in_space(crease))[0]:
            assert np.linalg.norm(ends - true, axis=1).min() < 0.01


def test_a_sheet_of_two_planes_is_two_planes_where_there_is_little_print():
    """All print is in three blocks; between them and in the margins only the stiffness holds the paper."""
    sheet = sheets.one_fold()
    points, flat = sheets.sample_points(sheet, VIEW, 3000, noise=0.0005, lines=False)
    blocks = (flat[:, 1] < 0.15) | ((flat[:, 1] > 0.3) & (flat[:, 1] < 0.55)) | (flat[:, 1] > 0.9)
    printed = blocks & ((flat[:, 0] < 0.25) | (flat[:, 0] > 0.5))
    surface = reconstruct_with_creases(
        points[printed], VIEW, sheets.outline_pixels(sheet, VIEW), SurfaceSettings(grid_rows=ROWS)
    )
    limp = reconstruct(points[printed], VIEW, sheets.outline_pixels(sheet, VIEW), SurfaceSettings(grid_rows=ROWS))
    mesh, _ = sheets.mesh(sheet)
    plane, inverse_depth = surface.grid.frame.from_world(mesh.vertices)
    errors = [np.abs(one.grid.interpolate(one.inverse_depth, plane) - inverse_depth) for one in (surface, limp)]
    assert len(surface.creases) == 1
    assert surface.stiffness >= 30
    assert np.percentile(errors[0], 95) < 0.001
    assert np.percentile(errors[0], 95) < 0.3 * np.percentile(errors[1], 95)


@pytest.mark.parametrize("make", [sheets.cylinder, sheets.cone])
def test_a_smooth_curl_keeps_no_crease(make):
    _, creased = _surfaces(make())
    assert creased.creases == ()
    assert creased.confidence == ()


def test_crossing_folds_stay_sharp():
    smooth, creased = _surfaces(sheets.cross())
    assert len(creased.creases) >= 3
    assert min(creased.confidence) > 0.95
    assert _error_beside_creases(creased, sheets.cross()) < _error_beside_creases(smooth, sheets.cross())


def test_the_factor_that_is_asked_for_comes_on_top_of_what_is_chosen():
    sheet = sheets.cylinder()
    points, _ = sheets.sample_points(sheet, VIEW, 2500, noise=0.0005, lines=False)
    polygon = sheets.outline_pixels(sheet, VIEW)
    twice = reconstruct_with_creases(points, VIEW, polygon, SurfaceSettings(grid_rows=ROWS, smoothness=2.0))
    plain = reconstruct(points, VIEW, polygon, SurfaceSettings(grid_rows=ROWS, smoothness=2.0 * twice.stiffness))
    np.testing.assert_array_equal(twice.inverse_depth, plain.inverse_depth)


def test_the_same_seed_gives_the_same_surface():
    one, other = (_surfaces(sheets.two_folds())[1] for _ in range(2))
    np.testing.assert_array_equal(one.inverse_depth, other.inverse_depth)


def test_published_methods_keep_their_only_surface():
    smooth, creased = _surfaces(sheets.two_folds(), "ridge_aware")
    assert len(creased.creases) > 0
    np.testing.assert_array_equal(creased.inverse_depth, smooth.inverse_depth)
