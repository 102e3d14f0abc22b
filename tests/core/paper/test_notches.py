"""Inward corners of outlines, and what is left of two papers that overlap."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.polygon import filled_polygon, signed_area
from origami.core.paper.notches import cut_at_notches, notches, sharpness

SHAPE = (200, 300)
SHEET = np.array([[40.0, 30], [180, 40], [170, 180], [30, 170]])
# another paper of the same colour sticks out on the right, beyond one side of the sheet
BESIDE = np.array([[40.0, 30], [180, 40], [177.0, 82], [270, 89], [267, 131], [173.6, 124], [170, 180], [30, 170]])
# and from under a corner of the sheet, beyond two of its sides
BEHIND = np.array([[40.0, 30], [130, 36.4], [134, 5], [240, 20], [230, 110], [175, 103], [170, 180], [30, 170]])


def in_common(one, other):
    return (one & other).sum() / (one | other).sum()


@pytest.mark.parametrize("outline", [BESIDE, BEHIND])
def test_one_of_the_cuts_is_the_sheet(outline):
    assert signed_area(outline) > 0  # clockwise on screen
    sheet, both = filled_polygon(SHEET, SHAPE), filled_polygon(outline, SHAPE)
    cut = cut_at_notches(both, outline)
    assert max(in_common(each, sheet) for each in cut) > 0.97
    assert all((each & ~both).sum() == 0 for each in cut)


def test_the_corners_of_a_notch_tell_where_the_sides_go():
    found = notches(BESIDE)
    assert len(found) == 2
    for notch in found:
        assert notch.degrees == pytest.approx(90, abs=15)
        assert np.linalg.norm(BESIDE - notch.place, axis=1).min() < 4
        for direction in (notch.before, notch.after):
            assert np.linalg.norm(direction) == pytest.approx(1)


def test_folds_curls_and_round_corners_are_no_notches():
    folded = np.array([[40.0, 30], [180, 40], [160, 100], [170, 180], [30, 170], [55, 95]])
    angle = np.linspace(0, 2 * np.pi, 300, endpoint=False)[:, None]
    round_ = 100 + 60 * np.hstack([np.cos(angle), np.sin(angle)]) * (1 + 0.05 * np.cos(5 * angle))
    for outline in (SHEET, folded, round_):
        assert signed_area(outline) > 0
        assert sharpness(outline) == 0
        assert cut_at_notches(filled_polygon(outline, SHAPE), outline) == []


def test_an_outline_in_more_points_is_as_sharp():
    fine = np.concatenate(
        [np.linspace(a, b, 40)[:-1] for a, b in zip(BESIDE, np.roll(BESIDE, -1, axis=0), strict=True)]
    )
    assert sharpness(fine) == pytest.approx(sharpness(BESIDE), abs=0.1)
    assert sharpness(BESIDE) > 0.3
