"""Length and fold angle of creases, on sheets with known fold angles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sheets
from origami.core.creases.creases import crease_figures

# Radians as in `sheets`; there a positive turn is a mountain as seen from the printed side.
FOLDED = {
    sheets.one_fold: [0.6],
    sheets.two_folds: [0.7, -0.6],
    sheets.three_folds: [0.5, -0.7, 0.6],
    sheets.oblique_fold: [0.7],
}
# Flat ends of lines that are not rulings, some near the paper's edge.
ACROSS_A_CURL = [
    ((0.05, 0.2), (0.6, 0.75)),
    ((0.0, 0.5), (0.7, 0.5)),
    ((0.35, 0.0), (0.35, 1.0)),
    ((0.1, 0.9), (0.65, 0.3)),
    ((0.0, 0.12), (0.7, 0.2)),
    ((0.08, 0.0), (0.02, 1.0)),
]


@pytest.mark.parametrize("make", FOLDED)
def test_fold_angles_of_plane_parts_are_exact(make):
    mesh, _ = sheets.mesh(make())
    angles = [figures.fold_angle for figures in crease_figures(mesh)]
    np.testing.assert_allclose(angles, -np.degrees(FOLDED[make]), atol=0.01)


def test_curled_paper_is_not_taken_for_fold():
    mesh, _ = sheets.mesh(sheets.curved_folds())
    angles = [figures.fold_angle for figures in crease_figures(mesh)]
    np.testing.assert_allclose(angles, -np.degrees([0.5, -0.45]), atol=0.5)


@pytest.mark.parametrize("make", [sheets.cylinder, sheets.cone])
@pytest.mark.parametrize("ends", ACROSS_A_CURL)
def test_line_across_a_curl_is_no_fold(make, ends):
    mesh, _ = sheets.mesh(replace(make(), creases=(np.array(ends),)))
    assert abs(crease_figures(mesh)[0].fold_angle) < 1


def test_folds_around_a_vertex_have_the_signs_that_paper_allows():
    mesh, _ = sheets.mesh(sheets.cross())
    angles = np.array([figures.fold_angle for figures in crease_figures(mesh)])
    np.testing.assert_allclose(np.abs(angles), [41, 11, 42, 11], atol=0.5)
    assert abs(np.sign(angles).sum()) == 2  # Maekawa: three of one kind, one of the other


def test_from_behind_mountains_are_valleys():
    mesh, _ = sheets.mesh(sheets.two_folds())
    seen = [figures.fold_angle for figures in crease_figures(mesh)]
    behind = [figures.fold_angle for figures in crease_figures(replace(mesh, triangles=mesh.triangles[:, ::-1]))]
    np.testing.assert_allclose(behind, np.negative(seen), atol=1e-9)


def test_nearly_closed_fold():
    sheet = sheets._bent("closed", 0, sheets._straight, ((0.0, np.radians(170)),))
    mesh, _ = sheets.mesh(sheet)
    assert crease_figures(mesh)[0].fold_angle == pytest.approx(-170, abs=0.01)


def test_length_is_measured_along_the_crease():
    sheet = sheets.oblique_fold()
    mesh, _ = sheets.mesh(sheet)
    (figures,) = crease_figures(mesh)
    assert figures.length == pytest.approx(np.linalg.norm(np.subtract(*sheet.creases[0])), rel=1e-6)
    (larger,) = crease_figures(replace(mesh, vertices=7 * mesh.vertices))
    assert larger.length == pytest.approx(7 * figures.length)
    assert larger.fold_angle == pytest.approx(figures.fold_angle)


def test_angle_at_the_papers_edge_is_unknown():
    mesh, flat = sheets.mesh(sheets.one_fold())
    top = np.flatnonzero(flat[:, 1] == 0)
    figures = crease_figures(replace(mesh, ridges=(top[np.argsort(flat[top, 0])], top[:1])))
    assert np.isnan([each.fold_angle for each in figures]).all()
