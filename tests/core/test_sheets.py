"""The synthetic sheets are correct: other tests rely on them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import sheets

every_sheet = pytest.mark.parametrize("make", sheets.ALL, ids=lambda make: make.__name__)


def away_from_creases(sheet: sheets.SyntheticSheet, count: int, distance: float) -> np.ndarray:
    flat = np.random.default_rng(3).random((count, 2)) * [sheets.WIDTH, sheets.HEIGHT]
    for start, end in sheet.creases:
        along = (end - start) / np.linalg.norm(end - start)
        offset = flat - start
        flat = flat[np.abs(offset[:, 0] * along[1] - offset[:, 1] * along[0]) > distance]
    return flat


@every_sheet
def test_is_isometric(make):
    sheet, step = make(), 1e-4
    flat = away_from_creases(sheet, 2000, 4 * step)
    # Fourth-order differences: the error of the check itself stays below what it checks.
    u, v = (
        sum(c * sheet.in_space(flat + k * step * axis) for k, c in ((-2, 1), (-1, -8), (1, 8), (2, -1))) / (12 * step)
        for axis in np.eye(2)
    )
    metric = np.stack([(u * u).sum(1), (v * v).sum(1), (u * v).sum(1)], -1)
    assert np.abs(metric - [1, 1, 0]).max() < 1e-8


@every_sheet
def test_is_continuous_across_creases(make):
    sheet = make()
    for start, end in sheet.creases:
        along = (end - start) / np.linalg.norm(end - start)
        on_line = start + np.linspace(0.01, 0.99, 50)[:, None] * (end - start)
        across = 1e-9 * np.array([-along[1], along[0]])
        assert np.abs(sheet.in_space(on_line + across) - sheet.in_space(on_line - across)).max() < 1e-8


@every_sheet
def test_is_bent_but_seen_whole(make):
    sheet, view = make(), sheets.camera()
    flat = np.random.default_rng(0).random((4000, 2)) * [sheets.WIDTH, sheets.HEIGHT]
    spatial = sheet.in_space(flat)
    assert np.ptp(spatial[:, 2]) < 1e-12 if make is sheets.plane else np.ptp(spatial[:, 2]) > 0.05
    pixels = view.project(spatial)
    assert ((pixels > 0) & (pixels < [view.width, view.height])).all()
    # A graph over the photo: nothing is hidden, and the printed side faces the camera.
    step = 1e-5
    du, dv = (view.project(sheet.in_space(flat + step * axis)) - pixels for axis in np.eye(2))
    assert (du[:, 0] * dv[:, 1] - du[:, 1] * dv[:, 0] > 0).all()


@every_sheet
def test_flat_position_of_a_pixel(make):
    sheet, view = make(), sheets.camera()
    flat = np.random.default_rng(0).random((500, 2)) * [sheets.WIDTH, sheets.HEIGHT]
    assert np.abs(sheets.flat_at(sheet, view, view.project(sheet.in_space(flat))) - flat).max() < 1e-8


@every_sheet
def test_mesh_covers_the_page(make):
    sheet, flat = sheets.mesh(make())
    a, b, c = (flat[sheet.triangles[:, i]] for i in range(3))
    area = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    assert (area < 0).all()
    assert area.sum() == pytest.approx(-sheets.WIDTH * sheets.HEIGHT)
    length = np.linalg.norm(np.diff(flat[[*sheet.boundary, sheet.boundary[0]]], axis=0), axis=1).sum()
    assert length == pytest.approx(2 * (sheets.WIDTH + sheets.HEIGHT))
    edges = {tuple(sorted(edge)) for t in sheet.triangles for edge in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0]))}
    for ridge in sheet.ridges:
        assert all(tuple(sorted(pair)) in edges for pair in pairwise(ridge))
    assert len(sheet.ridges) == len(make().creases)


def test_samples_have_the_noise_asked_for():
    sheet, view = sheets.two_folds(), sheets.camera()
    points, flat = sheets.sample_points(sheet, view, 20000, noise=0.002, outliers=0.1)
    offset = points - sheet.in_space(flat)
    ray = (points - view.center) / np.linalg.norm(points - view.center, axis=1, keepdims=True)
    along = (offset * ray).sum(1)
    across = np.linalg.norm(offset - along[:, None] * ray, axis=1)
    assert 1.4826 * np.median(np.abs(along)) == pytest.approx(0.002 * np.sqrt(1 + 1 / 9), rel=0.2)
    assert np.sqrt((across**2).mean()) == pytest.approx(0.002 / 3 * np.sqrt(2), rel=0.05)
    assert (np.abs(along) > 0.01).mean() == pytest.approx(0.1, abs=0.01)
