"""Pages from exactly known photos."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.camera import Camera
from origami.core.page.photo_colors import sample
from origami.core.page.raster import PageLookup, interpolate, page_lookup, rasterize
from origami.core.page.warp import native_size, photo_positions, photo_to_page
from origami.core.sheet import FlatMap, Sheet

RADIUS, WIDTH, HEIGHT = 0.35, 0.7, 1.0


def camera(distortion=(-0.05, 0.01), size=(900, 1200), distance=2.0, tilt=0.3):
    """Looks down at the origin from ``distance``, tilted about x."""
    cosine, sine = np.cos(tilt), np.sin(tilt)
    rotation = np.array([[1, 0, 0], [0, -cosine, -sine], [0, sine, -cosine]])
    return Camera(
        "photo.jpg",
        *size,
        1700.0 * size[1] / 1200,
        np.array([size[0] / 2 + 7, size[1] / 2 - 4]),
        np.array(distortion),
        rotation,
        np.array([0, 0, distance]),
    )


def cylinder_sheet(columns=60, rows=8, bend=True):
    """A page rolled about the y axis: printed side outwards and up."""
    u, v = np.meshgrid(np.linspace(0, WIDTH, columns + 1), np.linspace(0, HEIGHT, rows + 1))
    angle = (u - WIDTH / 2) / RADIUS
    y = HEIGHT / 2 - v
    bent = np.stack([RADIUS * np.sin(angle), y, RADIUS * (np.cos(angle) - 1)], -1)
    xyz = bent if bend else np.stack([u - WIDTH / 2, y, np.zeros_like(u)], -1)
    index = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    boundary = np.concatenate([index[:-1, 0], index[-1, :-1], index[:0:-1, -1], index[0, :0:-1]])
    flat = FlatMap(np.stack([u, v], -1).reshape(-1, 2), WIDTH, HEIGHT, "page heights", None)
    return Sheet(xyz.reshape(-1, 3), triangles, (), boundary), flat


def print_at(u, v):
    """A soft chequered print with a brighter first quarter, which a mirrored or turned page would not have."""
    squares = 128 + 80 * np.sin(np.pi * u / 0.05) * np.sin(np.pi * v / 0.05)
    return squares + 30 * ((u < WIDTH / 2) & (v < HEIGHT / 2))


def photo_of_cylinder(view):
    """What the camera sees of the printed cylinder, by intersecting each pixel's ray with it."""
    column, row = np.meshgrid(np.arange(view.width) + 0.5, np.arange(view.height) + 0.5)
    normalized = view.undistort(np.stack([column, row], -1))
    ray = np.concatenate([normalized, np.ones((*column.shape, 1))], -1) @ view.rotation
    start = view.center + np.array([0, 0, RADIUS])  # the axis is at x = 0, z = -RADIUS
    a = ray[..., 0] ** 2 + ray[..., 2] ** 2
    b = ray[..., 0] * start[0] + ray[..., 2] * start[2]
    c = start[0] ** 2 + start[2] ** 2 - RADIUS**2
    with np.errstate(invalid="ignore"):
        hit = start + ray * ((-b - np.sqrt(b**2 - a * c)) / a)[..., None]
    u = RADIUS * np.arctan2(hit[..., 0], hit[..., 2]) + WIDTH / 2
    v = HEIGHT / 2 - hit[..., 1]
    grey = np.where(np.isfinite(u), print_at(u, v), 0)
    return np.repeat(np.rint(grey)[..., None], 3, axis=2).astype(np.uint8)


def test_photo_of_a_cylinder_becomes_the_flat_print():
    view = camera()
    sheet, flat = cylinder_sheet(columns=200)
    size = (420, 600)
    page = sample(photo_of_cylinder(view), photo_positions(sheet, page_lookup(sheet, flat, size), view))
    u, v = np.meshgrid((np.arange(size[0]) + 0.5) / 600, (np.arange(size[1]) + 0.5) / 600)
    error = np.abs(page[..., 0] - print_at(u, v))
    assert np.median(error) < 1
    assert np.quantile(error, 0.98) < 5  # the rest lies along the edge of the brighter quarter


def test_every_pixel_of_the_page_has_one_triangle():
    rng = np.random.default_rng(3)
    sheet, flat = cylinder_sheet(30, 40)
    inside = (flat.uv > 1e-9).all(1) & (flat.uv[:, 0] < WIDTH - 1e-9) & (flat.uv[:, 1] < HEIGHT - 1e-9)
    uv = flat.uv + inside[:, None] * rng.uniform(-0.006, 0.006, flat.uv.shape)
    moved = FlatMap(uv, WIDTH, HEIGHT, flat.unit, None)
    lookup = page_lookup(sheet, moved, (350, 500))
    assert (lookup.triangle >= 0).all()
    assert lookup.barycentric.min() >= -1e-5
    assert lookup.barycentric.sum(-1).max() <= 1 + 1e-5
    found = interpolate(lookup, sheet.triangles, uv)
    column, row = np.meshgrid(np.arange(350) + 0.5, np.arange(500) + 0.5)
    np.testing.assert_allclose(found, np.stack([column, row], -1) / 500, atol=1e-6)


def test_vertices_on_pixel_centres_leave_no_gap():
    corners = np.array([[0.5, 0.5], [4.5, 0.5], [0.5, 4.5], [4.5, 4.5], [2.5, 2.5]])
    triangles = np.array([[0, 1, 4], [1, 3, 4], [3, 2, 4], [2, 0, 4]])
    covered = rasterize(corners, triangles, (5, 5)).triangle >= 0
    assert covered[:4, :4].all()


