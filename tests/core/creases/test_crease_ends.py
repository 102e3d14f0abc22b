"""Creases end at the paper's edge."""

from __future__ import annotations

import numpy as np
from origami.core.creases.crease_ends import cut_to_outline, extend_to_outline

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
NOTCHED = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.6, 1.0], [0.6, 0.3], [0.4, 0.3], [0.4, 1.0], [0.0, 1.0]])


def test_extension_stops_at_the_outline_and_only_if_it_is_near():
    extended = extend_to_outline(np.array([[0.05, 0.5], [0.6, 0.5]]), SQUARE, 0.1)
    np.testing.assert_allclose(extended, [[0.0, 0.5], [0.6, 0.5]], atol=1e-12)


def test_a_crease_is_cut_where_it_leaves_the_paper():
    (piece,) = cut_to_outline(np.array([[0.5, 0.5], [0.5, 1.7]]), SQUARE)
    np.testing.assert_allclose(piece, [[0.5, 0.5], [0.5, 1.0]])
    (whole,) = cut_to_outline(np.array([[-1.0, 0.2], [3.0, 0.2]]), SQUARE)
    np.testing.assert_allclose(whole, [[0.0, 0.2], [1.0, 0.2]])
    (inside,) = cut_to_outline(np.array([[0.1, 0.2], [0.8, 0.9]]), SQUARE)
    np.testing.assert_allclose(inside, [[0.1, 0.2], [0.8, 0.9]])


def test_a_notch_leaves_two_pieces_and_what_lies_outside_none():
    left, right = cut_to_outline(np.array([[-0.2, 0.8], [1.2, 0.8]]), NOTCHED)
    np.testing.assert_allclose([left, right], [[[0, 0.8], [0.4, 0.8]], [[0.6, 0.8], [1, 0.8]]])
    assert cut_to_outline(np.array([[0.45, 0.5], [0.55, 0.9]]), NOTCHED) == []
    assert cut_to_outline(np.array([[2.0, 0.0], [2.0, 1.0]]), SQUARE) == []


def test_a_ragged_edge_does_not_shred_a_crease():
    ragged = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.504, 1.0], [0.5, 0.3], [0.496, 1.0], [0.0, 1.0]])
    (piece,) = cut_to_outline(np.array([[0.0, 0.8], [1.0, 0.8]]), ragged)
    np.testing.assert_allclose(piece, [[0.0, 0.8], [1.0, 0.8]])
