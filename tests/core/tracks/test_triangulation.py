"""Points from their places in several photos, and cameras adjusted to them, on scenes whose truth is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from origami.core.camera import Camera
from origami.core.tracks.adjustment import adjust, resect
from origami.core.tracks.triangulation import triangulate
from scipy.spatial.transform import Rotation

COUNT = 400


def cameras(distortion: tuple[float, float] = (0.05, -0.1), off_center: tuple[float, float] = (12.0, -8.0)):
    """Six around a sheet in the plane z = 0, with one lens."""
    found = []
    for number, (azimuth, tilt) in enumerate([(0, 20), (60, 35), (120, 30), (180, 25), (240, 40), (300, 30)]):
        rotation = Rotation.from_euler("zxz", [azimuth, tilt, -azimuth], degrees=True).as_matrix()
        found.append(
            Camera(
                f"{number}.jpg",
                1200,
                1600,
                1500.0,
                np.array([600.0, 800.0]) + off_center,
                np.array(distortion),
                rotation,
                np.array([0, 0, 1.6]),
            )
        )
    return tuple(found)


@pytest.fixture
def points() -> np.ndarray:
    """On a sheet folded along x = 0."""
    random = np.random.default_rng(3)
    flat = random.uniform([-0.35, -0.5], [0.35, 0.5], (COUNT, 2))
    return np.column_stack([flat, -0.3 * np.abs(flat[:, 0])])


def seen(by: tuple[Camera, ...], points: np.ndarray) -> np.ndarray:
    return np.stack([camera.project(points) for camera in by], axis=1)


def test_points_are_found_exactly(points):
    found = triangulate(cameras(), seen(cameras(), points))
    np.testing.assert_allclose(found.points, points, atol=1e-8)
    assert found.usable.all()


def test_a_wrong_observation_is_dropped_and_its_point_kept(points):
    observed = seen(cameras(), points) + np.random.default_rng(1).normal(scale=0.05, size=(COUNT, 6, 2))
    observed[::10, 2] += 15
    found = triangulate(cameras(), observed)
    assert not found.kept[::10, 2].any()
    assert found.usable.all()
    assert np.abs(found.points - points)[::10].max() < 3e-4
    assert found.deviation == pytest.approx(0.05, rel=0.25)


def test_a_point_in_two_photos_is_not_usable(points):
    observed = seen(cameras(), points)
    observed[0, 2:] = np.nan
    found = triangulate(cameras(), observed)
    assert not found.usable[0]
    assert found.usable[1:].all()


def test_a_lens_is_found_from_a_simpler_one(points):
    true = cameras()
    observed = seen(true, points) + np.random.default_rng(2).normal(scale=0.02, size=(COUNT, 6, 2))
    wrong = tuple(
        replace(camera, focal_length=1510.0, principal_point=np.array([600.0, 800.0]), distortion=np.zeros(2))
        for camera in true
    )
    before, after = triangulate(wrong, observed), triangulate(adjust(wrong, observed), observed)
    assert after.deviation < 0.03 < 0.1 < before.deviation
    lens = adjust(wrong, observed)[0]
    np.testing.assert_allclose(lens.distortion, true[0].distortion, atol=0.02)
    np.testing.assert_allclose(lens.principal_point, true[0].principal_point, atol=3.0)


def test_all_photos_keep_one_lens_and_true_cameras_stay(points):
    true = cameras()
    found = adjust(true, seen(true, points))
    for camera, before in zip(found, true, strict=True):
        np.testing.assert_allclose(camera.distortion, found[0].distortion)
        np.testing.assert_allclose(camera.center, before.center, atol=1e-6)
        assert camera.focal_length == pytest.approx(before.focal_length, abs=1e-3)


def test_a_photo_that_shows_nothing_stays_and_the_others_are_adjusted(points):
    true = cameras()
    observed = seen(true, points)
    observed[:, 4] = np.nan
    off = tuple(
        replace(camera, translation=camera.translation + np.array([0, 0, 0.01 * (k == 2)]))
        for k, camera in enumerate(true)
    )
    found = adjust(off, observed)
    np.testing.assert_allclose(found[4].center, true[4].center, atol=1e-9)
    assert triangulate(found, observed).deviation < 0.03


def test_a_camera_is_found_from_points_that_are_known(points):
    (true, *_) = cameras()
    observed = true.project(points) + np.random.default_rng(4).normal(scale=0.05, size=(COUNT, 2))
    observed[::20] += 12
    turn = Rotation.from_euler("xyz", [0.5, -0.4, 0.3], degrees=True).as_matrix()
    wrong = replace(true, focal_length=1512.0, rotation=turn @ true.rotation, translation=true.translation + 0.004)
    found = resect(wrong, points, observed)
    assert np.abs(found.project(points) - true.project(points)).max() < 0.1
    assert found.focal_length == pytest.approx(1500, rel=0.005)
