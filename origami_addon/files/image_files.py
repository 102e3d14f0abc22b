"""The page as TIFF, PNG and JPEG with their resolution and colour profile: in colour, in grey, or black and white.

Blender's own writer always writes 72 dpi and embeds no profile, and not every Blender has the OpenImageIO module, which
could do better. So this module writes the TIFF, which is a header and the uncompressed pixels (a black and white one is
packed as Group 4), and the PNG, which zlib packs. Blender encodes the JPEG, and this module sets its header segments.
Every Blender therefore writes the same files.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, cast

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core.errors import StepFailed
from .atomic import replacing
from .group4 import group4
from .icc import grey_profile, is_rgb_profile, srgb_profile

_LARGEST_TIFF = 2**32 - 2**16  # bytes of pixels and profile: offsets in the file have 32 bits
_ICC_SEGMENT = 65519  # the most profile bytes that fit into one JPEG segment
_SHORT, _LONG, _RATIONAL, _ASCII, _UNDEFINED = 3, 4, 5, 2, 7
_GROUP_4 = 4  # TIFF's number of that compression
_METRES_PER_INCH = 0.0254
_QUALITY = 92  # of a JPEG, 1 to 100; a choice
_PNG_PIECE = 1 << 24  # bytes of pixels packed at a time

Bits = Literal[8, 16]
# A page in colour (H, W, 3), in grey (H, W), or black and white (H, W) bool with True for white.
PageImage = NDArray[np.unsignedinteger[Any]] | NDArray[np.bool_]


def write_tiff(
    path: Path,
    image: PageImage,
    dpi: float,
    profile: bytes | None = None,
    bits: Bits | None = None,
) -> None:
    """Write a TIFF 6.0: uncompressed, or Group 4 if the image is black and white.

    Parameters
    ----------
    path : Path
    image : (H, W, 3) or (H, W) uint8 or uint16 array, or (H, W) bool array
        In colour, in grey, or black and white, True for white.
    dpi : float
        Pixels per inch, the same both ways.
    profile : bytes, optional
        ICC profile of the pixels in colour; sRGB if it is missing or not an RGB profile. Grey gets a grey profile with
        the same tones, black and white none.
    bits : {8, 16}, optional
        Of each channel in the file; by default those of the image. Eight become sixteen exactly. Black and white always
        has one.

    Raises
    ------
    StepFailed
        If the file could not be written, or would be larger than a TIFF can be.
    """
    height, width = image.shape[:2]
    channels = image.size // (height * width)
    bilevel = image.dtype == np.bool_
    depth = 1 if bilevel else bits or _bits_of(image)
    packed = group4(image == 0) if bilevel else None
    size = image.size * depth // 8 if packed is None else len(packed)
    resolution = struct.pack("<II", round(dpi * 1000), 1000)
    icc = profile_of(image, profile)
    if size + len(icc) > _LARGEST_TIFF:
        raise StepFailed(f"{path.name} would take {size / 2**30:.1f} GiB, but a TIFF holds only 4: choose fewer dpi.")
    header = _tiff_header(
        [
            (256, _LONG, 1, struct.pack("<I", width)),
            (257, _LONG, 1, struct.pack("<I", height)),
            (258, _SHORT, channels, struct.pack(f"<{channels}H", *[depth] * channels)),
            (259, _SHORT, 1, struct.pack("<H", _GROUP_4 if bilevel else 1)),
            (262, _SHORT, 1, struct.pack("<H", 0 if bilevel else 1 if channels == 1 else 2)),
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
            *([(34675, _UNDEFINED, len(icc), icc)] if icc else []),
        ]
    )
    with replacing(path) as temporary, temporary.open("wb") as file:
        file.write(header)
        file.write(_samples(image, depth, "<").data if packed is None else packed)


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
    image: PageImage,
    dpi: float,
    profile: bytes | None = None,
    bits: Bits | None = None,
) -> None:
    """Write a PNG; parameters as for `write_tiff`. Its resolution is stored in whole pixels per metre."""
    icc = profile_of(image, profile)
    color = _png_chunk(b"iCCP", b"ICC profile\0\0" + zlib.compress(icc)) if icc else b""
    _write_png(path, image, dpi, 1 if image.dtype == np.bool_ else bits or _bits_of(image), color)


def write_data_png(path: Path, image: NDArray[np.unsignedinteger[Any]], dpi: float, description: str) -> None:
    """Write a PNG whose values are not colours: without a profile, and with a description (ASCII) of what they are."""
    _write_png(path, image, dpi, _bits_of(image), _png_chunk(b"tEXt", b"Description\0" + description.encode("ascii")))


def _write_png(path: Path, image: PageImage, dpi: float, depth: int, about_values: bytes) -> None:
    height, width = image.shape[:2]
    density = round(dpi / _METRES_PER_INCH)
    with replacing(path) as temporary, temporary.open("wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        color = 0 if image.ndim == 2 else 2
        file.write(_png_chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, color, 0, 0, 0)))
        file.write(about_values)
        file.write(_png_chunk(b"pHYs", struct.pack(">IIB", density, density, 1)))
        for piece in _png_pixels(image, depth):
            file.write(_png_chunk(b"IDAT", piece))
        file.write(_png_chunk(b"IEND", b""))


def _png_chunk(name: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))


def _png_pixels(image: PageImage, depth: int) -> Iterator[bytes]:
    """The packed pixels in pieces, each row as its difference from the one above it (PNG's filter `Up`).

    Rows of black and white are packed as they are.
    """
    kind = 0 if depth == 1 else 2
    length = -(-image[0].size * depth // 8)
    rows = max(1, _PNG_PIECE // length)
    packer = zlib.compressobj()
    above = np.zeros((1, length), np.uint8)
    for first in range(0, len(image), rows):
        part = _samples(image[first : first + rows], depth, ">")
        lines = part.view(np.uint8).reshape(len(part), length)
        filtered = np.full((len(lines), 1 + length), kind, np.uint8)
        if kind:
            np.subtract(lines, np.concatenate([above, lines[:-1]]), out=filtered[:, 1:])
        else:
            filtered[:, 1:] = lines
        above = lines[-1:]
        if piece := packer.compress(filtered.data):
            yield piece
    yield packer.flush()


def write_jpeg(path: Path, image: PageImage, dpi: float, profile: bytes | None = None, quality: int = _QUALITY) -> None:
    """Write a JPEG; parameters as for `write_tiff`, ``quality`` from 1 to 100.

    Sixteen bits become eight, and black and white becomes grey, because a JPEG has nothing less.
    """
    with replacing(path) as temporary:
        temporary.write_bytes(encoded_jpeg(temporary, image, dpi, profile, quality))


def encoded_jpeg(
    scratch: Path, image: PageImage, dpi: float, profile: bytes | None = None, quality: int = _QUALITY
) -> bytes:
    """The content of a JPEG; parameters as for `write_jpeg`. Blender writes it to the place ``scratch`` first."""
    picture = to_blender_image(scratch.name, to_eight_bits(image))
    try:
        if image.ndim == 2:
            with _unchanged_grey(quality) as scene:
                picture.save_render(str(scratch), scene=scene, quality=quality)
        else:
            picture.file_format = "JPEG"
            picture.save(filepath=str(scratch), quality=quality)
        return _with_header(scratch.read_bytes(), dpi, profile_of(image, profile))
    finally:
        bpy.data.images.remove(picture)


@contextmanager
def _unchanged_grey(quality: int) -> Iterator[bpy.types.Scene]:
    """A scene whose settings write an image as a grey JPEG with the same levels; `Image.save` would write colours."""
    scene = bpy.data.scenes.new("grey")
    try:
        settings = scene.render.image_settings
        settings.file_format = "JPEG"
        settings.color_mode = "BW"
        settings.quality = quality
        settings.color_management = "OVERRIDE"  # the scene's own changes the tones
        settings.display_settings.display_device = "sRGB"
        settings.view_settings.view_transform = "Standard"
        yield scene
    finally:
        bpy.data.scenes.remove(scene)


def to_bits(image: NDArray[np.unsignedinteger[Any]], bits: Bits) -> NDArray[np.unsignedinteger[Any]]:
    """The picture with ``bits`` bits per channel: 255 becomes 65535 and back, and every value the nearest one."""
    if bits == 8:
        return to_eight_bits(image)
    if image.dtype == np.uint8:
        return image.astype(np.uint16) * np.uint16(257)
    return image


def to_eight_bits(image: PageImage) -> NDArray[np.uint8]:
    """A uint16 picture rounded to uint8 (65535 becomes 255), black and white as 0 and 255; uint8 unchanged."""
    if image.dtype == np.bool_:
        return image.astype(np.uint8) * np.uint8(255)
    if image.dtype == np.uint16:
        return ((image.astype(np.uint32) + 128) // 257).astype(np.uint8)
    return image.astype(np.uint8, copy=False)


def _samples(image: PageImage, depth: int, order: str) -> NDArray[Any]:
    """The samples of rows as a file has them, in a byte order: ``"<"`` or ``">"``."""
    if depth == 1:
        return np.packbits(image, axis=1)
    levels = cast(NDArray[np.unsignedinteger[Any]], image)
    return to_bits(levels, 8 if depth == 8 else 16).astype(f"{order}u{depth // 8}", order="C", copy=False)


def to_blender_image(name: str, image: NDArray[np.uint8]) -> bpy.types.Image:
    """A new byte image in this .blend with the unchanged pixels, (H, W, 3) or (H, W), interpreted as sRGB."""
    height, width = image.shape[:2]
    picture = bpy.data.images.new(name, width, height, alpha=False)
    pixels = np.ones((height, width, 4), np.float32)
    np.multiply(image[::-1].reshape(height, width, -1), np.float32(1 / 255), out=pixels[..., :3])
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


def _bits_of(image: PageImage) -> Bits:
    return 16 if image.dtype == np.uint16 else 8


def profile_of(image: PageImage, profile: bytes | None) -> bytes:
    """The profile to embed for a page whose colours have ``profile``; empty for black and white, which needs none."""
    if image.dtype == np.bool_:
        return b""
    if image.ndim == 2:
        return grey_profile(profile)
    return profile if profile is not None and is_rgb_profile(profile) else srgb_profile()
