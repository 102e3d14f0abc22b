"""What one photo alone shows is not confirmed; what most show is, however sharp they are."""

import numpy as np
from origami.core.fusion.confirmed_prints import confirmed_prints
from scipy import ndimage

SHAPE = (80, 60)
_random = np.random.default_rng(3)


def lines():
    """The mean print of cells with lines of text in the upper half, blank below."""
    print_ = np.zeros(SHAPE, np.float32)
    print_[4:40:4, 5:55] = 1 + 0.3 * _random.standard_normal((9, 50))
    print_[6:40:4, 5:55] = -1
    return print_


def photos_of(print_, count=5):
    return np.stack([print_ + 0.05 * _random.standard_normal(SHAPE).astype(np.float32) for _ in range(count)])


def test_the_edge_of_a_hand_in_one_photo_is_not_confirmed():
    prints, known = photos_of(lines()), np.ones((5, *SHAPE), bool)
    prints[2, 60, 20:50] += 1.0
    prints[2, 62, 20:50] -= 1.0
    confirmed = confirmed_prints(prints, known)
    assert confirmed[2, 60, 25:45].max() < 0.1
    assert np.delete(confirmed, 2, axis=0).min() > 0.9
    assert confirmed[2, :50].min() > 0.9


def test_the_only_sharp_photo_is_confirmed_by_blurred_ones():
    sharp = lines()
    prints = photos_of(ndimage.uniform_filter1d(0.5 * sharp, 5, axis=1))
    prints[1] = sharp
    assert confirmed_prints(prints, np.ones((5, *SHAPE), bool))[1, 8:36, 10:50].min() > 0.9


def test_two_photos_cannot_say_which_of_them_is_wrong():
    prints, known = photos_of(lines(), 2), np.ones((2, *SHAPE), bool)
    prints[1, 60, 20:50] += 1.0
    np.testing.assert_array_equal(confirmed_prints(prints, known), 1)
