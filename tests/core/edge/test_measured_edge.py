"""The surface follows the paper's edge where nothing is printed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sheets
from origami.core.camera import Camera
from origami.core.edge.edge_stiffness import as_stiff_as_its_edge
from origami.core.edge.measured_edge import fit_to_edge, run_on
from origami.core.numeric.image import encoded, shrink
from origami.core.numeric.polygon import filled_polygon
from origami.core.surface.surface import reconstruct
from origami.core.surface.surface_settings import SurfaceSettings

SETTINGS = SurfaceSettings(grid_rows=40)
TILTS = ((4, 3), (-24, 16), (22, -20), (18, 24), (-20, -22))
SIZE = 4  # of a photo's side, how many times smaller than those of `sheets.camera`


def small(tilt: tuple[float, float]) -> Camera:
    view = sheets.camera(tilt)
    return replace(
        view,
        name=f"{tilt}.jpg",
        width=view.width // SIZE,
        height=view.height // SIZE,
        focal_length=view.focal_length / SIZE,
        principal_point=view.principal_point / SIZE,
    )


def photo_of(outline: np.ndarray, view: Camera, paper: float = 0.8, desk: float = 0.1) -> np.ndarray:
    """White paper on a dark desk, each pixel the mean of 16."""
    inside = filled_polygon(4 * outline, (4 * view.height, 4 * view.width)).astype(np.float32)
    light = desk + (paper - desk) * shrink(inside, 4)
    return encoded(np.repeat(light[..., None], 3, axis=2), np.dtype(np.uint8))


def photographed(sheet, margin: float, stiffness: float = 1.0):
    """A sheet whose margins are blank: itself, views, photos, points, an outline, and a surface of these points."""
    views = [small(tilt) for tilt in TILTS]
    photos = [photo_of(sheets.outline_pixels(sheet, view), view) for view in views]
    points, _ = sheets.sample_points(sheet, views[0], 1500, noise=0.0002, outliers=0.0, margin=margin)
    outline = sheets.outline_pixels(sheet, views[0])
    surface = reconstruct(points, views[0], outline, replace(SETTINGS, smoothness=stiffness))
    return sheet, views, photos, points, outline, replace(surface, stiffness=stiffness)


@pytest.fixture(scope="module")
def curled():
    """A curled sheet whose margins are a sixth of its width."""
    return photographed(sheets.cylinder(), 0.12)


@pytest.fixture(scope="module")
def sunk():
    """A page that sinks into the gutter where nothing is printed, as stiff as its print would allow."""
    return photographed(sheets.gutter(), 0.1, stiffness=1000.0)


def margin_error(surface, sheet) -> float:
    """Mean distance along the ray, page heights, of the surface from the truth within 4 % of the edge."""
    mesh, flat = sheets.mesh(sheet)
    near = (np.minimum(flat, [sheets.WIDTH, sheets.HEIGHT] - flat) < 0.04).any(axis=1)
    frame = surface.grid.frame
    plane, _ = frame.from_world(mesh.vertices[near])
    return float(np.linalg.norm(surface.at(plane) - mesh.vertices[near], axis=1).mean())


def fitted(curled, photos, **changed):
    _, views, _, points, outline, surface = curled
    return fit_to_edge(surface, points, SETTINGS, views, 0, changed.get("outline", outline), photos)


def test_a_blank_margin_lies_where_its_edge_shows(curled):
    sheet, _, photos, *_, surface = curled
    better = fitted(curled, photos)
    assert len(better.edge) > 200
    assert margin_error(better, sheet) < 0.25 * margin_error(surface, sheet)


def test_an_outline_drawn_by_hand_serves_as_well(curled):
    sheet, _, photos, _, outline, surface = curled
    drawn = outline + np.random.default_rng(0).normal(0, 0.7, (8, 2)).repeat(len(outline) // 8 + 1, 0)[: len(outline)]
    assert margin_error(fitted(curled, photos, outline=drawn), sheet) < 0.3 * margin_error(surface, sheet)


def test_a_photo_in_which_something_hides_the_edge_does_not_count_there(curled):
    sheet, views, photos, *_, surface = curled
    hidden = photos[1].copy()
    hidden[:, : views[1].width // 2] = 90
    better = fitted(curled, [photos[0], hidden, *photos[2:]])
    assert margin_error(better, sheet) < 0.3 * margin_error(surface, sheet)


def test_without_an_edge_in_the_photos_the_surface_stays(curled):
    _, _, photos, *_, surface = curled
    grey = [np.full_like(photo, 120) for photo in photos]
    assert fitted(curled, grey) is surface
    assert fitted(curled, [photos[0], *grey[1:]]) is surface


def test_an_outline_within_the_page_is_no_edge(curled):
    """Somebody drew it around a part of the page; the paper's edge is out of reach."""
    _, _, photos, _, outline, surface = curled
    part = outline.mean(0) + 0.6 * (outline - outline.mean(0))
    assert fitted(curled, photos, outline=part) is surface


