"""Marked edges as straight runs."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from origami.core.creases.ridge_runs import runs_of_edges

SIZE = 20
GRID = np.stack(np.meshgrid(np.arange(SIZE), np.arange(SIZE)), -1).reshape(-1, 2).astype(float)


def _edges(*lines: list[tuple[int, int]]) -> np.ndarray:
    """Edges along lines of grid places, in no particular order or direction."""
    edges = np.array([[y * SIZE + x for x, y in step] for line in lines for step in pairwise(line)])
    random = np.random.default_rng(0)
    edges = edges[random.permutation(len(edges))]
    turned = random.random(len(edges)) < 0.5
    edges[turned] = edges[turned, ::-1]
    return edges


def _runs(*lines: list[tuple[int, int]]) -> set[tuple[tuple[int, int], ...]]:
    """The runs found, as grid places, each from its lesser end."""
    found = [[tuple(place) for place in GRID[run].astype(int).tolist()] for run in runs_of_edges(GRID, _edges(*lines))]
    return {tuple(min(run, run[::-1])) for run in found}


def _across(y: int, start: int = 0, stop: int = 12) -> list[tuple[int, int]]:
    return [(x, y) for x in range(start, stop)]


def _up(x: int, start: int = 0, stop: int = 12) -> list[tuple[int, int]]:
    return [(x, y) for y in range(start, stop)]


def test_no_edges_make_no_runs():
    assert runs_of_edges(GRID, np.zeros((0, 2), int)) == []


def test_a_line_is_one_run_in_order():
    assert _runs(_across(3)) == {tuple(_across(3))}


def test_a_run_ends_at_a_corner_and_where_lines_meet():
    assert _runs(_across(3), _up(11, 3)) == {tuple(_across(3)), tuple(_up(11, 3))}
    cross = {tuple(_across(5, 0, 6)), tuple(_across(5, 5)), tuple(_up(5, 0, 6)), tuple(_up(5, 5))}
    assert _runs(_across(5), _up(5)) == cross


def test_a_ring_comes_apart_at_its_corners():
    ring = [*_across(2, 2, 9), *_up(8, 3, 9), *_across(8, 2, 8)[::-1], *_up(2, 2, 8)[::-1]]
    assert _runs(ring) == {tuple(_across(2, 2, 9)), tuple(_up(8, 2, 9)), tuple(_across(8, 2, 9)), tuple(_up(2, 2, 9))}


def test_steps_for_want_of_an_edge_along_the_line_are_no_corners():
    for steps in ([(1, 0), (0, 1)], [(1, 0), (1, 0), (0, 1)]):
        line = [(0, 0)]
        for number in range(15):
            step = steps[number % len(steps)]
            line.append((line[-1][0] + step[0], line[-1][1] + step[1]))
        assert _runs(line) == {tuple(line)}


def test_a_gentle_bend_is_none_and_a_bend_in_space_is():
    bent = [*_across(0, 0, 8), *((7 + 4 * k, k) for k in range(1, 4))]
    assert len(_runs(bent)) == 1
    space = np.column_stack([GRID, np.abs(GRID[:, 0] - 9)])
    assert [len(run) for run in runs_of_edges(space, _edges(_across(4, 0, 19)))] == [10, 10]
