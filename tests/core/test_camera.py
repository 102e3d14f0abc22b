"""Cameras project, distort and come back."""

from __future__ import annotations

import numpy as np
from origami.core.camera import Camera
from scipy.spatial.transform import Rotation


def _camera(k1: float = -0.05, k2: float = 0.01) -> Camera:
    return Camera(
        name="a.jpg",
        width=3000,
        height=2000,
        focal_length=2500.0,
        principal_point=np.array([1500.0, 1000.0]),
        distortion=np.array([k1, k2]),
        rotation=Rotation.from_euler("xyz", [10, -20, 30], degrees=True).as_matrix(),
        translation=np.array([0.1, -0.2, 3.0]),
    )


def test_point_on_the_axis_falls_on_the_principal_point():
    camera = _camera()
    ahead = camera.to_world_frame(np.array([0.0, 0.0, 5.0]))
    np.testing.assert_allclose(camera.project(ahead), [1500, 1000], atol=1e-9)


def test_radial_distortion_by_hand():
    camera = _camera(k1=0.1, k2=0.0)
    # x = 0.5, r^2 = 0.25: 0.5 * (1 + 0.025) * 2500 beyond the principal point.
    np.testing.assert_allclose(camera.distort(np.array([0.5, 0.0])), [1500 + 1281.25, 1000], atol=1e-9)


def test_undistort_inverts_distort():
    camera = _camera()
    normalized = np.random.default_rng(0).uniform(-0.6, 0.6, (200, 2))
    np.testing.assert_allclose(camera.undistort(camera.distort(normalized)), normalized, atol=1e-7)


def test_world_and_camera_frame_are_inverse_and_the_centre_is_the_origin():
    camera = _camera()
    points = np.random.default_rng(1).normal(size=(50, 3))
    np.testing.assert_allclose(camera.to_world_frame(camera.to_camera_frame(points)), points, atol=1e-12)
    np.testing.assert_allclose(camera.to_camera_frame(camera.center), 0, atol=1e-12)


def test_points_behind_the_camera_have_no_pixel():
    camera = _camera()
    assert np.isnan(camera.project(camera.to_world_frame(np.array([0.0, 0.0, -1.0])))).all()
