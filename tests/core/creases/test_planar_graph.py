"""Splitting straight segments where they meet, the faces between them, and merging near nodes."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.creases.planar_graph import arrangement, inner_faces, line_crossings, parts, without_short_edges
from origami.core.numeric.polygon import signed_area

SQUARE = np.array([[[0, 0], [4, 0]], [[4, 0], [4, 4]], [[4, 4], [0, 4]], [[0, 4], [0, 0]]], float)


def graph_of(*segments):
    return arrangement(np.concatenate([SQUARE, np.array(segments, float).reshape(-1, 2, 2)]), 1e-9)


def test_crossing_touching_and_overlapping_segments_are_split():
    graph = graph_of([[0, 1], [4, 1]], [[1, 1], [1, 3]], [[2, 0], [2, 4]], [[1, 1], [3, 1]])
    ends = np.sort(graph.nodes[graph.edges].round(9), axis=1)
    on_row = graph.edges[(graph.nodes[graph.edges][..., 1] == 1).all(axis=1)]
    assert sorted(graph.nodes[on_row][..., 0].min(axis=1).tolist()) == [0, 1, 2, 3]
    assert len(graph.nodes) == 12
    assert len(np.unique(ends.reshape(len(ends), 4), axis=0)) == len(graph.edges) == 15
    # where two segments overlap the first one counts
    assert set(graph.segment[(graph.nodes[graph.edges][..., 1] == 1).all(axis=1)]) == {4}


def test_faces_run_counter_clockwise_with_the_second_axis_down():
    graph = graph_of([[0, 1], [4, 1]], [[1, 1], [1, 4]])
    faces = inner_faces(graph)
    assert sorted(-signed_area(graph.nodes[face]) for face in faces) == pytest.approx([3, 4, 9])


def test_parts_that_do_not_hang_together():
    graph = graph_of([[1, 1], [2, 2]], [[1, 2], [2, 1]])
    part = parts(graph)
    assert len(np.unique(part)) == 2
    assert len(np.unique(part[graph.edges], axis=0)) == 2


def test_line_crossings_are_distances_along_the_first():
    first, second = np.array([[[1, 0], [3, 0]]], float), np.array([[[2, 1], [2, 5]], [[0, 1], [9, 1]]], float)
    distance = line_crossings(first, second)
    assert distance[0, 0] == pytest.approx(1)
    assert np.isnan(distance[0, 1])


def test_short_edges_are_drawn_together_and_the_border_stays():
    graph = graph_of([[0, 0.1], [4, 3.9]], [[2, 0], [2.1, 4]], [[1.9, 4], [2.2, 0]])
    border = graph.segment < 4
    corners = np.isin(graph.nodes, [0, 4]).all(axis=1)
    small, faces = without_short_edges(graph, inner_faces(graph), 0.5, border, corners)
    # the diagonal runs into the corners, the two lines that cross it are one
    assert len(small.nodes) == 7
    assert len(faces) == 4
    assert sum(-signed_area(small.nodes[face]) for face in faces) == pytest.approx(16)
    assert {tuple(corner) for corner in SQUARE[:, 0]} <= {tuple(node) for node in small.nodes}
    length = np.linalg.norm(np.subtract(*small.nodes[small.edges].swapaxes(0, 1)), axis=1)
    assert length.min() >= 0.5
