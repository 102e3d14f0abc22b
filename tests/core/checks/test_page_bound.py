"""The bound of a page grows with what makes the page worse, and the page keeps it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sheets
from origami.core.checks.page_bound import bound_on_page, page_bound, page_within
from origami.core.checks.page_scatter import page_scatter
from origami.core.flat.distortion import apply_affine, fit_similarity
from origami.core.flat.flatten import flatten
from origami.core.sheet import FlatMap, Sheet
from origami.core.surface.mesh import build_sheet
from origami.core.surface.surface import reconstruct
from origami.core.surface.surface_settings import SurfaceSettings
from origami.core.tracks.adjustment import adjust
from origami.core.tracks.triangulation import triangulate

TILTS = [(20, 11), (-20, 5), (4, -25), (5, 24), (-14, -16)]
VIEWS = tuple(replace(sheets.camera(tilt), name=f"{number}.jpg") for number, tilt in enumerate(TILTS))
# What the lens is in truth: structure from motion does not see it.
LENS = {"principal_point": np.array([1215.0, 1590.0]), "distortion": np.array([-0.02, -0.1])}
SEEN_BY = tuple(replace(view, **LENS) for view in VIEWS)
SETTINGS = SurfaceSettings(grid_rows=25)


class Case:
    """A sheet seen by five cameras, each point to ``noise`` pixels, and its surface.

    In the last two photos, it is bent by up to ``moved`` page heights.
    """

    def __init__(self, sheet: sheets.SyntheticSheet, noise: float, margin: float = 0.05, moved: float = 0.0) -> None:
        random = np.random.default_rng(4)
        points, self.flat = sheets.sample_points(sheet, SEEN_BY[0], 500, 0.0, 0.0, margin, lines=False)
        seen = np.stack([view.project(points) for view in SEEN_BY], axis=1)
        last = points + moved * np.array([0.0, 0.0, 1.0]) * np.square(self.flat[:, :1])
        for number in (3, 4):
            seen[:, number] = SEEN_BY[number].project(last)
        self.observed = seen + random.normal(scale=noise, size=seen.shape)
        cameras = adjust(VIEWS, self.observed)
        self.points = triangulate(cameras, self.observed).points
        polygon = sheets.outline_pixels(sheet, SEEN_BY[0])
        self.surface = reconstruct(self.points, cameras[0], polygon, SETTINGS)
        self.sheet = build_sheet(self.surface, polygon, [])
        self.inputs = self.sheet, self.surface, self.points, self.observed, cameras, 0, SETTINGS
        self.true = sheets.flat_at(sheet, SEEN_BY[0], cameras[0].project(self.sheet.vertices))

    def error(self) -> np.ndarray:
        """How far each vertex is from its place on the page."""
        uv = flatten(self.sheet, robust_start=False)
        known = np.isfinite(self.true[:, 0])
        return np.linalg.norm(apply_affine(fit_similarity(uv[known], self.true[known]), uv) - self.true, axis=1)


@pytest.fixture(scope="module")
def curl() -> Case:
    return Case(sheets.cylinder(), 0.3)


def test_most_of_a_curled_page_keeps_its_bound(curl):
    bound, error = page_bound(page_scatter(*curl.inputs)), curl.error()
    assert (error <= bound)[np.isfinite(error)].mean() > 0.8
    assert np.median(bound) < 10 * np.nanmedian(error)  # few points leave the lens nearly free


def test_a_flat_page_comes_out_flat_within_its_bound():
    case = Case(sheets.plane(), 0.1)
    bound, error = page_bound(page_scatter(*case.inputs)), case.error()
    assert (error <= bound).mean() > 0.8
    assert np.median(bound) < 2e-3


def test_the_bound_is_wider_where_nothing_is_printed():
    case = Case(sheets.cylinder(), 0.3, margin=0.2)
    bound = page_bound(page_scatter(*case.inputs))
    inside = ((case.true > 0.25) & (case.true < [sheets.WIDTH - 0.25, sheets.HEIGHT - 0.25])).all(axis=1)
    rim = ((case.true < 0.05) | (case.true > [sheets.WIDTH - 0.05, sheets.HEIGHT - 0.05])).any(axis=1)
    assert np.median(bound[rim]) > 1.2 * np.median(bound[inside])


def test_a_page_of_photos_some_of_which_show_the_sheet_bent_keeps_its_bound():
    case = Case(sheets.cylinder(), 0.3, moved=0.02)
    bound, error = page_bound(page_scatter(*case.inputs)), case.error()
    assert (error <= bound)[np.isfinite(error)].mean() > 0.8


def test_the_same_inputs_give_the_same_bound(curl):
    np.testing.assert_array_equal(
        page_bound(page_scatter(*curl.inputs)), page_bound(page_scatter(*curl.inputs, threads=2))
    )


def test_nothing_is_known_without_observations(curl):
    sheet, surface, points, observed, *rest = curl.inputs
    assert page_scatter(sheet, surface, points, np.full_like(observed, np.nan), *rest) is None


@pytest.fixture
def page() -> tuple[Sheet, FlatMap]:
    """Two triangles, 2 x 1 in space and 40 x 20 mm on the page."""
    corners = np.array([[0, 0], [2, 0], [2, 1], [0, 1.0]])
    vertices = np.column_stack([corners * [1, -1], np.zeros(4)])
    triangles = np.array([[0, 2, 1], [0, 3, 2]])
    sheet = Sheet(vertices, triangles, (), np.array([0, 3, 2, 1]), np.full(4, 0.01))
    return sheet, FlatMap(20 * corners, 40.0, 20.0, "mm", 20.0)


def test_a_bound_is_told_in_the_unit_of_the_page(page):
    np.testing.assert_allclose(bound_on_page(*page), 0.2)


def test_nine_tenths_of_a_page_with_one_bound_keep_it_and_half_keep_half_of_it(page):
    assert page_within(*page, (0.5, 0.9)) == pytest.approx([0.2 * np.sqrt(np.log(2) / np.log(10)), 0.2])


def test_a_page_of_two_bounds_lies_between(page):
    sheet, flat = page
    wide = np.array([0.01, 0.01, 0.01, 0.04])
    (most,) = page_within(replace(sheet, bound=wide), flat, (0.9,))
    assert 0.2 < most < 20 * 0.02


def test_a_sheet_without_a_bound_has_none_on_its_page(page):
    sheet, flat = page
    assert bound_on_page(replace(sheet, bound=None), flat) is None
    assert page_within(replace(sheet, bound=None), flat, (0.9,)) is None
