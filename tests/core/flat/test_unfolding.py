"""A sheet on its way from folded to flat keeps its lengths and opens evenly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sheets
from origami.core.creases.creases import crease_figures
from origami.core.flat.unfolding import unfolded
from origami.core.numeric.triangles import directed_edges

SHARES = (0.2, 0.5, 0.9)


def ends(case):
    """A sheet's mesh, and its vertices folded and flat, both on the ground with the printed side up."""
    mesh, flat = sheets.mesh(case, 0.04)
    folded = mesh.vertices * [1, -1, -1]
    laid = np.c_[(flat - [sheets.WIDTH / 2, sheets.HEIGHT / 2]) * [1, -1], np.zeros(len(flat))]
    return mesh, folded - [0, 0, folded[:, 2].min()], laid


@pytest.mark.parametrize(
    ("case", "most"),
    [
        (sheets.two_folds(), 1e-7),
        (sheets.sharp_letter(), 1e-7),
        (sheets.cylinder(), 1e-3),  # the coarse mesh itself is off by that much
        (sheets.roll(), 2e-3),
        (sheets.cross(), 3e-4),  # no even opening keeps all lengths around a crossing
    ],
    ids=lambda case: getattr(case, "name", ""),
)
def test_lengths_stay(case, most):
    mesh, folded, flat = ends(case)
    for shape in unfolded(folded, flat, mesh.triangles, SHARES):
        edge = directed_edges(mesh.triangles)
        before, after = (np.linalg.norm(at[edge[:, 0]] - at[edge[:, 1]], axis=1) for at in (folded, shape))
        assert np.abs(after / before - 1).max() < most


def test_it_begins_folded_and_ends_flat():
    mesh, folded, flat = ends(sheets.sharp_letter())
    first, last = unfolded(folded, flat, mesh.triangles, (0.0, 1.0))
    np.testing.assert_allclose(first, folded, atol=1e-6)
    np.testing.assert_allclose(last, flat, atol=1e-6)


def test_all_folds_open_together():
    mesh, folded, flat = ends(sheets.sharp_letter())
    before = [crease.fold_angle for crease in crease_figures(replace(mesh, vertices=folded))]
    for share, shape in zip(SHARES, unfolded(folded, flat, mesh.triangles, SHARES), strict=True):
        after = [crease.fold_angle for crease in crease_figures(replace(mesh, vertices=shape))]
        np.testing.assert_allclose(after, np.multiply(before, 1 - share), atol=0.1)


def test_it_stays_on_the_ground_in_its_place():
    mesh, folded, flat = ends(sheets.cross())
    for share, shape in zip(SHARES, unfolded(folded, flat, mesh.triangles, SHARES), strict=True):
        assert shape[:, 2].min() == pytest.approx(0, abs=1e-12)
        blend = (1 - share) * folded + share * flat
        np.testing.assert_allclose(shape.mean(axis=0)[:2], blend.mean(axis=0)[:2], atol=1e-12)
        assert np.linalg.norm(shape - blend, axis=1).max() < 0.05


def test_the_order_of_the_shares_does_not_matter():
    mesh, folded, flat = ends(sheets.roll())
    one, other = unfolded(folded, flat, mesh.triangles, (0.2, 0.9)), unfolded(folded, flat, mesh.triangles, (0.9, 0.2))
    np.testing.assert_array_equal(one, other[::-1])


def test_a_single_triangle_opens():
    folded, flat = np.eye(3), np.array([[0.0, 0, 0], [np.sqrt(2), 0, 0], [np.sqrt(0.5), np.sqrt(1.5), 0]])
    (shape,) = unfolded(folded, flat, np.array([[0, 1, 2]]), (0.5,))
    np.testing.assert_allclose(np.linalg.norm(shape - np.roll(shape, 1, axis=0), axis=1), np.sqrt(2))
