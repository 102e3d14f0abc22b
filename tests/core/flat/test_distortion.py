from __future__ import annotations

import numpy as np
import pytest
import sheets
from origami.benchmarks.transforms import displacement
from origami.core.flat import distortion

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
TWO_TRIANGLES = np.array([[0, 3, 2], [0, 2, 1]])


@pytest.mark.parametrize("make", sheets.ALL, ids=lambda make: make.__name__)
def test_true_flat_map_has_next_to_no_strain(make):
    sheet, flat = sheets.mesh(make(), 0.01)
    strain = distortion.measure_strain(sheet.vertices, sheet.triangles, flat)
    # Chords of a curved sheet are shorter than the sheet: only folded planes are met exactly.
    assert strain.stretch.max() < (1e-3 if make in (sheets.cylinder, sheets.cone, sheets.curved_folds) else 1e-6)
    assert strain.scale == pytest.approx(1, abs=1e-4)
    assert strain.area.sum() == pytest.approx(1)
    assert not distortion.flipped_triangles(sheet.triangles, flat).any()


def test_strain_does_not_depend_on_scale_or_pose():
    uv = SQUARE[:, :2] * 3 @ np.array([[0.6, 0.8], [-0.8, 0.6]]) + 5
    strain = distortion.measure_strain(SQUARE[:, [2, 0, 1]] * 7, TWO_TRIANGLES, uv)
    np.testing.assert_allclose(strain.singular_values, 1)
    assert strain.scale == pytest.approx(3 / 7)


def test_strain_of_a_known_stretch():
    strain = distortion.measure_strain(SQUARE, TWO_TRIANGLES, SQUARE[:, :2] * [2, 0.5])
    np.testing.assert_allclose(strain.singular_values, [[2, 0.5]] * 2)
    np.testing.assert_allclose(strain.angle_distortion, 4)
    np.testing.assert_allclose(strain.area_distortion, 1)
    np.testing.assert_allclose(strain.stretch, 1)


def test_shear_keeps_areas_but_not_angles():
    strain = distortion.measure_strain(SQUARE, TWO_TRIANGLES, SQUARE[:, :2] @ np.array([[1, 0], [1, 1.0]]))
    np.testing.assert_allclose(strain.area_distortion, 1)
    golden = (1 + np.sqrt(5)) / 2
    np.testing.assert_allclose(strain.singular_values, [[golden, 1 / golden]] * 2)


def test_collapsed_triangle_is_infinitely_distorted():
    uv = np.array([[0, 0], [1, 0], [1, 1], [0.5, 0.5]])
    strain = distortion.measure_strain(SQUARE, TWO_TRIANGLES, uv)
    assert np.isinf(strain.angle_distortion[0])
    assert list(distortion.flipped_triangles(TWO_TRIANGLES, uv)) == [True, False]


def test_flipped_triangles():
    folded_over = np.array([[0, 0], [1, 0], [1, 1], [0.9, 0.5]])
    assert list(distortion.flipped_triangles(TWO_TRIANGLES, SQUARE[:, :2])) == [False, False]
    assert list(distortion.flipped_triangles(TWO_TRIANGLES, folded_over)) == [True, False]
    assert distortion.flipped_triangles(TWO_TRIANGLES, SQUARE[:, :2] * [-1, 1]).all()


def test_affine_is_recovered_from_matches():
    matches = np.random.default_rng(0).random((50, 2)) * 1000
    truth = np.array([[1.1, 0.2, 30], [-0.1, 0.9, -4]])
    target = matches @ truth[:, :2].T + truth[:, 2]
    affine = distortion.fit_affine(matches, target)
    np.testing.assert_allclose(affine, truth, atol=1e-9)
    assert displacement(matches, target, affine).max() < 1e-9


def test_similarity_leaves_an_aspect_error_standing():
    grid = np.stack(np.meshgrid([-1.0, 1.0], [-1.0, 1.0]), -1).reshape(-1, 2)
    turned = grid @ np.array([[0, 2], [-2, 0]]) + [3, 4]
    assert displacement(grid, turned, distortion.fit_similarity(grid, turned)).max() < 1e-12
    wider = grid * [1.1, 0.9]
    np.testing.assert_allclose(displacement(grid, wider, distortion.fit_similarity(grid, wider)), 0.1 * np.sqrt(2))


def test_similarity_never_mirrors():
    points = np.random.default_rng(1).random((20, 2))
    similarity = distortion.fit_similarity(points, points * [-1, 1])
    assert np.linalg.det(similarity[:, :2]) >= 0
