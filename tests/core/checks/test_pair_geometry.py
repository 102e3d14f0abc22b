"""A common homography for the matches of two photos, and the baseline that it implies."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.checks.pair_geometry import common_homography, least_baseline

WIDTH, HEIGHT = 600, 800


def lens(focal: float = 0.8 * HEIGHT) -> np.ndarray:
    return np.array([[focal, 0, WIDTH / 2], [0, focal, HEIGHT / 2], [0, 0, 1.0]])


def turned(degrees: float, axis: int) -> np.ndarray:
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    rotation = np.eye(3)
    first, second = [k for k in range(3) if k != axis]
    rotation[first, first] = rotation[second, second] = cosine
    rotation[first, second], rotation[second, first] = -sine, sine
    return rotation


def seen_through(motion: np.ndarray, focal: float = 0.8 * HEIGHT) -> np.ndarray:
    return lens(focal) @ motion @ np.linalg.inv(lens(focal))


def carried(homography: np.ndarray, count: int = 80) -> np.ndarray:
    places = np.random.default_rng(1).uniform(0, (WIDTH, HEIGHT), (count, 2))
    there = np.hstack([places, np.ones((count, 1))]) @ homography.T
    return np.hstack([places, there[:, :2] / there[:, 2:]])


class TestCommonHomography:
    def test_all_on_one(self) -> None:
        true = seen_through(turned(9, 0) @ turned(4, 2))
        found, share = common_homography(carried(true), 1.0)
        np.testing.assert_allclose(found, true / true[2, 2], atol=1e-6)
        assert share == 1

    def test_slips_are_left_out(self) -> None:
        true = seen_through(turned(9, 0) @ turned(4, 2))
        matches = carried(true)
        matches[::4, 2:] = np.random.default_rng(2).uniform(0, WIDTH, (20, 2))
        found, share = common_homography(matches, 1.0)
        np.testing.assert_allclose(found, true / true[2, 2], atol=1e-6)
        assert share == pytest.approx(0.75)

    def test_two_planes_seen_from_two_places_have_none(self) -> None:
        near, far = (seen_through(np.eye(3) + np.outer([0.3, 0, 0], normal)) for normal in ([0, 0, 1], [0.8, 0, 0.6]))
        _, share = common_homography(np.vstack([carried(near, 50), carried(far, 50)]), 1.0)
        assert 0.5 <= share < 0.65

    def test_the_same_photo_twice(self) -> None:
        found, share = common_homography(carried(np.eye(3)), 1.0)
        np.testing.assert_allclose(found, np.eye(3), atol=1e-9)
        assert share == 1


class TestLeastBaseline:
    @pytest.mark.parametrize("focal", [0.5, 0.85, 2.0])
    def test_a_camera_that_only_turned(self, focal: float) -> None:
        turn = seen_through(turned(8, 1) @ turned(-5, 0) @ turned(30, 2), focal * HEIGHT)
        assert np.degrees(least_baseline(turn, WIDTH, HEIGHT)) < 0.7

    @pytest.mark.parametrize("direction", [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    def test_a_camera_that_moved(self, direction: list[float]) -> None:
        """Another focal length may explain some of it as turning, but not most."""
        motion = turned(3, 1) + 0.2 * np.outer(direction, [0, 0, 1])
        assert 0.1 < least_baseline(seen_through(motion), WIDTH, HEIGHT) < 0.22

    def test_it_grows_with_the_distance(self) -> None:
        found = [
            least_baseline(seen_through(np.eye(3) + np.outer([x, 0, 0], [0, 0, 1])), WIDTH, HEIGHT)
            for x in (0.0, 0.01, 0.03, 0.1)
        ]
        assert found[0] == pytest.approx(0, abs=1e-12)
        np.testing.assert_array_less(0, np.diff(found))

    def test_what_no_camera_does(self) -> None:
        assert np.isinf(least_baseline(np.zeros((3, 3)), WIDTH, HEIGHT))
