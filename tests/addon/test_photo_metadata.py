"""What a photo's file says of itself, whatever wrote it and however damaged it is."""

from __future__ import annotations

import io
import struct

import numpy as np
import pytest
from origami.origami_addon.files.photo_metadata import Metadata, read_metadata
from PIL import Image, ImageCms
from PIL.TiffImagePlugin import IFDRational

SIZE = (600, 400)
PROFILE = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
KINDS = ("JPEG", "PNG", "WEBP", "TIFF")


def photo(kind: str = "JPEG", exif: dict[int, object] | None = None, icc_profile: bytes | None = None) -> bytes:
    """A file of a kind, its EXIF tags as given; those from 0x8800 on in the EXIF folder."""
    tags = Image.Exif()
    for tag, value in (exif or {}).items():
        (tags.get_ifd(0x8769) if tag > 0x8800 else tags)[tag] = value
    if kind == "TIFF":  # Pillow writes no EXIF folder into it; EXIF is built as a TIFF file is
        if icc_profile is not None:
            tags[0x8773] = icc_profile
        return tags.tobytes().removeprefix(b"Exif\0\0")
    file = io.BytesIO()
    noise = np.random.default_rng(0).integers(0, 255, (SIZE[1], SIZE[0], 3), np.uint8)
    Image.fromarray(noise).save(file, kind, exif=tags, icc_profile=icc_profile)
    return file.getvalue()


def tiff(*entries: tuple[int, int, int, bytes], order: str = "<") -> bytes:
    """A TIFF structure of one folder; entries of tag, type, count and four bytes of value."""
    head = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "IH", 8, len(entries))
    return head + b"".join(struct.pack(order + "HHI", *entry[:3]) + entry[3] for entry in entries) + b"\0" * 4


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_file_gives_the_same(kind):
    exif = {0x010F: "Maker", 0x0110: "Model 1", 0x0112: 6, 0x9003: "2014:05:11 10:20:05", 0xA405: 28}
    found = read_metadata(photo(kind, exif, icc_profile=PROFILE))
    assert (found.make, found.model, found.taken) == ("Maker", "Model 1", "2014:05:11 10:20:05")
    assert found.orientation == 6
    assert found.icc_profile == PROFILE
    assert found.whole
    assert found.focal_length_pixels(*SIZE) == pytest.approx(28 / 43.267 * np.hypot(*SIZE))


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_that_says_nothing(kind):
    found = read_metadata(photo(kind))
    assert (found.orientation, found.make, found.model, found.taken) == (1, "", "", "")
    assert found.icc_profile is None
    assert found.whole
    assert found.focal_length_pixels(*SIZE) is None


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "WEBP"])
def test_a_file_that_is_cut_short(kind):
    content = photo(kind, {0x0112: 3})
    for share in (0.5, 0.95):
        cut = read_metadata(content[: int(share * len(content))])
        assert not cut.whole


def test_a_profile_in_several_parts_is_put_together():
    # one part of a JPEG holds 64 kB
    profile = PROFILE + bytes(range(256)) * 400
    assert read_metadata(photo(icc_profile=profile)).icc_profile == profile


def test_the_time_of_the_last_change_stands_in_for_that_of_the_photo():
    assert read_metadata(photo(exif={0x0132: "2020:01:02 03:04:05"})).taken == "2020:01:02 03:04:05"
    both = {0x0132: "2020:01:02 03:04:05", 0x9003: "2019:01:02 03:04:05"}
    assert read_metadata(photo(exif=both)).taken == "2019:01:02 03:04:05"


def metadata_with(**tags: object) -> Metadata:
    return Metadata(1, "", "", "", None, True, tags)


@pytest.mark.parametrize(("unit", "millimetres"), [(2, 25.4), (3, 10.0), (4, 1.0)])
def test_a_focal_length_on_a_sensor_of_known_resolution(unit, millimetres):
    of_sensor = {"focal_length": 5.0, "plane_resolution": 1000.0, "plane_unit": unit}
    found = metadata_with(**of_sensor, width=4000, height=3000)
    assert found.focal_length_pixels(4000, 3000) == pytest.approx(5000 / millimetres)
    # the same photo, reduced and turned
    assert found.focal_length_pixels(1500, 2000) == pytest.approx(2500 / millimetres)


@pytest.mark.parametrize("missing", ["focal_length", "plane_resolution", "width"])
def test_a_focal_length_of_which_a_part_is_missing(missing):
    tags: dict[str, object] = {"focal_length": 5.0, "plane_resolution": 1000.0, "plane_unit": 3, "width": 4000}
    assert metadata_with(**tags).focal_length_pixels(4000, 3000) is not None
    tags.pop(missing)
    assert metadata_with(**tags).focal_length_pixels(4000, 3000) is None


def test_an_equivalent_focal_length_of_nothing_is_none():
    assert metadata_with(focal_length_35mm=0).focal_length_pixels(*SIZE) is None
    assert read_metadata(photo(exif={0x920A: IFDRational(0, 0)})).focal_length_pixels(*SIZE) is None


@pytest.mark.parametrize("order", ["<", ">"])
def test_both_orders_of_bytes(order):
    value = struct.pack(order + "HH", 8, 0)
    assert read_metadata(tiff((0x0112, 3, 1, value), order=order)).orientation == 8


def test_a_tag_of_another_type_is_none():
    assert read_metadata(tiff((0x0112, 2, 2, b"6\0\0\0"), (0x010F, 2, 4, b"Ab\0\0"))).orientation == 1
    number_for_text = read_metadata(tiff((0x010F, 3, 1, b"\7\0\0\0"), (0x0112, 3, 1, b"\6\0\0\0")))
    assert (number_for_text.make, number_for_text.orientation) == ("", 6)


def test_an_orientation_that_is_none():
    assert read_metadata(tiff((0x0112, 3, 1, b"\x63\0\0\0"))).orientation == 1


def test_what_comes_before_a_break_counts():
    # the text would begin beyond the end of the file
    found = read_metadata(
        tiff((0x0112, 3, 1, b"\6\0\0\0"), (0x010F, 2, 90, b"\xff\xff\0\0"), (0x0110, 2, 2, b"X\0\0\0"))
    )
    assert (found.orientation, found.make, found.model) == (6, "", "")


@pytest.mark.parametrize(
    "content", [b"", b"\xff\xd8", b"\x89PNG\r\n\x1a\n", b"RIFF\0\0\0\0WEBP", b"II*\0", b"no photo"]
)
def test_what_is_no_photo(content):
    found = read_metadata(content)
    assert (found.orientation, found.make, found.icc_profile) == (1, "", None)
