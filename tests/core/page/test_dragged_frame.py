"""The handles of a page's frame, and what it cuts off."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.page.dragged_frame import HANDLES, cut_off, drag_handle, handles_of

WIDTH, HEIGHT = 210.0, 297.0
PAGE = np.array([[0, 0], [WIDTH, 0], [WIDTH, HEIGHT], [0, HEIGHT]])


@pytest.mark.parametrize("handle", range(4))
def test_a_corner_goes_where_it_is_dragged_and_no_other(handle):
    moved = drag_handle(PAGE, handle, np.array([33.0, 44.0]))
    assert moved[handle].tolist() == [33, 44]
    others = np.delete(np.arange(4), handle)
    np.testing.assert_array_equal(moved[others], PAGE[others])


@pytest.mark.parametrize(
    ("handle", "cut"), [(4, (5, 0, 0, 0)), (5, (0, 5, 0, 0)), (6, (0, 0, 5, 0)), (7, (0, 0, 0, 5))]
)
def test_a_side_moves_across_itself_and_stays_as_it_was(handle, cut):
    inward = handles_of(PAGE)[handle] + [(0, 5), (-5, 0), (0, -5), (5, 0)][handle - 4]
    along = np.array([40.0, 0]) if handle in (4, 6) else np.array([0, 40.0])
    moved = drag_handle(PAGE, handle, inward + along)
    np.testing.assert_allclose(cut_off(moved, WIDTH, HEIGHT), cut, atol=1e-12)


def test_a_slanting_side_stays_slanting():
    slanted = drag_handle(PAGE, 0, np.array([0.0, 10.0]))
    moved = drag_handle(slanted, 4, handles_of(slanted)[4] + (0, 7))
    np.testing.assert_allclose(moved[:2] - slanted[:2], [[0, 7], [0, 7]])
    np.testing.assert_allclose(cut_off(moved, WIDTH, HEIGHT), [12, 0, 0, 0])


def test_a_frame_beyond_the_page_adds():
    assert cut_off(PAGE + np.array([3, 0]), WIDTH, HEIGHT).tolist() == [0, -3, 0, 3]
    assert len(handles_of(PAGE)) == HANDLES
