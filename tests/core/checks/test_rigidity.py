"""Matches that contradict the cameras: exact distances, and which count as moved together."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.camera import Camera
from origami.core.checks.rigidity import contradicting_area, epipolar_distance
from origami.core.sparse_model import SparseModel

SIDE = 1000
CELL = 40
PAIR = np.array([[0, 1]])


def camera(x: float = 0.0, focal_length: float = 800.0, distortion: tuple[float, float] = (0.0, 0.0)) -> Camera:
    """Looks along z from (x, 0, 0)."""
    return Camera(
        f"at {x}",
        SIDE,
        750,
        focal_length,
        np.array([500.0, 375.0]),
        np.array(distortion),
        np.eye(3),
        np.array([-x, 0, 0]),
    )


def model_of(*cameras: Camera) -> SparseModel:
    none = np.zeros(0, np.int64)
    return SparseModel(cameras, np.zeros((0, 3)), np.zeros((0, 3), np.uint8), none, none, np.zeros((0, 2)))


@pytest.fixture
def matches() -> np.ndarray:
    """Two matches in each cell of a 10 x 10 grid, of a plane that two cameras side by side see."""
    column, row = np.meshgrid(np.arange(5, 15), np.arange(3, 13))
    first = ((np.stack([column.ravel(), row.ravel()], 1) + 0.5) * CELL).repeat(2, 0)
    first[1::2, 0] += 3
    return np.hstack([first, first - [80, 0]])


def of_one_pair(matches: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The result for matches between two cameras side by side."""
    return contradicting_area(model_of(camera(0), camera(1)), PAIR.repeat(len(matches), 0), matches)


