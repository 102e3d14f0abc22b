"""The maps of the sheet's relief, as Blender and other programs read them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from folded import folded_sheet, white_page
from origami.core.errors import StepFailed
from origami.core.page.texture import PageTexture
from origami.origami_addon.export.relief_files import relief_of_page, write_displacement_map, write_normal_map
from origami.origami_addon.files.exr import write_exr
from origami.origami_addon.state import Page
from PIL import Image

FOLD = 0.5


@pytest.fixture(scope="module")
def case():
    return folded_sheet(FOLD)


def page_of(width: int, height: int) -> Page:
    texture = replace(white_page().texture, image=np.zeros((height, width, 3), np.uint8))
    assert isinstance(texture, PageTexture)
    return Page(texture, 300.0, texture.image)


def loaded(path) -> np.ndarray:
    """The values of a picture as Blender's materials have them if it is no colour, (H, W, 4), the top row first."""
    import bpy

    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    width, height = image.size
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)[::-1]


def test_blender_reads_the_normals_as_they_are(case, tmp_path):
    path = tmp_path / "normal ü.png"
    write_normal_map(path, relief_of_page(case.sheet, case.flat, page_of(40, 50)))
    normals = 2 * loaded(path)[..., :3] - 1
    np.testing.assert_allclose(normals[3, 7], [0, -np.sin(FOLD), np.cos(FOLD)], atol=1e-4)
    np.testing.assert_allclose(normals[-3, 7], [0, np.sin(FOLD), np.cos(FOLD)], atol=1e-4)


def test_nothing_in_the_normal_map_bends_its_values(case, tmp_path):
    write_normal_map(tmp_path / "normal_map.png", relief_of_page(case.sheet, case.flat, page_of(40, 50)))
    content = (tmp_path / "normal_map.png").read_bytes()
    assert not any(chunk in content for chunk in (b"iCCP", b"sRGB", b"gAMA", b"cHRM"))
    assert content[24] == 16
    with Image.open(tmp_path / "normal_map.png") as read:
        assert "OpenGL" in read.info["Description"]


def test_blender_reads_the_heights_in_page_heights(case, tmp_path):
    path = tmp_path / "displacement ü.exr"
    figures = write_displacement_map(path, relief_of_page(case.sheet, case.flat, page_of(80, 100)))
    heights = loaded(path)
    away = np.abs((np.arange(100) + 0.5) / 100 - 0.5)[:, None]
    expected = np.broadcast_to((away - 0.25) * np.tan(FOLD), (100, 80))
    np.testing.assert_allclose(heights[..., 0], expected, atol=1e-6)
    assert figures["lowest_page_heights"] == pytest.approx(expected.min(), abs=1e-6)
    assert figures["highest_page_heights"] == pytest.approx(expected.max(), abs=1e-6)
    assert b"page heights" in path.read_bytes()


@pytest.mark.parametrize("shape", [(1, 1), (16, 5), (37, 21)])
def test_exr_keeps_every_bit(tmp_path, shape):
    values = np.random.default_rng(1).standard_normal(shape).astype(np.float32)
    write_exr(tmp_path / "values.exr", values, "random")
    np.testing.assert_array_equal(loaded(tmp_path / "values.exr")[..., 0], values)


def test_maps_are_no_larger_than_4k(case, tmp_path):
    write_normal_map(tmp_path / "map.png", relief_of_page(case.sheet, case.flat, page_of(20, 5000)))
    with Image.open(tmp_path / "map.png") as read:
        assert read.size == (16, 4096)
        assert read.info["dpi"][0] == pytest.approx(300 * 4096 / 5000, abs=0.1)


def test_an_unwritable_place_is_reported(case, tmp_path):
    for name, write in {"normal_map.png": write_normal_map, "displacement_map.exr": write_displacement_map}.items():
        (tmp_path / name).mkdir()
        with pytest.raises(StepFailed, match=f"{name} could not be written"):
            write(tmp_path / name, relief_of_page(case.sheet, case.flat, page_of(40, 50)))