def test_what_the_frame_cuts_off_is_no_edge(curled):
    """The reference photo shows the upper half; along its lower border there is no paper's edge."""
    _, views, photos, points, outline, _ = curled
    half = replace(views[0], name="half.jpg", height=views[0].height // 2)
    cut = np.column_stack([outline[:, 0], np.minimum(outline[:, 1], half.height)])
    seen = points[views[0].project(points)[:, 1] < half.height]
    surface = reconstruct(seen, half, cut, SETTINGS)
    better = fit_to_edge(surface, seen, SETTINGS, [half, *views[1:]], 0, cut, [photos[0][: half.height], *photos[1:]])
    place = better.grid.frame.to_world(better.edge.plane, better.edge.inverse_depth)
    assert half.project(place)[:, 1].max() < half.height - 1


def test_a_page_that_sinks_into_the_gutter_is_followed_down(sunk):
    """Its surface goes straight on; from the nearest places of the edge on, the others are found and drawn to."""
    sheet, _, photos, *_, surface = sunk
    better = fitted(sunk, photos)
    assert margin_error(better, sheet) < 0.1 * margin_error(surface, sheet)
    assert better.missed_edge < 0.01 < 0.1 * replace(surface, edge=better.edge).missed_edge
    assert better.stiffness < surface.stiffness


def test_a_surface_that_meets_its_edge_stays_as_stiff_as_it_is(curled):
    _, _, photos, points, *_ = curled
    better = fitted(curled, photos)
    assert as_stiff_as_its_edge(better, points, SETTINGS) is better
    no_edge = replace(better, edge=None)
    assert as_stiff_as_its_edge(no_edge, points, SETTINGS) is no_edge


def test_values_run_on_straight_into_a_gap_and_level_out():
    values = np.full(400, np.nan)
    values[:100] = 0.1 * np.arange(100)
    on = run_on(values)
    np.testing.assert_array_equal(on[:100], values[:100])
    assert on[100] == pytest.approx(10.0, abs=0.1)
    assert on[110] == pytest.approx(11.0 * (1 - 11 / 301) + (-0.1 * 60) * 11 / 301, abs=0.01)
    assert np.ptp(on[200:300:99] - np.interp([200, 299], [99, 400], [9.9 + 6, 0 - 6])) < 0.01


def test_a_gap_between_two_known_stretches_joins_them():
    values = np.zeros(100)
    values[30:40] = np.nan
    np.testing.assert_allclose(run_on(values), 0)
    values[40:70] = 1.0
    assert (np.diff(run_on(values)[29:41]) > 0).all()


def test_nothing_known_runs_on_as_nothing():
    np.testing.assert_array_equal(run_on(np.full(5, np.nan)), np.zeros(5))


def test_few_known_values_run_on_level():
    values = np.full(50, np.nan)
    values[10:13] = [1.0, 2.0, 3.0]
    on = run_on(values)
    assert on.min() == 1.0 and on.max() == 3.0
