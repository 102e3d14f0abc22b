"""HEIC and AVIF photos: the same pixels as libheif's, colours, EXIF, and what damaged and lying files give."""

from __future__ import annotations

import io
import struct
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import bpy
import heif_files
import numpy as np
import pillow_heif
import pytest
from heif_files import Item, code_points, crop, encoded, grid, heif_file, mirror, tile_item, turn
from origami.core.errors import StepFailed, UnusablePhotos
from origami.origami_addon.files import decoded_photo, heif_pixels, hevc, photos
from origami.origami_addon.files.heif import Heif, read_heif
from origami.origami_addon.files.heif_boxes import HeifError
from origami.origami_addon.files.heif_colour import Colour
from origami.origami_addon.files.heif_pixels import decode_heif
from origami.origami_addon.files.photo_metadata import read_metadata
from PIL import Image, ImageCms

TILE = (96, 64)  # the library that writes them makes none smaller than 64


@pytest.fixture(scope="module")
def picture() -> np.ndarray:
    """Something smooth with sharp patches of strong colour, (120, 170, 3) uint8."""
    row, column = np.mgrid[:120, :170]
    shades = np.stack([row * 2, column + 40, 255 - row - column // 2], -1).astype(np.uint8)
    shades[20:50, 10:60], shades[60:90, 80:120], shades[90:110, 10:50] = (250, 20, 30), (10, 30, 240), 255
    return shades


@pytest.fixture(scope="module")
def items(picture: np.ndarray) -> list[Item]:
    """The picture as a grid of 2 x 2 tiles, which the last ones exceed."""
    return grid(picture, *TILE)


def described(items: list[Item], *properties: bytes) -> list[Item]:
    """The items; the last one has more properties."""
    return [*items[:-1], replace(items[-1], properties=(*items[-1].properties, *properties))]


def from_libheif(data: bytes) -> np.ndarray:
    pixels = np.asarray(pillow_heif.open_heif(data, convert_hdr_to_8bit=False))
    return np.repeat(pixels[..., None], 3, 2) if pixels.ndim == 2 else pixels[..., :3]


def assert_as_libheif(data: bytes) -> np.ndarray:
    pixels, expected = decode_heif(read_heif(data)), from_libheif(data)
    assert pixels.dtype == expected.dtype
    limit = 257 if pixels.dtype == np.uint16 else 1
    np.testing.assert_allclose(pixels.astype(int), expected.astype(int), atol=limit)
    return pixels


@pytest.mark.parametrize(
    "properties",
    [
        (),
        (turn(1),),
        (turn(2),),
        (turn(3),),
        (mirror(0),),
        (mirror(1),),
        (turn(1), mirror(1)),
        (mirror(1), turn(1)),
        (crop(100, 60, 18, -12), turn(3)),
        (code_points(1, 13, 1, True),),
        (code_points(1, 13, 6, False),),
    ],
)
def test_a_grid_as_phones_write_it(items: list[Item], properties: tuple[bytes, ...]) -> None:
    assert_as_libheif(heif_file(described(items, *properties)))


@pytest.mark.parametrize("chroma", [420, 422, 444])
def test_a_single_picture_of_odd_size(picture: np.ndarray, chroma: int) -> None:
    assert assert_as_libheif(encoded(picture[:119, :167], chroma=chroma)).shape == (119, 167, 3)


def test_grey_and_transparent_pictures(picture: np.ndarray) -> None:
    assert_as_libheif(encoded(picture[..., 0]))
    assert_as_libheif(encoded(np.dstack([picture, np.full(picture.shape[:2], 99, np.uint8)])))


def test_ten_bits(picture: np.ndarray) -> None:
    buffer = io.BytesIO()
    deep = picture.astype("<u2") * 257
    pillow_heif.from_bytes("RGB;16", (170, 120), deep.tobytes()).save(
        buffer, quality=90, enc_params={"preset": "ultrafast"}
    )
    assert assert_as_libheif(buffer.getvalue()).dtype == np.uint16


def test_avif(picture: np.ndarray) -> None:
    """With a colour for each pixel; where four share one, readers differ in how they interpolate."""
    full = {"quality": 90, "subsampling": "4:4:4"}
    for data in (
        encoded(picture, "avif", **full),
        heif_file(grid(picture, *TILE, kind="avif", **full), brand=b"avif"),
    ):
        expected = np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)
        np.testing.assert_allclose(decode_heif(read_heif(data)).astype(int), expected, atol=1)


def test_pictures_beside_the_photo_are_ignored(picture: np.ndarray, items: list[Item]) -> None:
    small = replace(items[0], references=((b"thmb", (len(items),)),))
    depth = replace(items[1], references=((b"auxl", (len(items),)),))
    tone_map = Item(b"tmap", b"?", (), ((b"dimg", (len(items), 1)),))
    pixels = decode_heif(read_heif(heif_file([*items, small, depth, tone_map], primary=len(items))))
    assert np.abs(pixels.astype(int) - picture).mean() < 3


def test_a_picture_that_only_turns_another_one(items: list[Item]) -> None:
    turned = Item(b"iden", b"", (turn(1),), ((b"dimg", (len(items),)),))
    pixels = decode_heif(read_heif(heif_file([*described(items, turn(1)), turned])))
    np.testing.assert_array_equal(pixels, decode_heif(read_heif(heif_file(described(items, turn(2))))))


def test_exif_counts_except_for_the_orientation(tmp_path: Path, picture: np.ndarray, items: list[Item]) -> None:
    """Readers turn such a file as its own properties say."""
    exif = Image.Exif()
    exif[0x010F], exif[0x0110], exif[0x0112] = "Acme", "Pocket 5", 6
    exif.get_ifd(0x8769)[0x9003], exif.get_ifd(0x8769)[0xA405] = "2014:05:11 10:20:05", 28
    content = exif.tobytes().removeprefix(b"Exif\0\0")
    photo_number = len(items)
    file = heif_file([*described(items, turn(3)), heif_files.exif_item(content, photo_number)], primary=photo_number)
    (tmp_path / "IMG_1.HEIC").write_bytes(file)
    for shift in (10, 20):
        Image.fromarray(np.roll(picture, shift, 1)).save(tmp_path / f"{shift}.png")
    photo = photos.gather(tmp_path)[0][-1]
    assert (photo.make, photo.model, photo.taken) == ("Acme", "Pocket 5", "2014:05:11 10:20:05")
    assert (photo.orientation, photo.width, photo.height) == (1, 120, 170)
    assert photo.focal_length_pixels == pytest.approx(28 / 43.267 * np.hypot(120, 170), rel=1e-3)
    assert photos.read_pixels(photo).shape == (170, 120, 3)


def test_colours_are_kept(items: list[Item]) -> None:
    own = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    assert read_metadata(heif_file(described(items, heif_files.profile(own)))).icc_profile == own
    assert read_metadata(heif_file(items)).icc_profile is None
    display_p3 = read_metadata(heif_file(described(items, code_points(12, 13, 6, True)))).icc_profile
    assert display_p3 is not None
    to_srgb = ImageCms.buildTransform(
        ImageCms.ImageCmsProfile(io.BytesIO(display_p3)), ImageCms.createProfile("sRGB"), "RGB", "RGB"
    )
    inside = np.asarray(ImageCms.applyTransform(Image.new("RGB", (1, 1), (200, 100, 60)), to_srgb))
    # By the matrices of both standards.
    np.testing.assert_allclose(inside[0, 0], (215, 93, 47), atol=1)


@pytest.mark.parametrize("transfer", [16, 18])
def test_brightness_beyond_white_is_refused(items: list[Item], transfer: int) -> None:
    with pytest.raises(HeifError, match="is an HDR picture"):
        read_heif(heif_file(described(items, code_points(9, transfer, 9, True))))


def changed(items: list[Item], number: int, **values: object) -> bytes:
    return heif_file([replace(item, **values) if n == number else item for n, item in enumerate(items)])


def test_files_that_are_cut_short(items: list[Item]) -> None:
    data = heif_file(items)
    for size in (20, 100, 400, len(data) // 2, len(data) - 1):
        with pytest.raises(HeifError, match=r"is (cut short|damaged) and is left out"):
            read_heif(data[:size])


def test_a_hole_of_zeros(items: list[Item]) -> None:
    coded = items[3].content
    with pytest.raises(HeifError, match="is damaged"):
        read_heif(changed(items, 3, content=coded[:100] + bytes(50) + coded[150:]))


def test_a_tile_that_cannot_be_decoded(items: list[Item]) -> None:
    """Blender shows the one before it instead."""
    noise = np.random.default_rng(0).integers(1, 255, len(items[3].content) - 6, np.uint8).tobytes()
    file = changed(items, 3, content=items[3].content[:6] + noise)
    with pytest.raises(HeifError, match="is damaged"):
        decode_heif(read_heif(file))


@pytest.mark.parametrize(
    "content",
    [
        struct.pack(">4BHH", 0, 0, 255, 255, 170, 120),  # more tiles than there are
        struct.pack(">4BII", 0, 1, 1, 1, 2**31, 2**31),
        struct.pack(">4BHH", 0, 0, 1, 1, 0, 120),
        b"",
    ],
)
def test_grids_that_lie(items: list[Item], content: bytes) -> None:
    with pytest.raises(HeifError, match="is damaged"):
        read_heif(changed(items, len(items) - 1, content=content))


def test_sizes_that_lie(items: list[Item]) -> None:
    """Neither the file's size nor that of the coded picture may be a lie: memory would be taken for it."""
    for claimed in ((65535, 65535), (0, 64), (64, 96)):
        properties = (items[0].properties[0], heif_files.size_property(*claimed))
        with pytest.raises(HeifError, match="is damaged"):
            read_heif(heif_file([replace(items[0], properties=properties)]))
    many = Item(b"grid", struct.pack(">4BHH", 0, 0, 255, 255, 9, 9), (), ((b"dimg", (1,) * 65535),))
    with pytest.raises(HeifError, match="is damaged"):
        read_heif(heif_file([items[0], many]))


def test_references_in_a_circle(items: list[Item]) -> None:
    for circle in (
        [Item(b"iden", b"", (), ((b"dimg", (1,)),))],
        [Item(b"grid", struct.pack(">4BHH", 0, 0, 0, 0, 64, 48), (), ((b"dimg", (1,)),))],
    ):
        with pytest.raises(HeifError):
            read_heif(heif_file(circle))


def test_kinds_of_pictures_that_blender_does_not_decode(items: list[Item]) -> None:
    with pytest.raises(HeifError, match=r"cannot read \(j2k1\).*save it as JPEG"):
        read_heif(heif_file([replace(items[0], kind=b"j2k1")]))


def test_one_tile_in_many_places(items: list[Item]) -> None:
    """It is decoded once: a small file cannot ask for a tile's bytes a thousand times."""
    content = struct.pack(">4BHH", 0, 0, 31, 31, 32 * TILE[0], 32 * TILE[1])
    repeated = Item(b"grid", content, (), ((b"dimg", (1,) * 1024),))
    pixels = decode_heif(read_heif(heif_file([items[0], repeated])))
    np.testing.assert_array_equal(pixels[-TILE[1] :, -TILE[0] :], pixels[: TILE[1], : TILE[0]])


def test_a_full_disk_is_not_taken_for_damage(items: list[Item], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(heif_pixels.shutil, "disk_usage", lambda folder: SimpleNamespace(free=1000))
    with pytest.raises(StepFailed, match="no room to decode photos"):
        decode_heif(read_heif(heif_file(items)))


def test_a_photo_that_vanishes(tmp_path: Path, picture: np.ndarray, items: list[Item]) -> None:
    (tmp_path / "1.heic").write_bytes(heif_file(items))
    for shift in (10, 20):
        Image.fromarray(np.roll(picture, shift, 1)).save(tmp_path / f"{shift}.png")
    found, _ = photos.gather(tmp_path)
    assert len(found) == 3
    for photo in found:
        photo.path.unlink()
        with pytest.raises(UnusablePhotos, match=r"cannot be read \(No such file or directory\)"):
            photos.read_pixels(photo)


def test_random_changes_end_in_a_sentence(items: list[Item]) -> None:
    data = heif_file(items)
    random = np.random.default_rng(1)
    for _ in range(100):
        broken = bytearray(data)
        broken[random.integers(0, data.index(b"mdat"))] = random.integers(256)
        try:
            found = read_heif(bytes(broken))
        except HeifError as error:
            assert "left out" in str(error)
        else:
            assert isinstance(found, Heif)


def test_the_colours_of_a_parameter_set(items: list[Item]) -> None:
    tile = read_heif(heif_file([items[0]])).tiles[0]
    other = hevc.with_colour(tile.configuration, Colour(9, 13, 9, False))
    assert other != tile.configuration
    assert hevc.sizes(other, tile.coded) == {TILE}
    assert hevc.with_colour(other, Colour(1, 13, 6, True)) == tile.configuration


def test_blender_stays_as_it_is(empty_scene: None, picture: np.ndarray) -> None:
    scene = bpy.context.scene
    scene.render.filepath, scene.render.resolution_x = "//mine", 123
    before = ([each.name for each in bpy.data.scenes], [each.name for each in bpy.data.images])
    decode_heif(read_heif(encoded(picture)))
    after = ([each.name for each in bpy.data.scenes], [each.name for each in bpy.data.images])
    assert (after[0], set(after[1]) - {"Render Result"}) == (before[0], set(before[1]) - {"Render Result"})
    assert bpy.context.scene == scene
    assert (scene.render.filepath, scene.render.resolution_x) == ("//mine", 123)


def test_a_photo_is_decoded_once(tmp_path: Path, items: list[Item], monkeypatch: pytest.MonkeyPatch) -> None:
    """And again when its file changes."""
    path = tmp_path / "photo.heic"
    path.write_bytes(heif_file(items))
    first = decoded_photo.decode(path)
    monkeypatch.setattr(decoded_photo, "decode_heif", lambda heif: pytest.fail("decoded again"))
    np.testing.assert_array_equal(decoded_photo.decode(path), first)
    monkeypatch.undo()
    path.write_bytes(heif_file(described(items, turn(1))))
    np.testing.assert_array_equal(decoded_photo.decode(path), np.rot90(first))


def test_the_sentence_names_the_file(tmp_path: Path, items: list[Item]) -> None:
    for number in range(3):
        (tmp_path / f"{number}.HEIC").write_bytes(heif_file(items)[: 900 + number])
    with pytest.raises(UnusablePhotos, match=r"0\.HEIC is cut short and is left out: copy it again"):
        photos.gather(tmp_path)


def test_a_file_of_a_single_tile(items: list[Item]) -> None:
    tile = read_heif(heif_file(items)).tiles[0]
    assert_as_libheif(heif_file([tile_item(tile)]))
