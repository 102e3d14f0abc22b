"""A surface that looks for its creases itself is sharp where the sheet is folded, and as before where it is not."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from origami.core.creased_surface import reconstruct_with_creases
from origami.core.surface import Surface, SurfaceMethod, SurfaceSettings, reconstruct

VIEW = sheets.camera()
ROWS = 60


def _surfaces(sheet: sheets.SyntheticSheet, method: SurfaceMethod = "developable") -> tuple[Surface, Surface]:
    """Without looking for creases, and with."""
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


@pytest.mark.parametrize("make", [sheets.cylinder, sheets.cone])
def test_without_creases_the_surface_is_the_smooth_one(make):
    smooth, creased = _surfaces(make())
    assert creased.creases == ()
    np.testing.assert_array_equal(creased.inverse_depth, smooth.inverse_depth)


def test_published_methods_keep_their_only_surface():
    smooth, creased = _surfaces(sheets.two_folds(), "ridge_aware")
    assert len(creased.creases) > 0
    np.testing.assert_array_equal(creased.inverse_depth, smooth.inverse_depth)
