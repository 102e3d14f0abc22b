"""Regions that lie flush along a side are the parts of one folded sheet."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.polygon import filled_polygon
from origami.core.paper.joined_parts import joined, lie_flush
from origami.core.paper.sheet_hypotheses import COARSE, Hypothesis

SHAPE = (200, 200)


def rectangle(left: float, top: float, right: float, bottom: float, turn: float = 0.0) -> Hypothesis:
    """Coarse cells, turned by degrees about the middle of the map."""
    corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]], float) - 100
    angle = np.radians(turn)
    corners = corners @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) + 100
    return Hypothesis(corners * COARSE, filled_polygon(corners, SHAPE))


UPPER, LOWER = (60, 50, 140, 98), (60, 99, 140, 150)


@pytest.mark.parametrize("turn", [0.0, 20.0, 45.0])
def test_halves_beside_a_fold_are_flush_and_join_to_the_sheet(turn):
    halves = [rectangle(*part, turn) for part in (UPPER, LOWER)]
    flush = lie_flush(halves)
    assert flush[0, 1] and flush[1, 0]
    assert not flush[0, 0]
    whole = rectangle(60, 50, 140, 150, turn).mask
    found = joined(*halves).mask
    assert (found & whole).sum() / (found | whole).sum() > 0.97


def test_a_third_is_flush_with_the_rest():
    assert lie_flush([rectangle(60, 50, 140, 82), rectangle(60, 83, 140, 150)])[0, 1]


@pytest.mark.parametrize(
    "other",
    [
        (60, 110, 140, 160),  # apart
        (110, 99, 190, 150),  # shifted along the side
        (85, 99, 115, 150),  # a narrow one at the middle of the side
        (20, 30, 180, 170),  # one is within the other
    ],
    ids=["apart", "shifted", "narrow", "nested"],
)
def test_sheets_that_share_no_whole_side_are_not_flush(other):
    assert not lie_flush([rectangle(*UPPER), rectangle(*other)]).any()


def test_sheets_that_touch_aslant_are_not_flush():
    assert not lie_flush([rectangle(60, 50, 140, 90), rectangle(70, 104, 150, 150, 12.0)]).any()
