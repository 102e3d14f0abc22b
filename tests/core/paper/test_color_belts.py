"""Whether a region and its surroundings are coloured alike along its edge."""

from __future__ import annotations

import numpy as np
from origami.core.paper.color_belts import ColorBelts

SHAPE = (120, 120)
EVERYWHERE = np.ones(SHAPE, bool)


def chequered() -> np.ndarray:
    row, column = np.indices(SHAPE) // 8
    color = np.zeros((*SHAPE, 3), np.float32)
    color[..., 0] = 50 + 15 * (row % 2) + 15 * (column % 2)
    color[..., 1] = 40 - 20 * (row % 2) - 20 * (column % 2)
    return color


def square(low: int, high: int) -> np.ndarray:
    mask = np.zeros(SHAPE, bool)
    mask[low:high, low:high] = True
    return mask


def test_squares_of_a_cloth_are_like_those_beside_them():
    assert ColorBelts(chequered(), EVERYWHERE).difference(square(24, 96)) < 0.1


def test_a_sheet_on_the_cloth_is_not():
    color, sheet = chequered(), square(24, 96)
    color[sheet] = [90, 0, 5]
    assert ColorBelts(color, EVERYWHERE).difference(sheet) > 0.5


def test_white_on_white_is_alike_and_colours_without_any_in_common_are_unlike():
    color = np.zeros((*SHAPE, 3), np.float32)
    color[..., 0] = 90
    assert ColorBelts(color, EVERYWHERE).difference(square(40, 80)) < 1e-6
    color[square(40, 80)] = [10, 60, 60]
    assert ColorBelts(color, EVERYWHERE).difference(square(40, 80)) > 0.999


def test_what_no_photo_shows_does_not_count():
    color = np.zeros((*SHAPE, 3), np.float32)
    color[~square(40, 80)] = [80, 0, 0]
    assert ColorBelts(color, square(40, 80)).difference(square(40, 80)) == 0
