"""The page from the reference photo alone, whose pixels stay as they are."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.page.single_photo import page_of_photo
from origami.core.sheet import FlatMap
from printed_plane import HEIGHT, SIZE, WIDTH, flat_sheet, letters, photo_of, view_from


def test_each_pixel_comes_from_its_place_in_the_reference():
    sheet, flat = flat_sheet()
    cameras = [view_from(-0.5), view_from(0.5)]
    photos = [photo_of(camera, letters) for camera in cameras]
    texture = page_of_photo(sheet, flat, cameras, photos.__getitem__, 1, SIZE)
    assert (texture.photo == 1).all()
    assert texture.blank_share == 0
    row, column = 100, 77
    point = np.array([(column + 0.5) / 320 - WIDTH / 2, HEIGHT / 2 - (row + 0.5) / 320, 0])
    np.testing.assert_allclose(texture.position[row, column], cameras[1].project(point), atol=1e-3)


def test_page_outside_the_mesh_is_white_and_counted():
    sheet, flat = flat_sheet()
    wider = FlatMap(flat.uv, 2 * WIDTH, HEIGHT, flat.unit, None)
    cameras = [view_from(-0.2)]
    photos = [photo_of(camera, letters) for camera in cameras]
    texture = page_of_photo(sheet, wider, cameras, photos.__getitem__, 0, (480, 320))
    assert texture.blank_share == pytest.approx(0.5, abs=0.01)
    assert (texture.image[:, 250:] == 255).all()
    assert (texture.photo[:, 250:] == -1).all()


def test_sixteen_bits_stay_sixteen_bits():
    """A ramp of 16 levels to the pixel is followed; from one level of 8 bits to the next there are 257."""
    sheet, flat = flat_sheet()
    camera = view_from(-0.2)

    def ramp(u, v):
        return 30000 + 16 * 320 * u

    texture = page_of_photo(sheet, flat, [camera], [photo_of(camera, ramp, white=65535)].__getitem__, 0, SIZE)
    assert texture.image.dtype == np.uint16
    column = (np.arange(SIZE[0]) + 0.5) / SIZE[0] * WIDTH
    off = texture.image[8:-8, 8:-8, 0] - ramp(column, 0)[8:-8]
    assert np.abs(off).max() < 32
