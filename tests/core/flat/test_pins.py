"""Flat maps with vertices held in place."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from origami.core.flat.distortion import measure_strain
from origami.core.flat.flatten import FlattenSettings, flatten
from origami.core.flat.pins import HeldSystem, Pins
from scipy import sparse
from scipy.linalg import orthogonal_procrustes

METHODS = ("arap", "conformal_l1", "lscm", "geodesic", "least_stretch")
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


def _page_corners(flat: np.ndarray) -> np.ndarray:
    return np.array([np.argmin(flat @ way) for way in ([1, 1], [-1, 1], [1, -1], [-1, -1])])


def test_a_held_system_is_solved_around_its_given_values():
    matrix = np.array([[4.0, 1, 0, 1], [1, 5, 2, 0], [0, 2, 6, 1], [1, 0, 1, 3]])
    held, values = np.array([2, 0]), np.array([[7.0, 1], [-3, 2]])
    right = np.arange(8.0).reshape(4, 2)
    solution = HeldSystem(sparse.csr_array(matrix), held).solve(right, values)
    assert (solution[held] == values).all()
    np.testing.assert_allclose((matrix @ solution)[[1, 3]], right[[1, 3]], atol=1e-12)
    everything = HeldSystem(sparse.csr_array(matrix), np.arange(4)).solve(right, right + 1)
    assert (everything == right + 1).all()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("count", [2, 3, 4])
def test_pins_where_the_sheet_has_them_give_the_sheet(method, count):
    sheet, flat = sheets.mesh(sheets.two_folds(), 0.04)
    goal = flat @ TURN.T + [5, -2]
    pinned = _page_corners(flat)[:count]
    uv = flatten(sheet, FlattenSettings(method), pins=Pins(pinned, goal[pinned]))
    assert (uv[pinned] == goal[pinned]).all()
    np.testing.assert_allclose(uv, goal, atol=5e-5)


@pytest.mark.parametrize("method", METHODS)
def test_one_pin_moves_the_map_as_a_whole(method):
    sheet, _ = sheets.mesh(sheets.one_fold(), 0.05)
    free = flatten(sheet, FlattenSettings(method))
    held = flatten(sheet, FlattenSettings(method), pins=Pins(np.array([17]), np.array([[3.0, 4.0]])))
    assert (held[17] == [3, 4]).all()
    np.testing.assert_allclose(held - held[17], free - free[17], atol=1e-12)


def test_stretched_pins_scale_the_conformal_map_and_not_the_rigid_one():
    sheet, flat = sheets.mesh(sheets.plane(), 0.04)
    pinned = np.array([np.argmin(np.linalg.norm(flat - place, axis=1)) for place in ([0.34, 0.2], [0.34, 0.8])])
    pins = Pins(pinned, 1.5 * flat[pinned])
    scale = {}
    for method in METHODS:
        uv = flatten(sheet, FlattenSettings(method), pins=pins)
        assert (uv[pinned] == pins.uv).all()
        scale[method] = measure_strain(sheet.vertices, sheet.triangles, uv).scale
    assert scale["conformal_l1"] == pytest.approx(1.5, abs=1e-6)
    assert scale["lscm"] == pytest.approx(1.5, abs=1e-6)
    assert scale["arap"] == pytest.approx(1, abs=0.05)
    assert scale["geodesic"] == pytest.approx(1, abs=0.05)


def test_a_fast_start_gives_the_same_rigid_map():
    sheet, _ = sheets.mesh(sheets.curved_folds(), 0.04)
    rough = sheets.Sheet(
        sheet.vertices + 0.003 * np.random.default_rng(0).normal(size=sheet.vertices.shape),
        sheet.triangles,
        sheet.ridges,
        sheet.boundary,
    )
    slow, fast = (flatten(rough, robust_start=robust) for robust in (True, False))
    slow, fast = slow - slow.mean(0), fast - fast.mean(0)
    assert np.abs(fast @ orthogonal_procrustes(fast, slow)[0] - slow).max() < 1e-4
