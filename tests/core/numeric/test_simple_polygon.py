"""Polygons that bound one area, and those that do not."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.simple_polygon import is_simple

SQUARE = [(0, 0), (10, 0), (10, 10), (0, 10)]
RING = [(np.cos(angle), np.sin(angle)) for angle in np.linspace(0, 2 * np.pi, 200, endpoint=False)]


@pytest.mark.parametrize(
    "corners",
    [
        SQUARE,
        SQUARE[::-1],
        [(0, 0), (5, 0), (10, 0), (10, 10), (5, 10), (0, 10)],
        [(0, 0), (10, 0), (10, 10), (5, 1), (0, 10)],
        [(1, 1), (4, 1), (2, 5)],
        RING,
    ],
)
def test_simple(corners: list[tuple[float, float]]) -> None:
    assert is_simple(np.array(corners, float))
    assert is_simple(np.array(corners, float) * 1e3 + 4e3)


@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0), (10, 10), (10, 0), (0, 10)],
        [*SQUARE, (0, 0)],
        [(0, 0), (10, 0), (10, 0), (10, 10)],
        [(0, 0), (10, 0), (10, 10), (5, 0), (0, 10)],
        [(0, 0), (10, 0), (5, 0)],
        [(0, 0), (10, 0), (20, 0), (10, 0), (10, 10)],
        [RING[0], RING[100], *RING[1:100], *RING[101:]],
    ],
)
def test_not_simple(corners: list[tuple[float, float]]) -> None:
    assert not is_simple(np.array(corners, float))
