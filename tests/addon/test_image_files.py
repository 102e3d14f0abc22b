"""Page images: pixels, resolution and colour profile as other programs read them."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from origami.core.errors import StepFailed
from origami.origami_addon.files.icc import grey_profile, is_rgb_profile, luminance_shares, srgb_profile
from origami.origami_addon.files.image_files import (
    from_blender_image,
    to_bits,
    to_blender_image,
    to_eight_bits,
    write_jpeg,
    write_png,
    write_tiff,
)
from PIL import Image, ImageCms


@pytest.fixture
def picture():
    rng = np.random.default_rng(0)
    colors = rng.integers(0, 256, (21, 13, 3), dtype=np.uint8)
    return colors.repeat(8, axis=0).repeat(8, axis=1)[:-3, :-1]


def test_tiff_holds_pixels_resolution_and_profile(tmp_path: Path, picture):
    write_tiff(tmp_path / "Seite ü 1.tif", picture, 299.5)
    with Image.open(tmp_path / "Seite ü 1.tif") as read:
        np.testing.assert_array_equal(np.asarray(read), picture)
        assert read.info["dpi"] == (299.5, 299.5)
        assert read.info["icc_profile"] == srgb_profile()


def test_tiff_of_sixteen_bits(tmp_path: Path, picture):
    deep = picture.astype(np.uint16) * 251 + 3
    write_tiff(tmp_path / "deep.tif", deep, 300)
    np.testing.assert_array_equal(sixteen_bits_of(tmp_path / "deep.tif"), deep)


def test_png_holds_pixels_resolution_and_profile(tmp_path: Path, picture):
    write_png(tmp_path / "Seite ü 1.png", picture, 299.5)
    with Image.open(tmp_path / "Seite ü 1.png") as read:
        read.verify()
    with Image.open(tmp_path / "Seite ü 1.png") as read:
        assert read.mode == "RGB"
        np.testing.assert_array_equal(np.asarray(read), picture)
        assert read.info["dpi"] == pytest.approx((299.5, 299.5), abs=0.013)  # whole pixels per metre
        assert read.info["icc_profile"] == srgb_profile()


def test_png_of_sixteen_bits_is_the_same_to_blender(tmp_path: Path, picture, monkeypatch):
    from origami.origami_addon.files import image_files

    deep = picture.astype(np.uint16) * 251 + 3
    monkeypatch.setattr(image_files, "_PNG_PIECE", 10 * picture.shape[1] * 6)  # several pieces
    write_png(tmp_path / "deep.png", deep, 300)
    np.testing.assert_array_equal(sixteen_bits_of(tmp_path / "deep.png"), deep)
    assert (tmp_path / "deep.png").read_bytes().count(b"IDAT") > 1


@pytest.mark.parametrize(("write", "name"), [(write_tiff, "page.tif"), (write_png, "page.png")])
def test_number_of_bits_can_be_chosen(tmp_path: Path, picture, write, name):
    deep = picture.astype(np.uint16) * 251 + 3
    write(tmp_path / name, deep, 300, bits=8)
    with Image.open(tmp_path / name) as read:
        np.testing.assert_array_equal(np.asarray(read), to_eight_bits(deep))
    write(tmp_path / name, picture, 300, bits=16)
    np.testing.assert_array_equal(sixteen_bits_of(tmp_path / name), picture.astype(int) * 257)


def sixteen_bits_of(path: Path) -> np.ndarray:
    """The values of a 16-bit picture, as Blender reads them."""
    import bpy

    read = bpy.data.images.load(str(path))
    read.colorspace_settings.name = "Non-Color"
    assert read.is_float
    width, height = read.size
    return np.rint(np.array(read.pixels[:]).reshape(height, width, 4)[::-1, :, :3] * 65535)


@pytest.mark.parametrize(("write", "name"), [(write_tiff, "page.tif"), (write_png, "page.png")])
def test_grey_has_one_channel(tmp_path: Path, picture, write, name):
    grey = np.ascontiguousarray(picture[..., 0])
    write(tmp_path / name, grey, 300)
    with Image.open(tmp_path / name) as read:
        assert read.mode == "L"
        np.testing.assert_array_equal(np.asarray(read), grey)
        assert read.info["dpi"] == pytest.approx((300, 300), abs=0.013)
        assert read.info["icc_profile"] == grey_profile()
    deep = grey.astype(np.uint16) * 251 + 3
    write(tmp_path / name, deep, 300)
    with Image.open(tmp_path / name) as read:
        np.testing.assert_array_equal(np.asarray(read), deep)


@pytest.mark.parametrize(("write", "name"), [(write_tiff, "page.tif"), (write_png, "page.png")])
@pytest.mark.parametrize("width", [1, 8, 103])
def test_black_and_white_has_one_bit(tmp_path: Path, picture, write, name, width):
    image = picture[:, :width, 0] > 120
    write(tmp_path / name, image, 299.5, bits=16)
    with Image.open(tmp_path / name) as read:
        assert read.mode == "1"
        np.testing.assert_array_equal(np.asarray(read), image)
        assert read.info["dpi"] == pytest.approx((299.5, 299.5), abs=0.013)
        if name == "page.tif":
            assert [read.tag_v2[tag] for tag in (258, 259, 262, 277)] == [(1,), 4, 0, 1]  # 0: white is zero


def test_grey_jpeg_has_one_channel_and_the_same_levels(tmp_path: Path):
    levels = np.arange(256, dtype=np.uint8).reshape(16, 16).repeat(8, axis=0).repeat(8, axis=1)
    write_jpeg(tmp_path / "page.jpg", levels, 240, quality=100)
    with Image.open(tmp_path / "page.jpg") as read:
        assert read.mode == "L"
        assert np.abs(np.asarray(read).astype(int) - levels).max() <= 1
        assert read.info["dpi"] == (240, 240)
        assert read.info["icc_profile"] == grey_profile()
    write_jpeg(tmp_path / "page.jpg", levels > 100, 240)
    with Image.open(tmp_path / "page.jpg") as read:
        assert read.mode == "L"
        np.testing.assert_array_equal(np.asarray(read) > 127, levels > 100)


def test_jpeg_holds_picture_resolution_and_profile(tmp_path: Path, picture):
    write_jpeg(tmp_path / "page.jpg", picture, 240.2, quality=95)
    with Image.open(tmp_path / "page.jpg") as read:
        assert np.abs(np.asarray(read).astype(int) - picture).mean() < 12
        assert read.info["dpi"] == (240, 240)
        assert read.info["icc_profile"] == srgb_profile()


def test_profile_of_the_photo_is_kept_however_large(tmp_path: Path, picture):
    padded = srgb_profile() + bytes(150_000)
    profile = len(padded).to_bytes(4, "big") + padded[4:]
    write_tiff(tmp_path / "page.tif", picture, 300, profile)
    write_jpeg(tmp_path / "page.jpg", picture, 300, profile)
    write_png(tmp_path / "page.png", picture, 300, profile)
    for name in ("page.tif", "page.jpg", "page.png"):
        with Image.open(tmp_path / name) as read:
            assert read.info["icc_profile"] == profile


@pytest.mark.parametrize("profile", [None, b"", b"nonsense" * 40, srgb_profile().replace(b"RGB ", b"CMYK", 1)])
def test_profile_that_is_not_of_rgb_pixels_gives_way_to_srgb(tmp_path: Path, picture, profile):
    assert not is_rgb_profile(profile)
    write_tiff(tmp_path / "page.tif", picture, 300, profile)
    with Image.open(tmp_path / "page.tif") as read:
        assert read.info["icc_profile"] == srgb_profile()


def test_built_profile_is_srgb():
    built = ImageCms.ImageCmsProfile(io.BytesIO(srgb_profile()))
    assert "sRGB" in ImageCms.getProfileDescription(built)
    change = ImageCms.buildTransform(built, ImageCms.createProfile("sRGB"), "RGB", "RGB", renderingIntent=1)
    colors = np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    changed = np.asarray(ImageCms.applyTransform(Image.fromarray(colors), change))
    assert np.abs(changed.astype(int) - colors).max() <= 1


def test_grey_is_as_bright_as_equal_colours():
    levels = np.arange(256, dtype=np.uint8)[None]
    for profile in (srgb_profile(), with_curve(pow(2.0, np.log2(1.8)))):
        lab = [
            ImageCms.applyTransform(
                Image.fromarray(pixels),
                ImageCms.buildTransform(io.BytesIO(icc), ImageCms.createProfile("LAB"), mode, "LAB", renderingIntent=1),
            )
            for pixels, icc, mode in (
                (levels, grey_profile(profile), "L"),
                (levels[..., None].repeat(3, axis=2), profile, "RGB"),
            )
        ]
        lightness = [np.asarray(each)[..., 0].astype(int) for each in lab]
        assert np.abs(lightness[0] - lightness[1]).max() <= 1


def with_curve(gamma: float) -> bytes:
    """The profile of sRGB with another tone curve."""
    srgb = srgb_profile()
    start = srgb.index(b"curv")
    curve = b"curv" + bytes(4) + (1).to_bytes(4, "big") + round(gamma * 256).to_bytes(2, "big")
    return srgb[:start] + curve + srgb[start + len(curve) :]


def test_tones_of_parametric_curves():
    srgb = [2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045]
    for kind, given in ((0, [1.0]), (3, srgb), (4, [*srgb, 0.0, 0.0])):
        tag = b"para" + bytes(4) + kind.to_bytes(2, "big") + bytes(2)
        tag += b"".join(round(value * 65536).to_bytes(4, "big") for value in given)
        start = srgb_profile().index(b"curv")
        profile = srgb_profile()[:start] + tag + srgb_profile()[start + len(tag) :]
        found = np.frombuffer(grey_profile(profile)[-2048:], ">u2") / 65535
        expected = np.linspace(0, 1, 1024)
        if kind:
            expected = np.frombuffer(grey_profile()[-2048:], ">u2") / 65535
        np.testing.assert_allclose(found, expected, atol=1e-4)


def test_shares_of_luminance_are_those_of_the_primaries():
    assert luminance_shares(srgb_profile()) == pytest.approx((0.2225, 0.7169, 0.0606), abs=1e-4)
    assert sum(luminance_shares(srgb_profile())) == pytest.approx(1)
    for other in (None, b"nonsense" * 40, srgb_profile().replace(b"rXYZ", b"rABC", 1), srgb_profile()[:200]):
        assert luminance_shares(other) == pytest.approx((0.2225, 0.7169, 0.0606), abs=1e-4)
        assert grey_profile(other if other is None else other[:300]) == grey_profile()


def test_blender_image_keeps_every_value():
    values = np.arange(256, dtype=np.uint8).reshape(16, 16)
    pixels = np.stack([values, values.T, values[::-1]], -1)
    np.testing.assert_array_equal(from_blender_image(to_blender_image("test", pixels)), pixels)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_picture_too_large_for_a_tiff_is_reported(tmp_path: Path, dtype):
    huge = np.broadcast_to(np.zeros(3, dtype), (60_000, 60_000, 3))
    with pytest.raises(StepFailed, match=r"page\.tif would take .* GiB, but .*: choose fewer dpi\.$"):
        write_tiff(tmp_path / "page.tif", huge, 300)
    assert not list(tmp_path.iterdir())


def test_sixteen_bits_become_the_nearest_eight():
    deep = np.array([0, 128, 129, 25700, 65406, 65407, 65535], np.uint16)
    assert to_eight_bits(deep).tolist() == [0, 0, 1, 100, 254, 255, 255]
    assert to_eight_bits(deep).dtype == np.uint8
    shallow = np.arange(256, dtype=np.uint8)
    assert to_eight_bits(shallow) is shallow


def test_eight_bits_become_sixteen_and_come_back():
    shallow = np.arange(256, dtype=np.uint8)
    deep = to_bits(shallow, 16)
    assert deep.dtype == np.uint16
    assert (deep[0], deep[1], deep[255]) == (0, 257, 65535)
    np.testing.assert_array_equal(to_bits(deep, 8), shallow)
    assert to_bits(deep, 16) is deep


@pytest.mark.parametrize("write", [write_tiff, write_png, write_jpeg])
def test_failure_is_reported_and_leaves_nothing(tmp_path: Path, picture, write):
    (tmp_path / "page").mkdir()
    with pytest.raises(StepFailed, match="page could not be written"):
        write(tmp_path / "page", picture, 300)
    with pytest.raises(StepFailed, match=r"choose another output folder\.$"):
        write(tmp_path / "missing" / "page.x", picture, 300)
    assert [path.name for path in tmp_path.iterdir()] == ["page"]


def test_file_is_replaced_only_when_the_new_one_is_whole(tmp_path: Path, picture, monkeypatch):
    from origami.origami_addon.files import image_files

    write_jpeg(tmp_path / "page.jpg", picture, 300)
    before = (tmp_path / "page.jpg").read_bytes()

    def no_room(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(image_files, "_with_header", no_room)
    with pytest.raises(StepFailed, match="No space left on device"):
        write_jpeg(tmp_path / "page.jpg", picture[:50], 300)
    assert (tmp_path / "page.jpg").read_bytes() == before
    assert len(list(tmp_path.iterdir())) == 1