def block(matches: np.ndarray, cells: int) -> np.ndarray:
    """Which matches are in the block of ``cells`` x ``cells`` in the grid's corner."""
    column, row = (matches[:, :2] // CELL).astype(int).T
    return (column < 5 + cells) & (row < 3 + cells)


class TestEpipolarDistance:
    def test_across_the_line_both_photos_share_the_error(self) -> None:
        pixels = np.array([[300.0, 200, 250, 200], [300, 200, 250, 206], [300, 200, 900, 194]])
        found = np.abs(epipolar_distance(camera(0), camera(1), pixels))
        np.testing.assert_allclose(found, [0, 6 / np.sqrt(2), 6 / np.sqrt(2)], atol=1e-9)

    def test_two_focal_lengths(self) -> None:
        first, second = camera(0, 800), camera(1, 600)
        pixels = np.array([[500.0, 375, 400, 375 + 10]])
        found = epipolar_distance(first, second, pixels)
        np.testing.assert_allclose(np.abs(found), 10 / 600 / np.hypot(1 / 800, 1 / 600), atol=1e-9)

    def test_the_two_sides_of_a_line_have_two_signs(self) -> None:
        above, below = epipolar_distance(camera(0), camera(1), np.array([[300.0, 200, 250, 194], [300, 200, 250, 206]]))
        assert above == pytest.approx(-below)

    def test_the_length_of_the_baseline_does_not_matter(self) -> None:
        pixels = np.array([[310.0, 220, 250, 229]])
        near, far = (epipolar_distance(camera(0), camera(x), pixels) for x in (0.01, 100))
        np.testing.assert_allclose(near, far, rtol=1e-9)

    def test_points_of_the_world_lie_on_their_lines(self) -> None:
        random = np.random.default_rng(0)
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        first = camera(0, distortion=(0.05, -0.02))
        second = Camera(
            "b",
            SIDE,
            750,
            700,
            np.array([510.0, 370]),
            np.array([-0.03, 0.01]),
            turn,
            turn @ [0.5, 0.2, -0.1] + [0, 0, 9],
        )
        points = random.uniform([-1, -1, 4], [1, 1, 6], (50, 3))
        points = points[second.to_camera_frame(points)[:, 2] > 1]
        assert len(points) > 10
        pixels = np.hstack([first.project(points), second.project(points)])
        near = np.abs(pixels[:, 2:] - second.principal_point).max(1) < 600
        np.testing.assert_allclose(epipolar_distance(first, second, pixels[near]), 0, atol=1e-4)


class TestContradictingArea:
    def test_nothing_moved(self, matches: np.ndarray) -> None:
        contradicting, common = of_one_pair(matches)
        np.testing.assert_array_equal(contradicting, 0)
        np.testing.assert_array_equal(common, [[0, 100], [100, 0]])

    def test_a_part_that_moved_counts_with_its_cells(self, matches: np.ndarray) -> None:
        moved = block(matches, 6)
        matches[moved, 2:] += [15, 20]
        contradicting, common = of_one_pair(matches)
        np.testing.assert_array_equal(contradicting, [[0, 36], [36, 0]])
        np.testing.assert_array_equal(common, [[0, 100], [100, 0]])

    def test_a_part_that_turned_counts_too(self, matches: np.ndarray) -> None:
        moved = block(matches, 6)
        matches[moved, 2:] = matches[moved, 2:] @ [[0.98, 0.2], [-0.2, 0.98]] + [10, 60]
        contradicting, _ = of_one_pair(matches)
        assert contradicting[0, 1] > 30

    def test_less_than_the_limit_off_its_line(self, matches: np.ndarray) -> None:
        matches[:, 3] += 2.0 * np.sqrt(2) - 0.01
        contradicting, _ = of_one_pair(matches)
        np.testing.assert_array_equal(contradicting, 0)
        matches[:, 3] += 0.02
        contradicting, _ = of_one_pair(matches)
        assert contradicting[0, 1] == 100

    def test_slips_of_the_matcher_are_alone(self, matches: np.ndarray) -> None:
        slips = block(matches, 6)
        matches[slips, 2:] = np.random.default_rng(0).uniform(0, 700, (72, 2))
        contradicting, _ = of_one_pair(matches)
        np.testing.assert_array_equal(contradicting, 0)

    def test_a_word_taken_for_the_same_word_elsewhere_is_one_cell(self, matches: np.ndarray) -> None:
        word = np.random.default_rng(0).uniform(CELL * 8 + 1, CELL * 9 - 1, (60, 2))
        matches = np.vstack([matches, np.hstack([word, np.add(word, (100, 200))])])
        contradicting, common = of_one_pair(matches)
        np.testing.assert_array_equal(contradicting, 0)
        assert common[0, 1] == 100

    def test_print_that_repeats_is_right_beside_where_it_is_wrong(self, matches: np.ndarray) -> None:
        """Tiles: each cell of a block has two matches that are off by a tile, and three correct ones."""
        tile = np.add(matches[block(matches, 6)], (0, 0, 90, 40))
        beside = [np.add(matches[block(matches, 6)], (5, across, 5, across)) for across in (5, -5)]
        everything = np.vstack([tile, np.add(tile, (-5, -5, -5, -5)), *beside, matches])
        contradicting, common = of_one_pair(everything)
        np.testing.assert_array_equal(contradicting, 0)
        assert common[0, 1] == 100

    def test_small_slips_among_right_matches_are_no_company(self, matches: np.ndarray) -> None:
        """A blurred photo: a third of the matches, everywhere, mistake a letter for the next, three pixels away."""
        slips = np.add(matches, (3, 3, 3, 6))
        everything = np.vstack([slips, matches, np.add(matches, (-3, -3, -3, -3))])
        contradicting, _ = of_one_pair(everything)
        np.testing.assert_array_equal(contradicting, 0)

    def test_half_of_a_cell_is_not_enough(self, matches: np.ndarray) -> None:
        matches[::2, 2:] += [15, 20]
        contradicting, _ = of_one_pair(matches)
        np.testing.assert_array_equal(contradicting, 0)

    def test_a_match_alone_in_its_cell_says_nothing(self, matches: np.ndarray) -> None:
        matches[:, 2:] += [15, 20]
        some = np.vstack([matches[:100], matches[100::2]])
        contradicting, common = of_one_pair(some)
        np.testing.assert_array_equal(contradicting, [[0, 50], [50, 0]])
        np.testing.assert_array_equal(common, [[0, 50], [50, 0]])

    def test_what_moved_counts_though_a_few_of_its_matches_slip_back(self, matches: np.ndarray) -> None:
        moved = np.add(matches, (0, 0, 15, 20))
        everything = np.vstack([moved, np.add(moved, (4, 4, 4, 4)), np.add(matches, (-4, -4, -4, -4))])
        contradicting, common = of_one_pair(everything)
        np.testing.assert_array_equal(contradicting, common)

    def test_each_pair_of_cameras_on_its_own(self, matches: np.ndarray) -> None:
        moved = matches.copy()
        moved[:, 3] += 20
        pairs = np.vstack([PAIR.repeat(len(matches), 0), np.array([[0, 2]]).repeat(len(moved), 0)])
        contradicting, common = contradicting_area(
            model_of(camera(0), camera(1), camera(1)), pairs, np.vstack([matches, moved])
        )
        np.testing.assert_array_equal(contradicting, [[0, 0, 100], [0, 0, 0], [100, 0, 0]])
        np.testing.assert_array_equal(common, [[0, 100, 100], [100, 0, 0], [100, 0, 0]])

    def test_no_matches(self) -> None:
        contradicting, common = contradicting_area(
            model_of(camera(0), camera(1)), np.zeros((0, 2), np.int64), np.zeros((0, 4))
        )
        np.testing.assert_array_equal(contradicting, np.zeros((2, 2)))
        np.testing.assert_array_equal(common, np.zeros((2, 2)))
