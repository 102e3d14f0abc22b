"""Bad files among good photos: each is left out with a sentence that says why, or used."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from command_line import USED
from PIL import Image


def jpeg(**options: object) -> bytes:
    return encoded("JPEG", **options)


def encoded(kind: str, mode: str = "RGB", **options: object) -> bytes:
    noise = np.random.default_rng(1).integers(0, 256, (120, 160, 3), np.uint8)
    file = io.BytesIO()
    Image.fromarray(noise).convert(mode).save(file, kind, **options)
    return file.getvalue()


def part(content: bytes, share: float) -> bytes:
    return content[: int(share * len(content))]


def with_bytes(content: bytes, at: int, new: bytes) -> bytes:
    return content[:at] + new + content[at + len(new) :]


def of_size(content: bytes, width: int, height: int) -> bytes:
    """A JPEG whose header states another size."""
    at = content.index(b"\xff\xc0") + 5
    return with_bytes(content, at, struct.pack(">HH", height, width))


def png(width: int, height: int, depth: int = 8, data: bytes = b"", more: bytes = b"") -> bytes:
    def chunk(name: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + more + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b"")


def with_exif(*entries: tuple[int, int, int, int], then: int = 0) -> bytes:
    """A JPEG with these entries (tag, type, count, value) in the first folder of its EXIF."""
    folder = struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", *entry) for entry in entries)
    exif = b"Exif\0\0II*\0\x08\0\0\0" + folder + struct.pack("<I", then) + bytes(64)
    content = jpeg()
    return content[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + content[2:]


def tiff(*entries: tuple[int, int, int, int], then: int = 0, then_data: bytes = bytes(64)) -> bytes:
    folder = struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", *entry) for entry in entries)
    return b"II*\0\x08\0\0\0" + folder + struct.pack("<I", then) + then_data


def usual(width: int, height: int, at: int = 200, size: int = 57600) -> list[tuple[int, int, int, int]]:
    """The entries of an uncompressed TIFF in grey."""
    return [
        (256, 4, 1, width),
        (257, 4, 1, height),
        (258, 3, 1, 8),
        (259, 3, 1, 1),
        (262, 3, 1, 1),
        (273, 4, 1, at),
        (277, 3, 1, 1),
        (278, 4, 1, height),
        (279, 4, 1, size),
    ]


CUT, DAMAGED, NONE, HUGE, OTHER = "cut short", "damaged", "decoded", "more than any camera", "does not read"
OUT_OF_PLACE = "is left out"
# The name of a file beside three good ones, its content, and words of the sentence about it; none if it is used.
FILES: list[tuple[str, Callable[[], bytes], str]] = [
    ("empty.jpg", lambda: b"", "is empty"),
    ("one.jpg", lambda: b"\xff", NONE),
    ("random.jpg", lambda: np.random.default_rng(2).bytes(5000), NONE),
    ("text.jpg", lambda: b"not a photo\n" * 50, NONE),
    ("zeros.jpg", lambda: bytes(5000), NONE),
    ("soi_eoi.jpg", lambda: b"\xff\xd8\xff\xd9", OUT_OF_PLACE),
    ("soi.jpg", lambda: b"\xff\xd8\xff\xe0", OUT_OF_PLACE),
    *[(f"cut{cut}.jpg", lambda cut=cut: part(jpeg(), cut / 100), OUT_OF_PLACE) for cut in (1, 5, 20, 50, 80, 99)],
    *[(f"cut_eoi{cut}.jpg", lambda cut=cut: part(jpeg(), cut / 100) + b"\xff\xd9", OUT_OF_PLACE) for cut in (5, 20)],
    *[
        (f"progressive{cut}.jpg", lambda cut=cut: part(jpeg(progressive=True), cut / 100), OUT_OF_PLACE)
        for cut in (5, 50, 95)
    ],
    ("junk_behind.jpg", lambda: jpeg() + bytes(1000), ""),
    ("height0.jpg", lambda: of_size(jpeg(), 160, 0), OUT_OF_PLACE),
    ("width0.jpg", lambda: of_size(jpeg(), 0, 120), OUT_OF_PLACE),
    ("huge.jpg", lambda: of_size(jpeg(), 65500, 65500), OUT_OF_PLACE),
    ("small.jpg", lambda: encoded_small("JPEG"), "too small"),
    ("small.png", lambda: encoded_small("PNG"), "too small"),
    ("no_tables.jpg", lambda: jpeg().replace(b"\xff\xdb", b"\xff\xec"), OUT_OF_PLACE),
    ("grey.jpg", lambda: jpeg(mode="L"), ""),
    ("bad_profile.jpg", lambda: jpeg(icc_profile=b"\1" * 300), ""),
    ("jpeg.png", jpeg, ""),
    ("png.jpg", lambda: encoded("PNG"), ""),
    ("webp.jpg", lambda: encoded("WEBP"), ""),
    ("tiff.jpg", lambda: encoded("TIFF"), ""),
    ("gif.jpg", lambda: encoded("GIF"), OTHER),
    ("bmp.jpg", lambda: encoded("BMP"), OTHER),
    ("bmp_huge.jpg", lambda: with_bytes(encoded("BMP"), 18, struct.pack("<ii", 60000, 60000)), OTHER),
    ("icon.jpg", lambda: encoded("ICO"), OUT_OF_PLACE),
    ("photoshop.jpg", lambda: b"8BPS\0\1" + bytes(200), OUT_OF_PLACE),
    ("openexr.jpg", lambda: b"\x76\x2f\x31\x01" + bytes(200), OUT_OF_PLACE),
    ("radiance.jpg", lambda: b"#?RADIANCE\n" + bytes(200), OUT_OF_PLACE),
    ("dpx.jpg", lambda: b"SDPX" + bytes(3000), OUT_OF_PLACE),
    ("svg.jpg", lambda: b"<svg xmlns='http://www.w3.org/2000/svg'/>", OUT_OF_PLACE),
    ("pdf.jpg", lambda: encoded("PDF"), OUT_OF_PLACE),
    ("jpeg2000.jpg", lambda: encoded("JPEG2000"), OUT_OF_PLACE),
    ("movie.jpg", lambda: b"\0\0\0\x18ftypmp42" + bytes(300), OUT_OF_PLACE),
    ("heic.jpg", lambda: b"\0\0\0\x18ftypheic\0\0\0\0mif1heic" + bytes(300), OUT_OF_PLACE),
    ("heic_endless.heic", lambda: b"\0\0\0\x18ftypheic\0\0\0\0mif1heic" + b"\0\0\0\x08meta" * 200, OUT_OF_PLACE),
    ("heic_size0.heic", lambda: b"\0\0\0\x18ftypheic\0\0\0\0mif1heic\0\0\0\0meta" + bytes(99), OUT_OF_PLACE),
    ("heic_size64.heic", lambda: b"\0\0\0\x18ftypheic\0\0\0\0mif1heic\0\0\0\1meta" + b"\xff" * 99, OUT_OF_PLACE),
    ("avif.avif", lambda: b"\0\0\0\x18ftypavif\0\0\0\0mif1avif" + bytes(300), OUT_OF_PLACE),
    ("raw.dng", lambda: tiff((50706, 1, 4, 1), (256, 4, 1, 10)), "RAW"),
    ("raw.cr2", lambda: np.random.default_rng(3).bytes(300), "RAW"),
    *[(f"cut{cut}.png", lambda cut=cut: part(encoded("PNG"), cut / 100), OUT_OF_PLACE) for cut in (1, 20, 60, 98)],
    ("checksum.png", lambda: with_bytes(encoded("PNG"), 500, b"\0\0\0\0\0\0"), OUT_OF_PLACE),
    ("lie.png", lambda: png(65500, 65500), OUT_OF_PLACE),
    ("lie2g.png", lambda: png(2**31 - 1, 2**31 - 1, 16), OUT_OF_PLACE),
    ("bomb.png", lambda: png(20000, 20000, data=bytes(20000)), OUT_OF_PLACE),
    ("zero_size.png", lambda: png(0, 0), OUT_OF_PLACE),
    ("no_data.png", lambda: png(200, 200), OUT_OF_PLACE),
    ("depth3.png", lambda: png(200, 200, 3), OUT_OF_PLACE),
    ("chunk_beyond.png", lambda: png(200, 200, more=b"\xff\xff\xff\xffiCCP"), OUT_OF_PLACE),
    ("grey.png", lambda: encoded("PNG", mode="L"), ""),
    ("transparent.png", lambda: encoded("PNG", mode="RGBA"), ""),
    ("palette.png", lambda: encoded("PNG", mode="P"), ""),
    ("bits.png", lambda: encoded("PNG", mode="1"), ""),
    *[(f"cut{cut}.webp", lambda cut=cut: part(encoded("WEBP"), cut / 100), OUT_OF_PLACE) for cut in (5, 50, 95)],
    *[(f"cut{cut}.tif", lambda cut=cut: part(encoded("TIFF"), cut / 100), OUT_OF_PLACE) for cut in (1, 50, 95)],
    ("to_itself.tif", lambda: tiff(*usual(160, 120), then=8, then_data=bytes([9]) * 30000), ""),
    ("exif_to_itself.tif", lambda: tiff(*usual(160, 120), (34665, 4, 1, 8), then_data=bytes([8]) * 30000), ""),
    ("huge.tif", lambda: tiff(*usual(2**31 - 1, 2**31 - 1)), OUT_OF_PLACE),
    ("wide.tif", lambda: tiff(*usual(60000, 60000)), OUT_OF_PLACE),
    ("strip_beyond.tif", lambda: tiff(*usual(160, 120, at=2**32 - 16, size=2**32 - 1)), OUT_OF_PLACE),
    ("strips.tif", lambda: tiff(*usual(160, 120)[:5], (273, 4, 2**32 - 1, 8), (279, 4, 2**32 - 1, 8)), OUT_OF_PLACE),
    ("no_entries.tif", lambda: tiff(), OUT_OF_PLACE),
    ("count.tif", lambda: b"II*\0\x08\0\0\0\xff\xff" + bytes(99), OUT_OF_PLACE),
    ("offset.tif", lambda: b"II*\0\xff\xff\xff\xff" + bytes(99), OUT_OF_PLACE),
    ("big.tif", lambda: b"II+\0\x08\0\0\0" + struct.pack("<QQ", 16, 2**60) + bytes(99), OUT_OF_PLACE),
    ("exif_to_itself.jpg", lambda: with_exif(*[(0x8769, 4, 1, 8)] * 500), ""),
    ("exif_next.jpg", lambda: with_exif((0x10F, 2, 4, 0), then=8), ""),
    ("exif_count.jpg", lambda: with_exif((0x10F, 2, 2**32 - 1, 8), (0x110, 12, 2**32 - 1, 8)), ""),
    ("exif_beyond.jpg", lambda: with_exif((0x10F, 2, 100, 2**32 - 1)), ""),
    ("exif_focal0.jpg", lambda: with_exif((0x920A, 5, 1, 40), (0xA405, 3, 1, 0)), ""),
    ("exif_focal.jpg", lambda: with_exif((0x8769, 4, 1, 8), (0xA405, 3, 1, 65535)), ""),
    ("exif_type.jpg", lambda: with_exif((0x112, 99, 1, 3), (0x10F, 0, 0, 0)), ""),
    ("exif_turn.jpg", lambda: with_exif((0x112, 3, 1, 999)), ""),
    ("exif_mirrored.jpg", lambda: with_exif((0x112, 3, 1, 2)), "mirrored"),
]


def encoded_small(kind: str) -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (60, 40)).save(file, kind)
    return file.getvalue()


@pytest.mark.parametrize(("name", "content", "words"), FILES, ids=[name for name, *_ in FILES])
def test_a_file_among_photos(
    ends: Callable[..., tuple[int, str]],
    good: Path,
    tmp_path: Path,
    name: str,
    content: Callable[[], bytes],
    words: str,
) -> None:
    (tmp_path / name).write_bytes(content())
    code, said = ends(good, tmp_path / name, "-o", tmp_path / "out")
    assert code == 5
    assert said.endswith(f"error: {USED}\n")
    assert words in said
    assert (name in said) == bool(words)
