"""Polygons that bound one area, and those that do not."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.polygon import signed_area
from origami.core.numeric.simple_polygon import is_simple, without_loops

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


def test_a_simple_polygon_has_no_loops_to_lose() -> None:
    ring = np.array(RING)
    assert without_loops(ring) is ring


def test_the_shorter_part_of_a_crossing_outline_goes() -> None:
    """The edge of a book's page, followed a little into the gutter and back across itself."""
    outline = np.array([(0, 0), (100, 0), (100, 150), (4, 150), (-3, 148), (4, 147), (0, 140)], float)
    crossing = np.array([(0, 0), (100, 0), (100, 150), (0, 150), (6, 144), (6, 148), (0, 146)], float)
    assert without_loops(outline) is outline
    simple = without_loops(crossing)
    assert is_simple(simple)
    assert abs(signed_area(simple)) == pytest.approx(100 * 150, rel=2e-3)


@pytest.mark.parametrize("seed", range(40))
def test_nothing_that_remains_meets_itself(seed: int) -> None:
    random = np.random.default_rng(seed)
    corners = random.integers(0, 7, (random.integers(3, 30), 2)).astype(float)
    simple = without_loops(corners)
    assert len(simple) < 3 or is_simple(simple)
