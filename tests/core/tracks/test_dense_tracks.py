"""The print of a sheet followed through photos whose cameras are known."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.page.page import lay_out
from origami.core.sheet import Sheet
from origami.core.tracks import measured_points
from origami.core.tracks.alignment import Template, shifted
from origami.core.tracks.dense_tracks import dense_tracks
from origami.core.tracks.measured_points import measure_points
from origami.core.tracks.page_print import CELL
from scipy import ndimage
from table_scene import flat_sheet, page, table_scene, wood

LIFT = 0.004


def picture(shift: tuple[float, float] = (0.0, 0.0), seed: int = 4) -> np.ndarray:
    """Blurred spots, (200, 300), moved by ``shift``, x first."""
    random = np.random.default_rng(seed)
    at, height = random.uniform(-10, 310, (900, 2)), random.normal(size=900)
    row, column = np.indices((200, 300)).astype(float)
    result = np.zeros((200, 300))
    for (x, y), each in zip(at + shift, height, strict=True):
        top, left = max(int(y) - 8, 0), max(int(x) - 8, 0)
        part = np.s_[top : max(int(y) + 9, 0), left : max(int(x) + 9, 0)]
        result[part] += each * np.exp(-((row[part] - y) ** 2 + (column[part] - x) ** 2) / (2 * 1.8**2))
    return result.astype(np.float32)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.37, -0.81), (1.4, 0.9)])
def test_a_shift_is_found_to_a_fiftieth_of_a_pixel(shift):
    known = np.ones((200 // CELL, 300 // CELL), bool)
    template, moving = Template(picture(), known), picture(shift)
    start = np.zeros((*known.shape, 2), np.float32)
    found = template.align(ndimage.spline_filter(moving), known, start, limit=8.0, rounds=20, order=3)
    inner = found[4:-4, 4:-4]
    assert np.quantile(np.abs(inner - shift), 0.95) < 0.02
    fit = template.fit(shifted(ndimage.spline_filter(moving), found, 3), known)
    assert np.quantile(fit.correlation[4:-4, 4:-4], 0.05) > 0.99
    assert np.quantile(np.linalg.norm(fit.step[4:-4, 4:-4], axis=-1), 0.95) < 0.02


def test_other_print_does_not_fit():
    known = np.ones((200 // CELL, 300 // CELL), bool)
    fit = Template(picture(), known).fit(picture(seed=9), known)
    assert (fit.correlation > 0.75).mean() < 0.02


@pytest.fixture(scope="module")
def scene():
    return table_scene([(flat_sheet(), page(0.9))], wood(), sheet_points=700, seed=3)


def grid_sheet(lift: float) -> Sheet:
    """The scene's sheet as a mesh that is bent by up to ``lift`` off the table, as limp surfaces are."""
    (corner, right, down, _) = flat_sheet()[0]
    u, v = np.meshgrid(np.linspace(0, 1, 15), np.linspace(0, 1, 21))
    bump = lift * np.sin(2 * np.pi * u) * np.sin(3 * np.pi * v)
    vertices = corner + u[..., None] * right + v[..., None] * down + bump[..., None] * [0, 0, 1]
    index = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    boundary = np.concatenate([index[0, :-1], index[:-1, -1], index[-1, :0:-1], index[:0:-1, 0]])
    return Sheet(vertices.reshape(-1, 3), triangles, (), boundary[::-1])


def test_points_lie_on_the_sheet_though_the_surface_was_wrong(scene):
    sheet = grid_sheet(LIFT)
    found = measure_points(scene.model, np.ones(len(scene.model.points), bool), sheet, 0, scene.photos.__getitem__)
    assert found is not None
    assert found.tracks > 1000
    height = found.points[: found.tracks, 2]
    assert np.median(np.abs(height - np.median(height))) < LIFT / 20


def test_tracks_are_where_the_photos_show_the_print(scene):
    sheet = grid_sheet(LIFT)
    (_, right, down, _) = flat_sheet()[0]
    uv = np.stack(np.meshgrid(np.linspace(0, 1, 15), np.linspace(0, 1, 21)), -1).reshape(-1, 2)
    uv = uv * [np.linalg.norm(right), np.linalg.norm(down)]
    flat = lay_out(sheet, uv, scene.model.cameras[0], np.array([0.0, -1.0]))
    tracks = dense_tracks(sheet, flat, scene.model.cameras, scene.photos.__getitem__, 0, 1000)
    off = []
    for index, camera in enumerate(scene.model.cameras):
        seen = np.isfinite(tracks[:, index, 0])
        # the point of the table's plane under the pixel: one place of the sheet for all photos
        ray = np.column_stack([camera.undistort(tracks[seen, index]), np.ones(seen.sum())]) @ camera.rotation
        place = np.full((len(seen), 3), np.nan)
        place[seen] = camera.center - ray * ((camera.center[2] - 0.002) / ray[:, 2])[:, None]
        off.append(place[:, :2])
    spread = np.nanstd(np.stack(off), axis=0)
    pixel = np.linalg.norm(down) / 600
    assert np.median(spread) < 0.2 * pixel


def test_a_blank_sheet_has_no_tracks(scene):
    blank = [np.full_like(photo, 180) for photo in scene.photos]
    every = np.ones(len(scene.model.points), bool)
    assert measure_points(scene.model, every, grid_sheet(0.0), 0, blank.__getitem__) is None


def test_a_small_print_is_followed_where_enlarging_it_more_finds_too_little(scene, monkeypatch):
    asked = []

    def few_when_large(*arguments, **keywords):
        asked.append(arguments[5])
        tracks = dense_tracks(*arguments, **keywords)
        return tracks[:50] if arguments[5] > 500 else tracks

    monkeypatch.setattr(measured_points, "dense_tracks", few_when_large)
    every = np.ones(len(scene.model.points), bool)
    found = measure_points(scene.model, every, grid_sheet(0.0), 0, scene.photos.__getitem__)
    assert asked == [1000, 500]
    assert found is not None
    assert found.tracks > 100
