"""The strips beside an outline on a map."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.paper.edge_strips import REACH, edge_strips, even_steps, steps_beyond

SQUARE = np.array([[60.0, 40.0], [180.0, 40.0], [180.0, 140.0], [60.0, 140.0]])


def a_map() -> np.ndarray:
    color = np.full((200, 240, 3), (30.0, 0.0, 0.0), np.float32)
    color[40:140, 60:180] = (90.0, 2.0, -4.0)
    return color


def test_inside_and_outside_have_their_colours_and_the_step_is_their_difference():
    strips = edge_strips(a_map(), SQUARE)
    assert np.allclose(np.median(strips.inside, axis=(0, 1)), (90, 2, -4), atol=1e-4)
    assert np.allclose(np.median(strips.outside, axis=(0, 1)), (30, 0, 0), atol=1e-4)
    assert np.allclose(np.median(strips.step, axis=0), (-60, -2, 4), atol=1e-3)
    assert strips.profile.shape[1] == 2 * REACH + 1


def test_a_step_a_cell_or_two_off_the_outline_is_found():
    moved = edge_strips(a_map(), SQUARE + np.array([0.0, 1.5]))
    assert np.quantile(np.linalg.norm(moved.step, axis=1), 0.1) > 55


def test_each_place_belongs_to_its_side():
    strips = edge_strips(a_map(), SQUARE)
    for side, (axis, value) in zip(strips.sides(), side_lines(strips.rectangle), strict=True):
        assert np.abs(strips.places[side, axis] - value).max() < 1.5
    assert sum(side.sum() for side in strips.sides()) == len(strips.places)


def side_lines(rectangle: np.ndarray) -> list[tuple[int, float]]:
    """Of each side of an upright rectangle the axis that it crosses, and where."""
    ends = zip(rectangle, np.roll(rectangle, -1, axis=0), strict=True)
    return [(int(np.abs(end - start).argmin()), float(start[np.abs(end - start).argmin()])) for start, end in ends]


def test_a_large_outline_has_no_more_places_than_are_needed():
    color = np.zeros((900, 900, 3), np.float32)
    large = np.array([[20.0, 20.0], [880.0, 20.0], [880.0, 880.0], [20.0, 880.0]])
    assert len(edge_strips(color, large).places) == pytest.approx(240, abs=2)


def test_a_speck_is_too_small():
    assert edge_strips(a_map(), 100 + 0.02 * SQUARE) is None


def test_strong_steps_count_little_more_than_clear_ones():
    weak, strong = np.linalg.norm(even_steps(np.array([[9.0, 0, 0], [99.0, 0, 0]])), axis=1)
    assert weak == pytest.approx(0.9)
    assert strong == pytest.approx(0.99)


def test_no_edge_goes_on_beyond_a_sheets_corners():
    assert np.abs(steps_beyond(a_map(), SQUARE)).max() < 0.05


@pytest.mark.parametrize("corners", [SQUARE, SQUARE[::-1]])
def test_two_edges_go_on_where_a_sheet_is_cut(corners):
    cut = corners.copy()
    cut[:, 1] = np.minimum(cut[:, 1], 100)
    beyond = steps_beyond(a_map(), cut)
    clear = np.linalg.norm(beyond, axis=2) > 0.9
    assert clear.sum() == 2
    # they continue beyond the corners of the cut, from paper to table
    ends = np.stack([cut, np.roll(cut, -1, axis=0)], axis=1)
    assert (ends[clear][:, 1] == 100).all()
    assert (beyond[clear][:, 0] < 0).all()


def test_edges_that_leave_the_map_say_nothing():
    corners = np.array([[2.0, 2.0], [238.0, 2.0], [238.0, 198.0], [2.0, 198.0]])
    assert np.array_equal(steps_beyond(a_map(), corners), np.zeros((4, 2, 3)))
