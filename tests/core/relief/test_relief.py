"""The maps of a relief are exact for a sheet folded once and for a cylinder, and agree with each other."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from folded import folded_sheet
from origami.core.page.raster import page_lookup
from origami.core.relief.relief import find_relief
from origami.core.relief.relief_maps import covering_lookup, displacement_map, normal_map
from origami.core.sheet import FlatMap, Sheet

WIDTH, HEIGHT = 160, 200


def maps_of(sheet: Sheet, flat: FlatMap, size=(WIDTH, HEIGHT)):
    """Normals (H, W, 3) from -1 to 1 and heights (H, W) on the page."""
    relief, lookup = find_relief(sheet, flat), covering_lookup(sheet, flat, size)
    normals = normal_map(relief, lookup)
    assert normals.dtype == np.uint16
    return normals / 65535 * 2 - 1, displacement_map(relief, sheet.triangles, lookup)


def slopes_of_picture(heights, height_px=HEIGHT):
    """Rise to the right and upward, by differences of neighbours, on the page without its edge."""
    down, right = np.gradient(heights.astype(float), 1 / height_px)
    return np.stack([right, -down], -1)[2:-2, 2:-2]


def test_a_flat_sheet_has_no_relief():
    case = folded_sheet(0.0)
    relief, lookup = find_relief(case.sheet, case.flat), covering_lookup(case.sheet, case.flat, (WIDTH, HEIGHT))
    half = 65535 / 2
    assert np.abs(normal_map(relief, lookup) - [half, half, 65535.0]).max() <= 0.5
    np.testing.assert_allclose(displacement_map(relief, case.sheet.triangles, lookup), 0, atol=1e-7)


@pytest.mark.parametrize("fold", [0.05, 0.5, 1.2])
def test_a_sheet_folded_once_stands_at_its_angle_on_both_sides_of_a_sharp_crease(fold):
    """Both halves rise from the crease in the middle row of pixels, whatever the sheet's frame and scale."""
    case = folded_sheet(fold)
    normals, heights = maps_of(case.sheet, case.flat)
    upper, lower = np.array([0, -np.sin(fold), np.cos(fold)]), np.array([0, np.sin(fold), np.cos(fold)])
    middle = HEIGHT // 2
    np.testing.assert_allclose(normals[:middle], np.broadcast_to(upper, (middle, WIDTH, 3)), atol=2e-5)
    np.testing.assert_allclose(normals[middle:], np.broadcast_to(lower, (middle, WIDTH, 3)), atol=2e-5)
    away = np.abs((np.arange(HEIGHT) + 0.5) / HEIGHT - 0.5)[:, None]  # page heights from the crease
    expected = (away - 0.25) * np.tan(fold)  # the mean is 0
    np.testing.assert_allclose(heights, np.broadcast_to(expected, heights.shape), atol=1e-6 + 1e-6 * np.tan(fold))


def arc(half_angle: float, steps: int = 40) -> tuple[Sheet, FlatMap]:
    """A sheet bent to the arc of a circle to the right and left of its middle, bulging out; 1 wide and 1 high."""
    u, v = np.meshgrid(np.linspace(0, 1, steps + 1), np.linspace(0, 1, 5))
    turn = (u - 0.5) * 2 * half_angle
    radius = 0.5 / half_angle
    vertices = np.stack([radius * np.sin(turn), -v, radius * np.cos(turn)], -1).reshape(-1, 3)
    index = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    edge = np.concatenate([index[:-1, 0], index[-1, :-1], index[:0:-1, -1], index[0, :0:-1]])
    return Sheet(vertices, triangles, (), edge), FlatMap(
        np.stack([u, v], -1).reshape(-1, 2), 1, 1, "page heights", None
    )


def test_a_cylinder_keeps_its_angles():
    """The relief with the slopes of a circle's arc, over the arc's length, is the logarithm of a cosine."""
    half_angle, width = 0.9, 300
    normals, heights = (each[16:-16, 15:-15] for each in maps_of(*arc(half_angle), size=(width, 60)))
    turn = ((np.arange(width)[15:-15] + 0.5) / width - 0.5) * 2 * half_angle
    expected = np.broadcast_to(np.stack([np.sin(turn), 0 * turn, np.cos(turn)], -1), normals.shape)
    np.testing.assert_allclose(normals, expected, atol=1e-3)
    rise = 0.5 / half_angle * np.log(np.cos(turn))
    np.testing.assert_allclose(heights - heights.mean(), np.broadcast_to(rise - rise.mean(), heights.shape), atol=2e-4)
    # as smooth as the sheet, although a triangle is 7.5 pixels wide
    bend = np.diff(heights.astype(float), n=2, axis=1) * width**2
    np.testing.assert_allclose(bend, np.broadcast_to(-2 * half_angle / np.cos(turn[1:-1]) ** 2, bend.shape), rtol=0.3)


@pytest.mark.parametrize("make", sheets.ALL)
def test_both_maps_describe_one_relief(make):
    exact = make()
    sheet, uv = sheets.mesh(exact)
    flat = FlatMap(uv, sheets.WIDTH, sheets.HEIGHT, "page heights", None)
    normals, heights = maps_of(sheet, flat, size=(350, 500))
    towards = -normals[..., :2] / normals[..., 2:]
    error = np.linalg.norm(slopes_of_picture(heights, 500) - towards[2:-2, 2:-2], axis=-1)
    assert np.percentile(error, 95) < 0.012
    assert heights.mean() == pytest.approx(0, abs=1e-3)


def test_paper_that_hangs_over_stands_as_steep_as_a_page_can_show():
    case = folded_sheet(0.5)
    flipped = case.sheet.vertices.copy()
    rows = flipped.reshape(31, 25, 3)
    rows[25:] = 2 * rows[24] - rows[25:]  # the last rows are folded back onto those above
    sheet = Sheet(flipped, case.sheet.triangles, case.sheet.ridges, case.sheet.boundary)
    normals, heights = maps_of(sheet, case.flat)
    assert normals[..., 2].min() == pytest.approx(np.cos(np.radians(80)), abs=0.02)
    assert np.isfinite(heights).all()


def test_pixels_beside_the_mesh_continue_the_nearest():
    case = folded_sheet(0.5)
    flat = FlatMap(0.9 * case.flat.uv + 4, case.flat.width, case.flat.height, "mm", None)
    assert (page_lookup(case.sheet, flat, (WIDTH, HEIGHT)).triangle < 0).any()
    normals, heights = maps_of(case.sheet, flat)
    np.testing.assert_array_equal(normals[0], normals[4])
    np.testing.assert_array_equal(heights[4:184, -1], heights[4:184, 147])


@pytest.mark.parametrize("where", ["in space", "on the page"])
def test_triangles_without_area_do_no_harm(where):
    case = folded_sheet(0.5)
    vertices, uv = case.sheet.vertices.copy(), case.flat.uv.copy()
    for values in [vertices] if where == "in space" else [uv]:
        values[[130, 131]] = values[132]
    sheet = Sheet(vertices, case.sheet.triangles, case.sheet.ridges, case.sheet.boundary)
    flat = FlatMap(uv, case.flat.width, case.flat.height, "mm", None)
    normals, heights = maps_of(sheet, flat)
    assert np.isfinite(heights).all()
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1, atol=1e-4)
    np.testing.assert_allclose(heights[150:], maps_of(case.sheet, case.flat)[1][150:], atol=2e-3)
