"""Flat maps of sheets whose flat map is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sheets
from cut_sheets import outer_part
from origami.benchmarks.transforms import displacement
from origami.core.flat.distortion import fit_similarity, flipped_triangles, measure_strain
from origami.core.flat.flatten import FlattenSettings, flatten
from origami.core.flat.geodesic import keep_geodesic_lengths
from origami.core.flat.settle import settle
from origami.core.flat.sides import corners, edge_turning, sides
from origami.core.numeric.robust import minimize
from origami.core.sheet import Sheet
from origami.core.watch import SILENT

METHODS = ("arap", "conformal_l1", "lscm", "geodesic", "least_stretch")


def _error(uv: np.ndarray, flat: np.ndarray) -> float:
    """Mean distance from the true flat position after the best similarity, page heights."""
    return float(displacement(uv, flat, fit_similarity(uv, flat)).mean())


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("make", [sheets.plane, sheets.one_fold, sheets.oblique_fold, sheets.cross])
def test_folded_planes_become_flat_exactly(make, method):
    sheet, flat = sheets.mesh(make(), 0.04)
    uv = flatten(sheet, FlattenSettings(method))
    assert _error(uv, flat) < 2e-5
    assert not flipped_triangles(sheet.triangles, uv).any()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("make", [sheets.cylinder, sheets.cone, sheets.curved_folds])
def test_curved_sheets_become_flat_to_the_mesh(make, method):
    sheet, flat = sheets.mesh(make(), 0.025)
    assert _error(flatten(sheet, FlattenSettings(method)), flat) < 1e-3


@pytest.mark.parametrize("method", METHODS)
def test_the_map_is_not_mirrored_and_has_true_size(method):
    sheet, flat = sheets.mesh(sheets.one_fold(), 0.05)
    uv = flatten(sheet, FlattenSettings(method))
    transform = fit_similarity(uv, flat)
    assert np.linalg.det(transform[:, :2]) == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("method", ["conformal_l1", "arap"])
def test_rows_for_ridges_and_sides_leave_a_true_surface_alone(method):
    sheet, flat = sheets.mesh(sheets.two_folds(), 0.04)
    uv = flatten(sheet, FlattenSettings(method, ridge_rows=True, boundary_rows=True))
    assert _error(uv, flat) < 2e-5


def _with_bumpy_side(seed: int = 0):
    """A folded sheet with one side whose depth was measured badly."""
    sheet, flat = sheets.mesh(sheets.one_fold(), 0.04)
    edge = flat[:, 0] > sheets.WIDTH - 1e-9
    vertices = sheet.vertices.copy()
    vertices[edge, 0] += 0.01 * np.sin(8 * flat[edge, 1])
    return replace(sheet, vertices=vertices), flat


def test_boundary_rows_straighten_the_sides():
    sheet, _ = _with_bumpy_side()

    def bend(uv: np.ndarray) -> float:
        worst = 0.0
        for side in sides(sheet):
            direction = uv[side[-1]] - uv[side[0]]
            normal = np.array([-direction[1], direction[0]]) / np.linalg.norm(direction)
            worst = max(worst, float(np.abs((uv[side] - uv[side[0]]) @ normal).max()))
        return worst

    free = bend(flatten(sheet, FlattenSettings("conformal_l1")))
    held = bend(flatten(sheet, FlattenSettings("conformal_l1", boundary_rows=True)))
    assert free > 0.005
    assert held < 0.2 * free


def test_rows_leave_a_notched_side_alone():
    """Part of one side is cut out of the sheet: forcing it straight would bend the page."""
    sheet, flat = sheets.mesh(sheets.plane(), 0.05)
    notch = (flat[:, 0] > 0.5) & (np.abs(flat[:, 1] - 0.5) < 0.12)
    inside = ~notch[sheet.triangles].any(1)
    notched = outer_part(sheet, inside)
    used = np.unique(sheet.triangles[inside])
    for method in ("conformal_l1", "arap"):
        uv = flatten(notched, FlattenSettings(method, boundary_rows=True))
        assert _error(uv, flat[used]) < 2e-4


@pytest.mark.parametrize("lines", [False, True])
def test_the_objective_of_the_l1_map_never_rises(monkeypatch, lines):
    fits = []

    def recording(*args, **kwargs):
        fits.append(minimize(*args, **kwargs))
        return fits[-1]

    monkeypatch.setattr("origami.core.flat.conformal_map.minimize", recording)
    sheet, _ = _with_bumpy_side()
    flatten(sheet, FlattenSettings("conformal_l1", ridge_rows=lines, boundary_rows=lines))
    objective = np.array(fits[-1].objective)
    assert len(objective) > (3 if lines else 1)
    assert (np.diff(objective) <= 1e-9 * np.abs(objective[:-1])).all()


def test_settling_stops_where_nothing_moves_and_keeps_the_centre():
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    steps = []

    def halfway(flat: np.ndarray) -> np.ndarray:
        steps.append(flat)
        return corners + (flat - corners) / 2 + 5.0

    settled = settle(corners * 1.5, halfway, 200, SILENT)
    assert len(steps) < 30
    np.testing.assert_allclose(settled - settled.mean(0), corners - 0.5, atol=2e-6)
    np.testing.assert_allclose(settled.mean(0), [0.75, 0.75])


def test_arap_has_less_strain_than_the_conformal_map():
    sheet, _ = _with_bumpy_side()

    def strain(method: str) -> float:
        uv = flatten(sheet, FlattenSettings(method))
        return float(((measure_strain(sheet.vertices, sheet.triangles, uv).singular_values - 1) ** 2).sum())

    assert strain("arap") < strain("lscm")


def test_geodesic_springs_restore_a_stretched_map():
    sheet, flat = sheets.mesh(sheets.plane(), 0.05)
    stretched = flat * [1.2, -0.9]
    restored = keep_geodesic_lengths(sheet, stretched)
    assert _error(restored * [1, -1], flat) < 1e-3


@pytest.mark.parametrize("make", [sheets.plane, sheets.cross, sheets.cylinder])
def test_corners_are_found_on_the_folded_sheet(make):
    sheet, flat = sheets.mesh(make(), 0.02)
    place = sheet.boundary[corners(sheet)]
    assert {tuple(np.abs(p)) for p in flat[place].round(9)} == {(0.0, 0.0), (0.7, 0.0), (0.0, 1.0), (0.7, 1.0)}
    assert [len(side) for side in sides(sheet)].count(0) == 0
    assert sum(len(side) - 1 for side in sides(sheet)) == len(sheet.boundary)


def test_a_plane_edge_turns_once_around():
    sheet, _ = sheets.mesh(sheets.plane(), 0.05)
    assert edge_turning(sheet).sum() == pytest.approx(2 * np.pi)


def test_a_round_sheet_has_no_sides():
    angle = np.linspace(0, 2 * np.pi, 80, endpoint=False)
    vertices = np.vstack([np.c_[np.cos(angle), np.sin(angle), 0 * angle], np.zeros((1, 3))])
    ring = np.arange(80)
    triangles = np.stack([ring, np.roll(ring, -1), np.full(80, 80)], axis=1)
    assert sides(Sheet(vertices, triangles, (), ring)) == []
