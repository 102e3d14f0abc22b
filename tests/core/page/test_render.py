"""Which photo a page is made from, and that nothing shows where they meet."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.camera import Camera
from origami.core.page.render import render_page
from origami.core.sheet import FlatMap, Sheet
from scipy import ndimage

SIZE = (240, 320)
_WIDTH, _HEIGHT = 0.75, 1.0


def sheet_from(height_at, rows=60, columns=45):
    u, v = np.meshgrid(np.linspace(0, _WIDTH, columns + 1), np.linspace(0, _HEIGHT, rows + 1))
    x, z = height_at(u - _WIDTH / 2)
    index = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    vertices = np.stack([x, _HEIGHT / 2 - v, z], -1).reshape(-1, 3)
    sheet = Sheet(vertices, triangles, (), np.concatenate([index[:-1, 0], index[-1, :-1]]))
    return sheet, FlatMap(np.stack([u, v], -1).reshape(-1, 2), _WIDTH, _HEIGHT, "page heights", None)


def flat_sheet():
    return sheet_from(lambda x: (x, np.zeros_like(x)))


def view_from(x, distance=2.0, pixels=400):
    """A camera above the sheet, moved by ``x`` and turned to look at the origin."""
    angle = np.arctan2(x, distance)
    cosine, sine = np.cos(angle), np.sin(angle)
    rotation = np.array([[cosine, 0, -sine], [0, -1, 0], [-sine, 0, -cosine]])
    center = np.array([x, 0, distance])
    focal = 1.5 * pixels
    middle = np.array([pixels / 2, pixels / 2])
    return Camera(f"{x}.jpg", pixels, pixels, focal, middle, np.zeros(2), rotation, -rotation @ center)


def photo_of(view, print_at, gain=1.0, blur=0.0, white=255):
    """The printed plane z = 0 as the camera sees it, in 8 bits or 16 by its white."""
    column, row = np.meshgrid(np.arange(view.width) + 0.5, np.arange(view.height) + 0.5)
    ray = np.concatenate([view.undistort(np.stack([column, row], -1)), np.ones((*column.shape, 1))], -1) @ view.rotation
    hit = view.center - ray * (view.center[2] / ray[..., 2])[..., None]
    grey = gain * print_at(hit[..., 0] + _WIDTH / 2, _HEIGHT / 2 - hit[..., 1])
    dtype = np.uint8 if white == 255 else np.uint16
    return np.repeat(np.clip(ndimage.gaussian_filter(grey, blur), 0, white).astype(dtype)[..., None], 3, axis=2)


def letters(u, v):
    return np.where((np.sin(u * 190) * np.sin(v * 160) > 0.3) & (np.abs(u - _WIDTH / 2) < 0.3), 60.0, 200.0)


def paper(u, v):
    return np.full_like(u, 200.0)


def test_reference_alone_is_untouched():
    sheet, flat = flat_sheet()
    cameras = [view_from(-0.5), view_from(0.5)]
    photos = [photo_of(camera, letters) for camera in cameras]
    texture = render_page(sheet, flat, cameras, photos.__getitem__, 1, SIZE)
    assert (texture.photo == 1).all()
    assert texture.blank_share == 0
    row, column = 100, 77
    point = np.array([(column + 0.5) / 320 - _WIDTH / 2, _HEIGHT / 2 - (row + 0.5) / 320, 0])
    np.testing.assert_allclose(texture.position[row, column], cameras[1].project(point), atol=1e-3)


def test_sharp_photo_beats_a_larger_blurred_one():
    sheet, flat = flat_sheet()
    cameras = [view_from(0.1, distance=1.8), view_from(-0.1, distance=2.0)]
    photos = [photo_of(cameras[0], letters, blur=3), photo_of(cameras[1], letters)]
    texture = render_page(sheet, flat, cameras, photos.__getitem__, 0, SIZE, "best")
    assert (texture.photo == 1).mean() > 0.95


def test_desk_beside_the_paper_is_not_taken_for_the_page():
    sheet, flat = flat_sheet()
    cameras = [view_from(0.1), view_from(-0.1)]

    def with_desk(u, v):
        return np.where(u < 0.02 + 0.01 * np.sin(9 * v), 15.0, letters(u, v))

    photos = [photo_of(cameras[0], letters, blur=2), photo_of(cameras[1], with_desk)]
    texture = render_page(sheet, flat, cameras, photos.__getitem__, 0, SIZE, "best")
    assert (texture.photo == 1).mean() > 0.9
    assert texture.image[:, :14].min() > 150  # blank margin, no desk


def test_photos_of_unlike_exposure_meet_without_a_seam():
    sheet, flat = sheet_from(lambda x: (x, -0.9 * np.abs(x)))
    flat_print = paper  # nothing printed: any step in brightness would show
    cameras = [view_from(-1.5), view_from(1.5)]
    photos = [photo_of(cameras[0], flat_print, gain=1.0), photo_of(cameras[1], flat_print, gain=0.7)]
    texture = render_page(sheet, flat, cameras, photos.__getitem__, 0, SIZE, "best")
    assert set(np.unique(texture.photo)) == {0, 1}
    inner = texture.image[8:-8, 8:-8, 0].astype(int)
    assert np.ptp(inner) <= 3
    assert abs(np.median(inner) - 200) <= 2  # the reference's exposure


def test_what_is_hidden_in_a_photo_is_taken_from_another():
    # A steep ridge along the page's middle: each camera sees only the side that is turned to it.
    sheet, flat = sheet_from(lambda x: (0.5 * x, -0.87 * np.abs(x)))
    cameras = [view_from(-2.5), view_from(2.5)]
    photos = [np.full((400, 400, 3), 80, np.uint8), np.full((400, 400, 3), 80, np.uint8)]
    texture = render_page(sheet, flat, cameras, photos.__getitem__, 0, SIZE, "best")
    assert (texture.photo[:, :110] == 0).mean() > 0.98
    assert (texture.photo[:, 130:] == 1).mean() > 0.98


def test_page_outside_the_mesh_is_white_and_counted():
    sheet, flat = flat_sheet()
    wider = FlatMap(flat.uv, 2 * _WIDTH, _HEIGHT, flat.unit, None)
    cameras = [view_from(-0.2), view_from(0.2)]
    photos = [photo_of(camera, letters) for camera in cameras]
    for source in ("reference", "best"):
        texture = render_page(sheet, wider, cameras, photos.__getitem__, 0, (480, 320), source)
        assert texture.blank_share == pytest.approx(0.5, abs=0.01)
        assert (texture.image[:, 250:] == 255).all()
        assert (texture.photo[:, 250:] == -1).all()


@pytest.mark.parametrize("source", ["reference", "best"])
def test_sixteen_bits_stay_sixteen_bits(source):
    """A ramp of 16 levels to the pixel is followed; from one level of 8 bits to the next there are 257."""
    sheet, flat = flat_sheet()
    cameras = [view_from(-0.2), view_from(0.2)]

    def ramp(u, v):
        return 30000 + 16 * 320 * u

    photos = [photo_of(camera, ramp, white=65535) for camera in cameras]
    texture = render_page(sheet, flat, cameras, photos.__getitem__, 0, SIZE, source)
    assert texture.image.dtype == np.uint16
    column = (np.arange(SIZE[0]) + 0.5) / SIZE[0] * _WIDTH
    off = texture.image[8:-8, 8:-8, 0] - ramp(column, 0)[8:-8]
    assert np.abs(off).max() < 32
