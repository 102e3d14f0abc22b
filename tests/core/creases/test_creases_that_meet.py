"""Found creases end short of each other where they meet, and are lengthened."""

from __future__ import annotations

import numpy as np
from origami.core.creases.crease_ends import extend_to_each_other

ACROSS = np.array([[0.0, 0.5], [1.0, 0.5]])


def test_creases_of_a_cross_meet_in_its_middle():
    arms = [
        np.array([[0.5, 0.0], [0.5, 0.47]]),
        np.array([[0.5, 1.0], [0.5, 0.53]]),
        np.array([[0.0, 0.5], [0.48, 0.5]]),
        np.array([[0.52, 0.5], [1.0, 0.5]]),
    ]
    longer = extend_to_each_other(arms, reach=0.05)
    ends = [arms[0][0], arms[1][0], arms[2][0], arms[3][1]]
    for arm, outer in zip(longer, ends, strict=True):
        np.testing.assert_allclose(arm[np.linalg.norm(arm - outer, axis=1).argmin()], outer)
        np.testing.assert_allclose(arm[np.linalg.norm(arm - outer, axis=1).argmax()], [0.5, 0.5], atol=1e-12)


def test_a_crease_that_ends_far_from_another_stays():
    short = np.array([[0.4, 0.0], [0.4, 0.44]])
    np.testing.assert_array_equal(extend_to_each_other([ACROSS, short], reach=0.05)[1], short)


def test_a_crease_beyond_the_end_of_another_stays():
    beside = np.array([[1.2, 0.0], [1.2, 0.47]])
    np.testing.assert_array_equal(extend_to_each_other([ACROSS, beside], reach=0.05)[1], beside)


def test_creases_side_by_side_stay():
    other = np.array([[0.0, 0.52], [0.9, 0.53]])
    for line, longer in zip((ACROSS, other), extend_to_each_other([ACROSS, other], reach=0.05), strict=True):
        np.testing.assert_array_equal(longer, line)


def test_a_crease_that_already_meets_another_is_not_lengthened():
    meeting = np.array([[0.4, 0.0], [0.4, 0.5]])
    longer = extend_to_each_other([ACROSS, meeting], reach=0.05)
    np.testing.assert_allclose(longer[1], meeting, atol=1e-12)
    np.testing.assert_array_equal(longer[0], ACROSS)