def test_pixels_outside_the_mesh_have_no_triangle_and_stay_white():
    sheet, flat = cylinder_sheet()
    wide = FlatMap(flat.uv, 2 * WIDTH, HEIGHT, flat.unit, None)
    lookup = page_lookup(sheet, wide, (140, 100))
    assert (lookup.triangle[:, :70] >= 0).all()
    assert (lookup.triangle[:, 70:] == -1).all()
    positions = photo_positions(sheet, lookup, camera())
    assert np.isnan(positions[:, 70:]).all()
    assert (sample(np.zeros((1200, 900, 3), np.uint8), positions)[:, 70:] == 255).all()


def test_positions_are_projected_not_interpolated():
    view = camera()
    sheet, flat = cylinder_sheet(columns=1, rows=1, bend=False)
    positions = photo_positions(sheet, page_lookup(sheet, flat, (70, 100)), view)
    point = np.array([(20 + 0.5) / 100 - WIDTH / 2, HEIGHT / 2 - (80 + 0.5) / 100, 0])
    np.testing.assert_allclose(positions[80, 20], view.project(point), atol=1e-3)


def test_positions_outside_the_photo_are_not_given():
    view = camera(size=(300, 1200))
    positions = photo_positions(*_lookup(), view)
    assert np.isnan(positions[:, [0, -1]]).all()
    assert np.isfinite(positions[50, 35]).all()


def _lookup():
    sheet, flat = cylinder_sheet()
    return sheet, page_lookup(sheet, flat, (70, 100))


@pytest.mark.parametrize("method", ["bicubic", "linear"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_sampling_at_pixel_centres_gives_the_pixels(method, dtype):
    rng = np.random.default_rng(0)
    photo = rng.integers(0, np.iinfo(dtype).max, (40, 30, 3), dtype=dtype)
    column, row = np.meshgrid(np.arange(30) + 0.5, np.arange(40) + 0.5)
    result = sample(photo, np.stack([column, row], -1).astype(np.float32), method)
    assert result.dtype == dtype
    np.testing.assert_array_equal(result, photo)


@pytest.mark.parametrize("method", ["bicubic", "linear"])
def test_sampling_keeps_a_ramp_straight(method):
    ramp = np.repeat((np.arange(200, dtype=np.uint8))[None, :, None], 20, axis=0).repeat(3, axis=2)
    x = np.linspace(5, 190, 400)
    positions = np.stack([x, np.full_like(x, 10.3)], -1)[None].astype(np.float32)
    np.testing.assert_allclose(sample(ramp, positions, method)[0, :, 0], x - 0.5, atol=0.51)


def test_fewer_pixels_than_the_photo_do_not_alias():
    stripes = np.zeros((400, 400, 3), np.uint8)
    stripes[:, ::2] = 255
    column, row = np.meshgrid(np.arange(90) * 4.3 + 3, np.arange(90) * 4.3 + 3)
    positions = np.stack([column, row], -1).astype(np.float32)
    smooth = sample(stripes, positions).astype(int)
    assert np.abs(smooth - 128).max() <= 2
    assert np.abs(sample(stripes, positions, "linear").astype(int) - 128).max() > 60


def test_unknown_sampling_is_refused():
    with pytest.raises(ValueError, match="bicubic"):
        sample(np.zeros((4, 4, 3), np.uint8), np.zeros((2, 2, 2), np.float32), "nearest")


def test_native_size_is_the_density_of_the_photo():
    sheet, flat = cylinder_sheet(bend=False)
    view = camera(distortion=(0, 0), tilt=0.0)
    assert native_size(sheet, flat, view) == pytest.approx(view.focal_length / 2.0, rel=1e-9)


def test_photo_to_page_undoes_the_way_from_page_to_photo():
    view = camera()
    sheet, flat = cylinder_sheet(columns=120, rows=60)
    back = photo_to_page(sheet, flat, view, step=4)
    assert back.shape == (300, 225, 2)
    seen = np.argwhere(np.isfinite(back[..., 0]))[::57]
    assert len(seen) > 100
    for row, column in seen:
        point = back[row, column]
        angle = (point[0] - WIDTH / 2) / RADIUS
        in_space = np.array([RADIUS * np.sin(angle), HEIGHT / 2 - point[1], RADIUS * (np.cos(angle) - 1)])
        np.testing.assert_allclose(view.project(in_space), (np.array([column, row]) + 0.5) * 4, atol=0.1)


def test_of_two_layers_the_nearer_one_is_seen():
    corners = np.array([[-0.3, -0.3], [0.3, -0.3], [0.3, 0.3], [-0.3, 0.3]])
    vertices = np.concatenate([np.c_[corners, np.full(4, z)] for z in (0.2, 0.0)])
    triangles = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    uv = np.concatenate([corners, corners + 5])
    sheet = Sheet(vertices, triangles, (), np.arange(4))
    back = photo_to_page(sheet, FlatMap(uv, 1, 1, "mm", 1.0), camera(tilt=0.0), step=8)
    assert np.nanmax(back) < 1


def test_lookup_of_nothing_is_empty():
    lookup = rasterize(np.zeros((3, 2)), np.zeros((0, 3), int), (4, 3))
    assert isinstance(lookup, PageLookup)
    assert (lookup.triangle == -1).all()
