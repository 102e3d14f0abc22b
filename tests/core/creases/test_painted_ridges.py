"""Bands of paint, thinned to runs of vertices."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from origami.core.creases.painted_ridges import painted_ridges
from origami.core.numeric.triangles import directed_edges

STEP = 1 / 50


def _edges(triangles: np.ndarray) -> np.ndarray:
    return np.unique(np.sort(directed_edges(triangles), axis=1), axis=0)


def _apart(flat: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Distance of points from a segment (2, 2), in steps."""
    span = line[1] - line[0]
    along = np.clip((flat - line[0]) @ span / (span @ span), 0, 1)
    return np.linalg.norm(flat - line[0] - along[:, None] * span, axis=1) / STEP


def _same(run: np.ndarray, other: np.ndarray) -> bool:
    return np.array_equal(run, other) or np.array_equal(run[::-1], other)


@pytest.fixture(scope="module")
def plane() -> tuple[np.ndarray, np.ndarray]:
    """Flat positions (V, 2) and edges of a page without creases."""
    sheet, flat = sheets.mesh(sheets.plane(), STEP)
    return flat, _edges(sheet.triangles)


@pytest.mark.parametrize("in_space", [False, True])
@pytest.mark.parametrize("make", [sheets.two_folds, sheets.oblique_fold, sheets.cross])
def test_lines_one_vertex_wide_come_out_as_they_are(make, in_space):
    sheet, flat = sheets.mesh(make(), STEP)
    weight = np.zeros(len(flat))
    weight[np.concatenate(sheet.ridges)] = 1
    found = painted_ridges(sheet.vertices if in_space else flat, _edges(sheet.triangles), weight)
    assert found.warning is None
    assert len(found.runs) == len(sheet.ridges)
    assert all(any(_same(run, ridge) for ridge in sheet.ridges) for run in found.runs)


@pytest.mark.parametrize("half_width", [1.2, 1.6, 2.5])
@pytest.mark.parametrize("make", [sheets.two_folds, sheets.oblique_fold])
def test_a_band_along_a_crease_is_thinned_to_the_crease(make, half_width):
    sheet, flat = sheets.mesh(make(), STEP)
    creases = make().creases
    weight = np.max([np.maximum(0, 1 - (_apart(flat, line) / half_width) ** 2) for line in creases], axis=0)
    found = painted_ridges(flat, _edges(sheet.triangles), weight)
    assert found.warning is None
    assert len(found.runs) == len(creases)
    assert all(any(_same(run, ridge) for ridge in sheet.ridges) for run in found.runs)


def _stroke(flat: np.ndarray, line: np.ndarray, seed: int) -> np.ndarray:
    """Dabs of a brush three steps wide, inexact by half a step."""
    random = np.random.default_rng(seed)
    count = round(np.linalg.norm(line[1] - line[0]) / STEP)
    centres = np.linspace(*line, count) + 0.25 * STEP * random.normal(size=(count, 2))
    return (np.linalg.norm(flat[:, None] - centres, axis=2).min(1) < 1.5 * STEP).astype(float)


STROKES = np.array([[[0, 0.31], [0.7, 0.52]], [[0.2, 0], [0.3, 1]], [[0.1, 0.9], [0.68, 0.6]]])


@pytest.mark.parametrize("seed", range(5))
def test_strokes_that_cross_give_a_run_each_along_its_middle(plane, seed):
    flat, edges = plane
    weight = np.max([_stroke(flat, line, 10 * seed + index) for index, line in enumerate(STROKES)], axis=0)
    found = painted_ridges(flat, edges, weight)
    assert found.warning is None
    assert len(found.runs) == 3
    joined = {tuple(edge) for edge in edges.tolist()}
    for line in STROKES:
        offsets = [_apart(flat[run], line) for run in found.runs]
        run, offset = min(zip(found.runs, offsets, strict=True), key=lambda pair: float(pair[1].mean()))
        assert offset.mean() < 0.6
        assert np.linalg.norm(flat[run[-1]] - flat[run[0]]) > 0.93 * np.linalg.norm(line[1] - line[0])
        steps = np.sort(np.stack([run[:-1], run[1:]], -1), axis=1)
        assert all(tuple(step) in joined for step in steps.tolist())
        assert len(np.unique(run)) == len(run)


def test_strokes_that_meet_end_where_they_meet(plane):
    flat, edges = plane
    middle = np.array([0.35, 0.5])
    rays = [np.array([middle, end]) for end in ([0.35, 0.05], [0.03, 0.8], [0.67, 0.8])]
    weight = np.max([_apart(flat, line) < 1.5 for line in rays], axis=0).astype(float)
    found = painted_ridges(flat, edges, weight)
    assert len(found.runs) == 3
    for run in found.runs:
        assert min(np.linalg.norm(flat[run[[0, -1]]] - middle, axis=1)) < 1.6 * STEP


@pytest.mark.parametrize("radius", [1.8, 4, 9])
def test_a_blob_makes_no_ridge_and_a_warning(plane, radius):
    flat, edges = plane
    blob = np.linalg.norm(flat - [0.35, 0.5], axis=1) < radius * STEP
    found = painted_ridges(flat, edges, blob.astype(float))
    assert found.runs == ()
    assert [len(spot) for spot in found.spots] == [blob.sum()]
    assert found.warning is not None
    assert found.warning.startswith("1 painted spot shows no direction")


def test_a_blob_beside_a_stroke_is_reported_and_the_stroke_counts(plane):
    flat, edges = plane
    weight = _stroke(flat, STROKES[0], 0)
    weight[np.linalg.norm(flat - [0.5, 0.85], axis=1) < 3 * STEP] = 0.2
    found = painted_ridges(flat, edges, weight)
    assert len(found.runs) == 1
    assert len(found.spots) == 1


def test_nothing_and_everything(plane):
    flat, edges = plane
    nothing = painted_ridges(flat, edges, np.zeros(len(flat)))
    assert (nothing.runs, nothing.spots) == ((), ())
    assert painted_ridges(flat, edges, np.ones(len(flat))).runs == ()
    in_one_place = painted_ridges(0 * flat, edges, np.ones(len(flat)))
    assert in_one_place.runs == ()
    assert in_one_place.warning is not None
