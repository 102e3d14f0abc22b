"""The surface follows the paper's edge where nothing is printed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sheets
from origami.core.camera import Camera
from origami.core.edge.measured_edge import fit_to_edge
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


@pytest.fixture(scope="module")
def curled():
    """A curled sheet whose margins, a sixth of its width, are blank: views, photos, points, and a surface of these."""
    sheet = sheets.cylinder()
    views = [small(tilt) for tilt in TILTS]
    photos = [photo_of(sheets.outline_pixels(sheet, view), view) for view in views]
    points, _ = sheets.sample_points(sheet, views[0], 1500, noise=0.0002, outliers=0.0, margin=0.12)
    outline = sheets.outline_pixels(sheet, views[0])
    return sheet, views, photos, points, outline, reconstruct(points, views[0], outline, SETTINGS)


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
