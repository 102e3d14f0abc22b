"""Lines in a picture have the right place and width."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.line_drawing import draw_line


def drawn(line: list[tuple[float, float]], width: float, size: tuple[int, int] = (40, 60)) -> np.ndarray:
    picture = np.zeros((*size, 3), np.float32)
    draw_line(picture, np.array(line), (100, 50, 0), width)
    return picture


def test_a_level_line_covers_whole_rows() -> None:
    picture = drawn([(-5, 20), (70, 20)], 4)
    np.testing.assert_allclose(picture[18:22], np.broadcast_to(np.float32([100, 50, 0]), (4, 60, 3)))
    assert picture[:18].max() == 0
    assert picture[22:].max() == 0


def test_half_covered_pixels_are_half_as_bright() -> None:
    picture = drawn([(-5, 20.5), (70, 20.5)], 2)
    np.testing.assert_allclose(picture[18:23, 30, 0], [0, 50, 100, 50, 0])


def test_a_slanted_line_has_its_length_and_width() -> None:
    start, end = np.array([10.2, 8.7]), np.array([47.3, 31.9])
    area = drawn([tuple(start), tuple(end)], 3)[..., 0].sum() / 100
    assert area == pytest.approx(3 * np.linalg.norm(end - start) + np.pi * 1.5**2, rel=0.03)


def test_corners_are_not_drawn_twice_and_what_lies_outside_not_at_all() -> None:
    there_and_back = drawn([(10, 10), (50, 30), (10, 10)], 3)
    np.testing.assert_array_equal(there_and_back, drawn([(10, 10), (50, 30)], 3))
    assert drawn([(100, 100), (200, 300)], 3).max() == 0
    assert drawn([(20, 20), (20, 20)], 4).max() == 100
