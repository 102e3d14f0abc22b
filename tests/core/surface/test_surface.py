"""Surfaces from points: exact on planes, robust to outliers, sharper with the ridges known."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from origami.core.errors import StepFailed
from origami.core.numeric.robust import minimize
from origami.core.surface.curvature import principal_curvature, ridge_candidates
from origami.core.surface.noise import point_noise
from origami.core.surface.surface import Surface, reconstruct
from origami.core.surface.surface_settings import SurfaceSettings

METHODS = ("poisson_l2", "poisson", "ridge_aware", "developable")


def _reconstruct(sheet: sheets.SyntheticSheet, method: str, **sampling) -> Surface:
    view = sheets.camera()
    points, _ = sheets.sample_points(sheet, view, 1500, **sampling)
    return reconstruct(points, view, sheets.outline_pixels(sheet, view), SurfaceSettings(method, grid_rows=60))


def _depth_error(surface: Surface, sheet: sheets.SyntheticSheet) -> np.ndarray:
    """Surface minus truth along the ray (page heights), on vertices at least 2 % inside the page."""
    mesh, flat = sheets.mesh(sheet)
    inner = (np.abs(flat - [0.35, 0.5]) < [0.33, 0.48]).all(1)
    plane, inverse_depth = surface.grid.frame.from_world(mesh.vertices[inner])
    rows, inside = surface.grid.sampling_rows(plane)
    assert inside.all()
    return rows @ surface.inverse_depth - inverse_depth


@pytest.mark.parametrize("method", METHODS)
def test_a_plane_without_noise_is_exact(method):
    surface = _reconstruct(sheets.plane(), method, noise=0.0, outliers=0.0)
    assert np.abs(_depth_error(surface, sheets.plane())).max() < 1e-5


@pytest.mark.parametrize("method", ["poisson", "ridge_aware", "developable"])
@pytest.mark.parametrize("make", [sheets.cylinder, sheets.cone, sheets.one_fold, sheets.oblique_fold])
def test_outliers_do_not_matter(make, method):
    error = _depth_error(_reconstruct(make(), method, noise=0.001, outliers=0.1), make())
    assert np.sqrt((error**2).mean()) < 0.003


def test_plain_least_squares_is_ruined_by_the_same_outliers():
    error = _depth_error(_reconstruct(sheets.cylinder(), "poisson_l2", noise=0.001, outliers=0.1), sheets.cylinder())
    assert np.sqrt((error**2).mean()) > 0.006


def test_each_prior_is_better_than_the_last_at_a_crease():
    errors = {}
    for method in ("poisson", "ridge_aware", "developable"):
        error = _depth_error(_reconstruct(sheets.two_folds(), method, noise=0.0005), sheets.two_folds())
        errors[method] = np.sqrt((error**2).mean())
    assert errors["ridge_aware"] < errors["poisson"]
    assert errors["developable"] < 0.8 * errors["poisson"]


@pytest.mark.parametrize("method", ["poisson", "ridge_aware", "developable"])
def test_the_objective_of_each_solve_never_rises(monkeypatch, method):
    """The developable prior is a new problem in each outer iteration; within one its objective falls."""
    fits = []

    def recording(*args, **kwargs):
        fits.append(minimize(*args, **kwargs))
        return fits[-1]

    monkeypatch.setattr("origami.core.surface.solvers.minimize", recording)
    _reconstruct(sheets.two_folds(), method, noise=0.001)
    assert len(fits) == {"poisson": 1, "ridge_aware": 2, "developable": 9}[method]
    for fit in fits:
        assert (np.diff(fit.objective) <= 1e-9 * np.abs(fit.objective[0])).all()


def test_positions_on_the_surface_are_given_in_space():
    surface = _reconstruct(sheets.plane(), "poisson", noise=0.0, outliers=0.0)
    truth = sheets.mesh(sheets.plane())[0].vertices
    plane, _ = surface.grid.frame.from_world(truth)
    np.testing.assert_allclose(surface.at(plane), truth, atol=1e-5)


def test_curvature_of_a_cylinder_lies_across_its_ruling():
    surface = _reconstruct(sheets.cylinder(), "developable", noise=0.0002, outliers=0.0)
    curvature = surface.curvature
    bent = np.abs(curvature.across) > 0.5 * np.abs(curvature.across).max()
    assert np.median(np.abs(curvature.along[bent]) / np.abs(curvature.across[bent])) < 0.05


def test_principal_curvature_of_a_known_quadratic():
    surface = _reconstruct(sheets.plane(), "poisson", noise=0.0, outliers=0.0)
    x, y = surface.grid.node_positions().T
    angle = np.radians(30)
    across = -np.sin(angle) * x + np.cos(angle) * y
    along = np.cos(angle) * x + np.sin(angle) * y
    curvature = principal_curvature(surface.grid, 3.0 * across**2 - 0.5 * along**2)
    np.testing.assert_allclose(curvature.across, 6.0, atol=1e-6)
    np.testing.assert_allclose(curvature.along, -1.0, atol=1e-6)
    np.testing.assert_allclose(np.abs(curvature.direction @ [np.cos(angle), np.sin(angle)]), 1.0, atol=1e-9)
    assert ridge_candidates(curvature, 5.9).all()
    assert not ridge_candidates(curvature, 6.1).any()


def test_noise_is_measured_whatever_the_outliers():
    random = np.random.default_rng(0)
    positions = random.random((2000, 2))
    values = np.sin(2 * positions[:, 0]) + positions[:, 1] ** 2 + 0.003 * random.standard_normal(2000)
    values[::12] += random.uniform(-1, 1, len(values[::12]))
    assert point_noise(positions, values) == pytest.approx(0.003, rel=0.25)


def test_too_few_points_is_a_sentence():
    view = sheets.camera()
    points, _ = sheets.sample_points(sheets.plane(), view, 11)
    with pytest.raises(StepFailed, match="Only 11 points"):
        reconstruct(points, view, sheets.outline_pixels(sheets.plane(), view))


def test_world_scale_does_not_matter():
    """Thresholds are in page heights: the same scene in other units gives the same surface."""
    from dataclasses import replace

    sheet, view = sheets.one_fold(), sheets.camera()
    points, _ = sheets.sample_points(sheet, view, 800)
    polygon = sheets.outline_pixels(sheet, view)
    settings = SurfaceSettings(grid_rows=40)
    one = reconstruct(points, view, polygon, settings)
    larger = replace(view, translation=view.translation * 37.0)
    other = reconstruct(points * 37.0, larger, polygon, settings)
    np.testing.assert_allclose(one.inverse_depth, other.inverse_depth, atol=1e-6)
