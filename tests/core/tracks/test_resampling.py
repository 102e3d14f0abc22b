"""Resampled points scatter as they do if the photos are measured again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sheets
from origami.core.tracks.adjustment import adjust
from origami.core.tracks.resampling import resampled
from origami.core.tracks.triangulation import triangulate
from scipy.spatial.transform import Rotation

TILTS = [(20, 11), (-20, 5), (4, -25), (5, 24), (-14, -16)]
VIEWS = tuple(replace(sheets.camera(tilt), name=f"{number}.jpg") for number, tilt in enumerate(TILTS))
TIMES = 20


@pytest.fixture(scope="module")
def printed() -> tuple[np.ndarray, np.ndarray]:
    """Points of a sheet folded twice, and their flat places."""
    return sheets.sample_points(sheets.two_folds(), VIEWS[0], 300, 0.0, 0.0, lines=False)


def measured(points: np.ndarray, random: np.random.Generator) -> np.ndarray:
    seen = np.stack([view.project(points) for view in VIEWS], axis=1)
    observed = seen + random.normal(scale=0.3, size=seen.shape)
    observed[::3, 1] = np.nan
    return observed


def scatter(found: list[np.ndarray], around: np.ndarray) -> np.ndarray:
    """Standard deviation of each point, once each set is laid on the points as they are."""
    laid = []
    for points in found:
        a, b = points - points.mean(0), around - around.mean(0)
        turn = Rotation.align_vectors(b, a)[0].as_matrix()
        size = (b * (a @ turn.T)).sum() / (a**2).sum()
        laid.append(size * a @ turn.T - b)
    return np.sqrt(np.square(laid).sum(axis=2).mean(axis=0))


def test_they_scatter_as_new_measurements_do(printed):
    points, place = printed
    again = []
    for seed in range(TIMES):
        observed = measured(points, np.random.default_rng(seed))
        again.append(triangulate(adjust(VIEWS, observed), observed).points)
    observed = measured(points, np.random.default_rng(99))
    adjusted = adjust(VIEWS, observed)
    found = triangulate(adjusted, observed).points
    others = [there for there, _ in resampled(adjusted, found, observed, place, TIMES, np.random.default_rng(0))]
    ratio = scatter(others, found) / scatter(again, points)
    assert np.median(ratio) == pytest.approx(1, abs=0.3)


def test_exact_observations_leave_everything_in_place(printed):
    points, place = printed
    observed = np.stack([view.project(points) for view in VIEWS], axis=1)
    moved, cameras = next(resampled(VIEWS, points, observed, place, 1, np.random.default_rng(0)))
    # no deviation is taken for less than .02 pixels
    assert np.abs(moved - points).max() < 1e-3
    assert np.abs(cameras[2].center - VIEWS[2].center).max() < 1e-3


def test_a_point_that_no_photo_shows_stays(printed):
    points, place = printed
    observed = measured(points, np.random.default_rng(1))
    observed[7] = np.nan
    others = list(resampled(VIEWS, points, observed, place, 3, np.random.default_rng(0)))
    assert len(others) == 3
    for moved, _ in others:
        assert np.isfinite(moved).all()
        np.testing.assert_array_equal(moved[7], points[7])
