"""Gathering photos: which files are usable, their metadata, their pixels."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from origami.core.errors import UnusablePhotos, UsageError
from origami.origami_addon.files import decoded_photo
from origami.origami_addon.files.photos import gather, read_pixels
from PIL import Image, ImageCms
from PIL.TiffImagePlugin import IFDRational


@pytest.fixture
def picture() -> np.ndarray:
    """Something smooth with three different channels, (120, 160, 3) uint8."""
    row, column = np.mgrid[:120, :160]
    return np.stack([row * 2, column + 40, 255 - row - column // 2], -1).astype(np.uint8)


@pytest.fixture
def folder(tmp_path: Path, picture: np.ndarray) -> Path:
    """Three good photos: 1.png, 2.png and 10.png."""
    for number in (1, 2, 10):
        Image.fromarray(np.roll(picture, number, 1)).save(tmp_path / f"{number}.png")
    return tmp_path


def test_natural_order(folder: Path) -> None:
    photos, warnings = gather(folder)
    assert [photo.name for photo in photos] == ["1.png", "2.png", "10.png"]
    assert (photos[0].width, photos[0].height) == (160, 120)
    assert not warnings


def test_names_with_spaces_and_other_alphabets(folder: Path, picture: np.ndarray) -> None:
    for shift, name in enumerate(("page one.jpg", "страница 2.jpg", "ページ.jpg"), 20):
        Image.fromarray(np.roll(picture, shift, 1)).save(folder / name)
    photos, _ = gather(folder)
    assert {"page one.jpg", "страница 2.jpg", "ページ.jpg"} < {photo.name for photo in photos}
    assert all(read_pixels(photo).shape == (120, 160, 3) for photo in photos)


def test_same_name_in_two_folders(folder: Path, picture: np.ndarray) -> None:
    (folder / "more").mkdir()
    Image.fromarray(np.roll(picture, 33, 1)).save(folder / "more" / "1.png")
    photos, _ = gather([folder, folder / "more"])
    names = [photo.name for photo in photos]
    assert len(set(names)) == 4
    assert "more/1.png" in names


@pytest.mark.parametrize("decoder", ["_decode_with_oiio", "_decode_with_blender"])
def test_kinds_of_pictures(tmp_path: Path, picture: np.ndarray, decoder: str) -> None:
    decode = getattr(decoded_photo, decoder)
    plain = Image.fromarray(picture)
    grey = np.asarray(plain.convert("L"))
    plain.convert("L").save(tmp_path / "grey.png")
    plain.convert("RGBA").save(tmp_path / "alpha.png")
    plain.convert("LA").save(tmp_path / "grey_alpha.png")
    plain.save(tmp_path / "plain.webp", lossless=True)
    plain.save(tmp_path / "plain.tif", compression="tiff_lzw")
    Image.fromarray(grey.astype(np.uint16) * 257).save(tmp_path / "deep.png")
    plain.convert("CMYK").save(tmp_path / "cmyk.jpg", quality=100, subsampling=0)
    expected = {"alpha.png": picture, "plain.webp": picture, "plain.tif": picture}
    expected |= dict.fromkeys(("grey.png", "grey_alpha.png"), np.repeat(grey[..., None], 3, 2))
    for name, pixels in expected.items():
        found = decode(tmp_path / name)
        assert found.dtype == np.uint8, name
        np.testing.assert_array_equal(found, pixels, err_msg=name)
    deep = decode(tmp_path / "deep.png")
    assert deep.dtype == np.uint16
    np.testing.assert_allclose(deep[..., 1], grey.astype(float) * 257, atol=1)
    assert np.abs(decode(tmp_path / "cmyk.jpg").astype(int) - picture).mean() < 2


def test_transparent_pixels_keep_their_colour(tmp_path: Path, picture: np.ndarray) -> None:
    alpha = np.full((120, 160, 1), 128, np.uint8)
    Image.fromarray(np.dstack([picture, alpha])).save(tmp_path / "half.png")
    np.testing.assert_array_equal(decoded_photo.decode(tmp_path / "half.png"), picture)


def test_exif_is_read_and_rotation_not_applied(folder: Path, picture: np.ndarray) -> None:
    exif = Image.Exif()
    exif[0x010F], exif[0x0110], exif[0x0112] = "Acme", "Pocket 5", 6
    exif.get_ifd(0x8769)[0x9003] = "2014:05:11 10:20:05"
    exif.get_ifd(0x8769)[0xA405] = 28
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    for suffix in (".jpg", ".png", ".webp", ".tif"):
        for old in folder.glob("example.*"):
            old.unlink()
        Image.fromarray(picture).save(folder / f"example{suffix}", exif=exif, icc_profile=profile)
        photo = next(photo for photo in gather(folder)[0] if photo.name.startswith("example"))
        assert (photo.make, photo.model, photo.orientation) == ("Acme", "Pocket 5", 6)
        if suffix != ".tif":  # Pillow writes no inner EXIF folder into TIFF
            assert photo.taken == "2014:05:11 10:20:05"
            assert photo.focal_length_pixels == pytest.approx(28 / 43.267 * 200, rel=1e-3)
        assert photo.icc_profile == profile
        assert read_pixels(photo).shape == (120, 160, 3)


def test_focal_length_from_the_sensor(folder: Path, picture: np.ndarray) -> None:
    exif = Image.Exif()
    inner = exif.get_ifd(0x8769)
    inner[0x920A], inner[0xA20E], inner[0xA210] = IFDRational(5), IFDRational(1280, 2), 4
    inner[0xA002], inner[0xA003] = 3200, 2400
    Image.fromarray(picture).save(folder / "example.jpg", exif=exif)
    photo = next(photo for photo in gather(folder)[0] if photo.name == "example.jpg")
    assert photo.focal_length_pixels == pytest.approx(5 * 640 * 160 / 3200)


def exif_entry(tag: int, kind: int, count: int, value: bytes) -> bytes:
    return struct.pack("<HHI", tag, kind, count) + value.ljust(4, b"\0")


@pytest.mark.parametrize(
    "entries",
    [
        [exif_entry(0x010F, 7, 4, b"Acme"), exif_entry(0x0110, 3, 1, b"\1")],  # bytes and a number for text
        [exif_entry(0x0112, 2, 2, b"6"), exif_entry(0x0132, 5, 1, b"\0")],  # text for a number
        [exif_entry(0x8773, 4, 1, b"\1\2\3\4")],  # a number for the colour profile
        [exif_entry(0x8769, 2, 2, b"x")],  # text instead of the offset of the inner folder
        [exif_entry(0x010F, 2, 0xFFFFFFFF, b"\0")],  # text longer than the file
        [exif_entry(0xA002, 2, 2, b"9"), exif_entry(0x920A, 3, 1, b"\5"), exif_entry(0xA20E, 3, 1, b"\5")],
        [exif_entry(0xA405, 2, 3, b"28"), exif_entry(0xA210, 7, 1, b"\2"), exif_entry(0xA003, 12, 1, b"\0")],
    ],
)
def test_malformed_exif_is_passed_over(folder: Path, picture: np.ndarray, entries: list[bytes]) -> None:
    exif = b"Exif\0\0II*\0" + struct.pack("<IH", 8, len(entries)) + b"".join(entries) + bytes(4)
    Image.fromarray(picture).save(folder / "example.jpg", exif=exif)
    photos, warnings = gather(folder)
    photo = next(photo for photo in photos if photo.name == "example.jpg")
    assert not warnings
    assert (photo.orientation, photo.make, photo.model, photo.taken) == (1, "", "", "")
    assert (photo.focal_length_pixels, photo.icc_profile) == (None, None)


def test_good_tags_beside_a_malformed_one(folder: Path, picture: np.ndarray) -> None:
    entries = [exif_entry(0x010F, 7, 4, b"Acme"), exif_entry(0x0110, 2, 3, b"P5"), exif_entry(0x0112, 3, 1, b"\6")]
    exif = b"Exif\0\0II*\0" + struct.pack("<IH", 8, len(entries)) + b"".join(entries) + bytes(4)
    Image.fromarray(picture).save(folder / "example.jpg", exif=exif)
    photo = next(photo for photo in gather(folder)[0] if photo.name == "example.jpg")
    assert (photo.make, photo.model, photo.orientation) == ("", "P5", 6)


@pytest.mark.parametrize("orientation", [2, 4, 5, 7])
def test_photos_marked_as_mirrored_are_left_out(folder: Path, picture: np.ndarray, orientation: int) -> None:
    exif = Image.Exif()
    exif[0x0112] = orientation
    Image.fromarray(picture).save(folder / "selfie.jpg", exif=exif)
    photos, warnings = gather(folder)
    assert [photo.name for photo in photos] == ["1.png", "2.png", "10.png"]
    (warning,) = warnings
    assert "selfie.jpg is marked as mirrored" in warning


def test_pictures_of_other_kinds_are_reported(folder: Path, picture: np.ndarray) -> None:
    for name in ("c.dng", "notes.txt", ".hidden.heic"):
        (folder / name).write_bytes(b"something")
    for name in ("a.GIF", "b.gif"):
        Image.fromarray(picture).save(folder / name)
    photos, warnings = gather(folder)
    assert len(photos) == 3
    raw, others = warnings
    assert "(1 .dng)" in raw and "the JPEG that the camera makes" in raw
    assert "(2 .gif)" in others
    for photo in photos:
        photo.path.unlink()
    with pytest.raises(UnusablePhotos, match=r"no photos in .*1 \.dng.*2 \.gif"):
        gather(folder)


def test_no_exif(folder: Path) -> None:
    photo = gather(folder)[0][0]
    assert (photo.orientation, photo.focal_length_pixels, photo.make, photo.icc_profile) == (1, None, "", None)


@pytest.mark.parametrize("kind", ["jpg", "png", "webp", "tif"])
def test_damaged_files_are_named_and_left_out(folder: Path, picture: np.ndarray, kind: str) -> None:
    whole = folder / f"whole.{kind}"
    noise = np.random.default_rng(0).integers(0, 255, picture.shape, np.uint8)
    Image.fromarray(noise).save(whole)
    data = whole.read_bytes()
    whole.unlink()
    (folder / f"truncated.{kind}").write_bytes(data[: len(data) // 2])
    (folder / f"empty.{kind}").write_bytes(b"")
    (folder / f"garbage.{kind}").write_bytes(b"not a picture at all" * 50)
    Image.fromarray(picture[:1, :1]).save(folder / f"dot.{kind}")
    photos, warnings = gather(folder)
    assert [photo.name for photo in photos] == ["1.png", "2.png", "10.png"]
    for name in ("truncated", "empty", "garbage", "dot"):
        assert sum(f"{name}.{kind}" in warning for warning in warnings) == 1, (name, warnings)


def test_a_hole_in_a_jpeg(folder: Path) -> None:
    noise = np.random.default_rng(0).integers(0, 255, (200, 200, 3), np.uint8)
    Image.fromarray(noise).save(folder / "hole.jpg")
    data = bytearray((folder / "hole.jpg").read_bytes())
    del data[2000:5000]
    (folder / "hole.jpg").write_bytes(data)
    photos, warnings = gather(folder)
    assert len(photos) == 3
    assert "hole.jpg" in warnings[0]


def test_copies_are_left_out(folder: Path) -> None:
    (folder / "copy of 1.png").write_bytes((folder / "1.png").read_bytes())
    Image.open(folder / "2.png").save(folder / "other format.tif")
    photos, warnings = gather(folder)
    assert len(photos) == 3
    assert any("1.png" in warning and "copy of 1.png" in warning for warning in warnings)
    assert any("other format.tif" in warning for warning in warnings)


def test_a_photo_that_changed_during_the_run(folder: Path, picture: np.ndarray) -> None:
    photo = gather(folder)[0][0]
    Image.fromarray(picture[:110]).save(photo.path)
    with pytest.raises(UnusablePhotos, match="changed"):
        read_pixels(photo)


def test_files_that_are_gone() -> None:
    with pytest.raises(UsageError):
        gather(["/no/such/folder"])
