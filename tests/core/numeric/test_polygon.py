"""Closed polygons."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.polygon import filled_polygon, inside_polygon, resample, signed_area, simplified


def test_inside_a_notched_polygon():
    notch = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 1.0], [0.0, 2.0]])
    points = np.array([[1.0, 0.5], [1.0, 1.5], [0.2, 1.5], [3.0, 1.0], [-1.0, 0.0]])
    assert inside_polygon(points, notch).tolist() == [True, False, True, False, False]


def test_area_and_spacing_of_a_square():
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    assert signed_area(square) == pytest.approx(4.0)
    assert signed_area(square[::-1]) == pytest.approx(-4.0)
    even = resample(square, 0.5)
    assert len(even) == 16
    np.testing.assert_allclose(np.linalg.norm(np.diff(even, axis=0), axis=1), 0.5)


def test_simplified_keeps_the_corners_of_a_noisy_notched_polygon():
    notch = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 1.0], [0.0, 2.0]])
    fine = resample(notch, 0.01) + np.random.default_rng(0).uniform(-0.003, 0.003, (len(resample(notch, 0.01)), 2))
    for start in (0, 100, 333):
        found = simplified(np.roll(fine, start, axis=0), 0.02)
        assert len(found) == 5
        assert np.linalg.norm(found[:, None] - notch, axis=2).min(axis=0).max() < 0.02


@pytest.mark.parametrize("seed", range(4))
def test_filled_polygon_is_where_the_pixels_centres_are_inside(seed):
    polygon = np.random.default_rng(seed).uniform(-10, 60, (9, 2))
    y, x = np.mgrid[:40, :50] + 0.5
    inside = inside_polygon(np.stack([x.ravel(), y.ravel()], axis=1), polygon).reshape(40, 50)
    assert (filled_polygon(polygon, (40, 50)) == inside).all()
