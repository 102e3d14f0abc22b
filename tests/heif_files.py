"""Writes HEIC and AVIF files as phones do: grids of tiles with properties, and other pictures beside them."""

from __future__ import annotations

import io
import struct
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from origami.origami_addon.files.heif import Tile, read_heif
from PIL import Image

_REFERENCES = {b"Exif": b"cdsc", b"hvc1": b"thmb"}


@dataclass(frozen=True)
class Item:
    """One picture, or something else, of a file.

    Attributes
    ----------
    kind : bytes
    content : bytes
    properties : tuple of bytes
        Whole boxes.
    references : tuple
        Kind, and numbers of the items.
    """

    kind: bytes
    content: bytes
    properties: tuple[bytes, ...] = ()
    references: tuple[tuple[bytes, tuple[int, ...]], ...] = field(default=())


def box(kind: bytes, *content: bytes) -> bytes:
    joined = b"".join(content)
    return struct.pack(">I4s", 8 + len(joined), kind) + joined


def full_box(kind: bytes, version: int, *content: bytes) -> bytes:
    return box(kind, struct.pack(">I", version << 24), *content)


def turn(quarters: int) -> bytes:
    return box(b"irot", bytes([quarters]))


def mirror(axis: int) -> bytes:
    return box(b"imir", bytes([axis]))


def crop(width: int, height: int, right: int = 0, down: int = 0) -> bytes:
    """Offsets are those of the middle, in half pixels."""
    return box(b"clap", struct.pack(">IIIIiIiI", width, 1, height, 1, right, 2, down, 2))


def size_property(width: int, height: int) -> bytes:
    return full_box(b"ispe", 0, struct.pack(">II", width, height))


def code_points(primaries: int, transfer: int, matrix: int, full: bool) -> bytes:
    return box(b"colr", b"nclx", struct.pack(">HHHB", primaries, transfer, matrix, full << 7))


def profile(icc: bytes) -> bytes:
    return box(b"colr", b"prof", icc)


def exif_item(exif: bytes, of: int) -> Item:
    return Item(b"Exif", bytes(4) + exif, (), ((b"cdsc", (of,)),))


def encoded(picture: NDArray[np.uint8], kind: str = "heic", **options: object) -> bytes:
    """The picture as HEIC or AVIF, by the library of another project."""
    buffer = io.BytesIO()
    image = Image.fromarray(picture)
    if kind == "avif":
        image.save(buffer, "AVIF", speed=10, **options)
    else:
        import pillow_heif

        options = {"quality": 90, "enc_params": {"preset": "ultrafast"}} | options
        pillow_heif.from_pillow(image).save(buffer, **options)
    return buffer.getvalue()


def tile_item(tile: Tile, *properties: bytes) -> Item:
    configuration = box(b"hvcC" if tile.codec == b"hvc1" else b"av1C", tile.configuration)
    return Item(tile.codec, tile.coded, (configuration, size_property(tile.width, tile.height), *properties))


def grid(
    picture: NDArray[np.uint8],
    tile_width: int,
    tile_height: int,
    *properties: bytes,
    kind: str = "heic",
    **options: object,
) -> list[Item]:
    """The items of a picture cut into tiles; the last one is the grid, with these properties."""
    height, width = picture.shape[:2]
    rows, columns = -(-height // tile_height), -(-width // tile_width)
    padding = ((0, rows * tile_height - height), (0, columns * tile_width - width), (0, 0))
    padded = np.pad(picture, padding, mode="edge")
    tiles = []
    for row in range(rows):
        for column in range(columns):
            top, left = row * tile_height, column * tile_width
            part = np.ascontiguousarray(padded[top : top + tile_height, left : left + tile_width])
            tiles.append(tile_item(read_heif(encoded(part, kind, **options)).tiles[0], code_points(1, 13, 6, True)))
    content = struct.pack(">4BHH", 0, 0, rows - 1, columns - 1, width, height)
    numbers = tuple(range(1, len(tiles) + 1))
    return [*tiles, Item(b"grid", content, (size_property(width, height), *properties), ((b"dimg", numbers),))]


def heif_file(items: Sequence[Item], primary: int = 0, brand: bytes = b"heic") -> bytes:
    """The file that holds the items, numbered from 1; the last one is the photo unless ``primary`` says otherwise."""
    primary = primary or len(items)
    boxes = list(dict.fromkeys(each for item in items for each in item.properties))
    start = box(b"ftyp", brand, bytes(4), b"mif1", brand)
    handler = full_box(b"hdlr", 0, bytes(4), b"pict", bytes(13))
    kinds = b"".join(full_box(b"infe", 2, struct.pack(">HH4sB", n, 0, i.kind, 0)) for n, i in enumerate(items, 1))
    associations = b""
    for number, item in enumerate(items, 1):
        associations += struct.pack(">HB", number, len(item.properties))
        associations += b"".join(struct.pack(">B", 1 + boxes.index(each)) for each in item.properties)
    references = b"".join(
        box(kind, struct.pack(f">HH{len(to)}H", number, len(to), *to))
        for number, item in enumerate(items, 1)
        for kind, to in item.references
    )

    def meta(media_start: int) -> bytes:
        places, at = b"", media_start
        for number, item in enumerate(items, 1):
            places += struct.pack(">HHHII", number, 0, 1, at, len(item.content))
            at += len(item.content)
        return full_box(
            b"meta",
            0,
            handler,
            full_box(b"pitm", 0, struct.pack(">H", primary)),
            full_box(b"iinf", 0, struct.pack(">H", len(items)), kinds),
            full_box(b"iloc", 0, struct.pack(">BBH", 0x44, 0, len(items)), places),
            box(b"iprp", box(b"ipco", *boxes), full_box(b"ipma", 0, struct.pack(">I", len(items)), associations)),
            full_box(b"iref", 0, references),
        )

    return start + meta(len(start) + len(meta(0)) + 8) + box(b"mdat", *(item.content for item in items))
