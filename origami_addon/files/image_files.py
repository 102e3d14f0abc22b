"""The page as TIFF, PNG and JPEG with their resolution and colour profile.

Blender's own writer always writes 72 dpi and embeds no profile, and not every Blender has the OpenImageIO module, which
could do better. So this module writes the TIFF, which is a header and the uncompressed pixels, and the PNG, which zlib
packs. Blender encodes the JPEG, and this module sets its header segments. Every Blender therefore writes the same
files.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core.errors import StepFailed
from .atomic import replacing
from .icc import is_rgb_profile, srgb_profile

_LARGEST_TIFF = 2**32 - 2**16  # bytes of pixels and profile: offsets in the file have 32 bits
_ICC_SEGMENT = 65519  # the most profile bytes that fit into one JPEG segment
_SHORT, _LONG, _RATIONAL, _ASCII, _UNDEFINED = 3, 4, 5, 2, 7
_METRES_PER_INCH = 0.0254
_PNG_PIECE = 1 << 24  # bytes of pixels packed at a time

Bits = Literal[8, 16]


def write_tiff(
    path: Path,
    image: NDArray[np.unsignedinteger[Any]],
    dpi: float,
    profile: bytes | None = None,
    bits: Bits | None = None,
) -> None:
    """Write an uncompressed TIFF 6.0.

    Parameters
    ----------
    path : Path
    image : (H, W, 3) uint8 or uint16 array
    dpi : float
        Pixels per inch, the same both ways.
    profile : bytes, optional
        ICC profile of the pixels; sRGB if it is missing or not an RGB profile.
    bits : {8, 16}, optional
        Of each channel in the file; by default those of the image. Eight become sixteen exactly.

    Raises
    ------
    StepFailed
        If the file could not be written, or would be larger than a TIFF can be.
    """
    height, width, channels = image.shape
    bits = bits or _bits_of(image)
    size = image.size * bits // 8
    resolution = struct.pack("<II", round(dpi * 1000), 1000)
    icc = _profile(profile)
    if size + len(icc) > _LARGEST_TIFF:
        raise StepFailed(f"{path.name} would take {size / 2**30:.1f} GiB, but a TIFF holds only 4: choose fewer dpi.")
    header = _tiff_header(
        [
            (256, _LONG, 1, struct.pack("<I", width)),
            (257, _LONG, 1, struct.pack("<I", height)),
            (258, _SHORT, channels, struct.pack(f"<{channels}H", *[bits] * channels)),
            (259, _SHORT, 1, struct.pack("<H", 1)),
            (262, _SHORT, 1, struct.pack("<H", 2)),
            (273, _LONG, 1, b""),
            (274, _SHORT, 1, struct.pack("<H", 1)),
            (277, _SHORT, 1, struct.pack("<H", channels)),
            (278, _LONG, 1, struct.pack("<I", height)),
            (279, _LONG, 1, struct.pack("<I", size)),
            (282, _RATIONAL, 1, resolution),
            (283, _RATIONAL, 1, resolution),
            (284, _SHORT, 1, struct.pack("<H", 1)),
            (296, _SHORT, 1, struct.pack("<H", 2)),
            (305, _ASCII, 8, b"Origami\0"),
            (34675, _UNDEFINED, len(icc), icc),
        ]
    )
    with replacing(path) as temporary, temporary.open("wb") as file:
        file.write(header)
        file.write(to_bits(image, bits).astype(f"<u{bits // 8}", order="C", copy=False).data)


def _tiff_header(entries: list[tuple[int, int, int, bytes]]) -> bytes:
    """Header and directory for entries ``(tag, type, count, value)``; the pixels must follow directly.

    The value of tag 273, where the pixels begin, is filled in.
    """
    behind = 8 + 2 + 12 * len(entries) + 4
    extra = b"".join(value + bytes(-len(value) % 2) for *_, value in entries if len(value) > 4)
    pixels = behind + len(extra)
    directory = struct.pack("<H", len(entries))
    for tag, kind, count, value in entries:
        if tag == 273:
            value = struct.pack("<I", pixels)
        if len(value) > 4:
            directory += struct.pack("<HHII", tag, kind, count, behind)
            behind += len(value) + len(value) % 2
        else:
            directory += struct.pack("<HHI4s", tag, kind, count, value)
    return b"II*\0" + struct.pack("<I", 8) + directory + bytes(4) + extra


def write_png(
    path: Path,
    image: NDArray[np.unsignedinteger[Any]],
    dpi: float,
    profile: bytes | None = None,
    bits: Bits | None = None,
) -> None:
    """Write a PNG; parameters as for `write_tiff`. Its resolution is stored in whole pixels per metre."""
    color = _png_chunk(b"iCCP", b"ICC profile\0\0" + zlib.compress(_profile(profile)))
    _write_png(path, image, dpi, bits or _bits_of(image), color)


def write_data_png(path: Path, image: NDArray[np.unsignedinteger[Any]], dpi: float, description: str) -> None:
    """Write a PNG whose values are not colours: without a profile, and with a description (ASCII) of what they are."""
    _write_png(path, image, dpi, _bits_of(image), _png_chunk(b"tEXt", b"Description\0" + description.encode("ascii")))


def _write_png(
    path: Path, image: NDArray[np.unsignedinteger[Any]], dpi: float, bits: Bits, about_values: bytes
) -> None:
    height, width, _ = image.shape
    density = round(dpi / _METRES_PER_INCH)
    with replacing(path) as temporary, temporary.open("wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        file.write(_png_chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, 2, 0, 0, 0)))
        file.write(about_values)
        file.write(_png_chunk(b"pHYs", struct.pack(">IIB", density, density, 1)))
        for piece in _png_pixels(image, bits):
            file.write(_png_chunk(b"IDAT", piece))
        file.write(_png_chunk(b"IEND", b""))


def _png_chunk(name: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))


def _png_pixels(image: NDArray[np.unsignedinteger[Any]], bits: Bits) -> Iterator[bytes]:
    """The packed pixels in pieces, each row as its difference from the one above it (PNG's filter `Up`)."""
    height, width, channels = image.shape
    length = width * channels * bits // 8
    rows = max(1, _PNG_PIECE // length)
    packer = zlib.compressobj()
    above = np.zeros((1, length), np.uint8)
    for first in range(0, height, rows):
        part = to_bits(image[first : first + rows], bits).astype(f">u{bits // 8}", order="C", copy=False)
        lines = part.view(np.uint8).reshape(len(part), length)
        filtered = np.full((len(lines), 1 + length), 2, np.uint8)  # 2 names the filter
        np.subtract(lines, np.concatenate([above, lines[:-1]]), out=filtered[:, 1:])
        above = lines[-1:]
        if piece := packer.compress(filtered.data):
            yield piece
    yield packer.flush()


def write_jpeg(
    path: Path, image: NDArray[np.unsignedinteger[Any]], dpi: float, profile: bytes | None = None, quality: int = 92
) -> None:
    """Write a JPEG; parameters as for `write_tiff`, ``quality`` from 1 to 100. Sixteen bits become eight."""
    picture = to_blender_image(path.name, to_eight_bits(image))
    try:
        with replacing(path) as temporary:
            picture.file_format = "JPEG"
            picture.save(filepath=str(temporary), quality=quality)
            temporary.write_bytes(_with_header(temporary.read_bytes(), dpi, _profile(profile)))
    finally:
        bpy.data.images.remove(picture)


def to_bits(image: NDArray[np.unsignedinteger[Any]], bits: Bits) -> NDArray[np.unsignedinteger[Any]]:
    """The picture with ``bits`` bits per channel: 255 becomes 65535 and back, and every value the nearest one."""
    if bits == 8:
        return to_eight_bits(image)
    if image.dtype == np.uint8:
        return image.astype(np.uint16) * np.uint16(257)
    return image


def to_eight_bits(image: NDArray[np.unsignedinteger[Any]]) -> NDArray[np.uint8]:
    """A uint16 picture rounded to uint8 (65535 becomes 255); a uint8 picture unchanged."""
    if image.dtype == np.uint16:
        return ((image.astype(np.uint32) + 128) // 257).astype(np.uint8)
    return image.astype(np.uint8, copy=False)


def to_blender_image(name: str, image: NDArray[np.uint8]) -> bpy.types.Image:
    """A new byte image in this .blend with the unchanged pixels (H, W, 3), interpreted as sRGB."""
    height, width, _ = image.shape
    picture = bpy.data.images.new(name, width, height, alpha=False)
    pixels = np.ones((height, width, 4), np.float32)
    np.multiply(image[::-1], np.float32(1 / 255), out=pixels[..., :3])
    picture.pixels.foreach_set(pixels.reshape(-1))
    picture.update()
    return picture


def from_blender_image(picture: bpy.types.Image) -> NDArray[np.uint8]:
    """The unchanged pixels (H, W, 3) of a byte image."""
    width, height = picture.size
    pixels = np.empty(height * width * picture.channels, np.float32)
    picture.pixels.foreach_get(pixels)
    rgb = pixels.reshape(height, width, picture.channels)[::-1, :, :3]
    return np.rint(rgb * np.float32(255)).astype(np.uint8)


def _with_header(jpeg: bytes, dpi: float, icc: bytes) -> bytes:
    """The JPEG with this resolution and profile instead of its own."""
    density = max(1, min(65535, round(dpi)))
    head = b"\xff\xd8\xff\xe0" + struct.pack(">H5sHBHHBB", 16, b"JFIF\0", 0x0101, 1, density, density, 0, 0)
    chunks = [icc[start : start + _ICC_SEGMENT] for start in range(0, len(icc), _ICC_SEGMENT)]
    for number, chunk in enumerate(chunks, 1):
        head += struct.pack(">BBH12sBB", 0xFF, 0xE2, len(chunk) + 16, b"ICC_PROFILE\0", number, len(chunks)) + chunk
    position = 2
    while jpeg[position + 1] in (0xE0, 0xE2):
        position += 2 + struct.unpack_from(">H", jpeg, position + 2)[0]
    return head + jpeg[position:]


def _bits_of(image: NDArray[np.unsignedinteger[Any]]) -> Bits:
    return 16 if image.dtype == np.uint16 else 8


def _profile(profile: bytes | None) -> bytes:
    return profile if profile is not None and is_rgb_profile(profile) else srgb_profile()
