"""Few points define an outline, and only the moved ones change it."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.control_points import control_points, with_moved_controls
from origami.core.numeric.polygon import resample, signed_area


@pytest.fixture
def square():
    return resample(np.array([[0.0, 0], [100, 0], [100, 100], [0, 100]]), 1.0)


def test_a_square_has_four_control_points(square):
    controls = control_points(square, 0.1)
    np.testing.assert_allclose(
        sorted(map(tuple, square[controls])), [(0, 0), (0, 100), (100, 0), (100, 100)], atol=1e-9
    )


def test_a_circle_stays_within_the_tolerance():
    angle = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    circle = 100 * np.stack([np.cos(angle), np.sin(angle)], 1)
    controls = control_points(circle, 0.5)
    # An arc of angle a is 100 (1 - cos(a / 2)) from its chord.
    widest = 2 * np.arccos(1 - 0.5 / 100)
    gaps = np.diff(np.append(controls, controls[0] + 720)) * (2 * np.pi / 720)
    assert gaps.max() <= widest + 1e-9
    assert len(controls) <= 2 * 2 * np.pi / widest + 4


def test_untouched_controls_give_the_same_polygon_to_the_bit(square):
    controls = control_points(square, 0.1)
    again = with_moved_controls(square, controls, square[controls] + 1e-6, 1e-3)
    assert set(map(tuple, again)) == set(map(tuple, square))
    assert len(again) == len(square)


def test_one_moved_corner_changes_its_two_sides_only(square):
    controls = control_points(square, 0.1)
    moved = square[controls].copy()
    corner = int(np.argmax(moved.sum(1)))
    moved[corner] += 20
    again = with_moved_controls(square, controls, moved, 1e-3)
    assert signed_area(again) == pytest.approx(100 * 100 + 20 * 100)
    kept = set(map(tuple, again)) & set(map(tuple, square))
    assert len(kept) == 201  # two whole sides of 100 steps, and the far end of a third


def test_a_deleted_and_an_added_point(square):
    controls = control_points(square, 0.1)
    corner = int(np.argmax(square[controls].sum(1)))
    fewer = np.delete(square[controls], corner, axis=0)
    assert signed_area(with_moved_controls(square, controls, fewer, 1e-3)) == pytest.approx(5000)
    more = np.insert(square[controls], corner, [110.0, 50.0], axis=0)
    assert signed_area(with_moved_controls(square, controls, more, 1e-3)) == pytest.approx(100 * 100 + 10 * 100 / 2)
