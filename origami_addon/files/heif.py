"""The boxes of a HEIC or AVIF file: where its photo's coded parts are, and how they become the picture.

Sources: ISO/IEC 14496-12 (boxes and items) and 23008-12 (pictures as items; HEIF). Every size and count is compared
with what the file can hold before memory is taken.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from . import av1, hevc
from .heif_colour import HDR_TRANSFERS, UNSPECIFIED, Colour, profile_of

# Kinds of coded pictures that Blender's ffmpeg decodes, with the property that configures their decoder.
CONFIGURATIONS = {b"hvc1": b"hvcC", b"av01": b"av1C"}
_SIZES = {b"hvc1": hevc.sizes, b"av01": av1.sizes}
_DEEP = {b"hvc1": hevc.is_deep, b"av01": av1.is_deep}
# The largest sensors in phones have 200 megapixels.
MOST_PIXELS = 2**28
_TRANSFORMATIONS = (b"clap", b"irot", b"imir")
DAMAGED = "is damaged and is left out: copy it again."
CUT_SHORT = "is cut short and is left out: copy it again."
_UNKNOWN = "is packed in a way that Origami cannot read ({}) and is left out: save it as JPEG to use it."

Box = tuple[bytes, int, int]


class HeifError(Exception):
    """The photo cannot be read; the text continues a sentence that begins with the file's name."""


@dataclass(frozen=True)
class Tile:
    """One coded picture.

    Attributes
    ----------
    codec : bytes
        One of `CONFIGURATIONS`.
    configuration : bytes
        Content of the box that configures the decoder.
    width, height : int
        Pixels.
    deep : bool
        More than 8 bits for each colour.
    coded : bytes
    """

    codec: bytes
    configuration: bytes
    width: int
    height: int
    deep: bool
    coded: bytes


@dataclass(frozen=True)
class Transformation:
    """What a reader does to the assembled picture.

    Attributes
    ----------
    kind : bytes
        ``clap``: crop, ``irot``: turn, ``imir``: mirror.
    values : tuple of int
        Crop: left, top, width, height in pixels. Turn: quarter turns anticlockwise. Mirror: 0 if top and bottom change
        places, 1 if left and right do.
    """

    kind: bytes
    values: tuple[int, ...]


@dataclass(frozen=True)
class Heif:
    """The photo of a file.

    Attributes
    ----------
    tiles : list of Tile
        Row by row; a single one if the picture is not divided. All have the size of the first.
    columns : int
        Tiles in a row.
    width, height : int
        Of the assembled picture, which the last tile of a row or column may exceed.
    transformations : list of Transformation
        In order.
    exif : bytes
        A TIFF structure; empty if missing.
    icc_profile : bytes
        Of the pixels; empty means sRGB.
    """

    tiles: list[Tile]
    columns: int
    width: int
    height: int
    transformations: list[Transformation]
    exif: bytes
    icc_profile: bytes


def read_heif(data: bytes) -> Heif:
    """The photo in a HEIC or AVIF file; thumbnails, depth, gain maps and other pictures beside it are ignored.

    Parameters
    ----------
    data : bytes
        The whole file.

    Raises
    ------
    HeifError
        If the file is damaged, cut short, contradicts itself, or holds a kind of picture that cannot be decoded.
    """
    try:
        return _Items(data).photo()
    except (struct.error, IndexError, KeyError) as error:
        raise HeifError(DAMAGED) from error


def boxes(data: bytes, start: int, end: int) -> Iterator[Box]:
    """Kind, start and end of the content of each box in a part of the file.

    Raises
    ------
    HeifError
        If a box is longer than the part.
    """
    while end - start >= 8:
        size, kind = struct.unpack_from(">I4s", data, start)
        header = 8
        if size == 1 and end - start >= 16:
            size, header = struct.unpack_from(">Q", data, start + 8)[0], 16
        elif size == 0:
            size = end - start
        if not header <= size <= end - start:
            raise HeifError(DAMAGED)
        yield kind, start + header, start + size
        start += size


class _Fields:
    """Reads whole numbers one after the other from a box."""

    def __init__(self, data: bytes, start: int, end: int) -> None:
        self._data, self.at, self._end = data, start, end
        self.version, self.flags = self.number(1), self.number(3)

    def number(self, size: int) -> int:
        if self.at + size > self._end:
            raise HeifError(DAMAGED)
        self.at += size
        return int.from_bytes(self._data[self.at - size : self.at], "big")


class _Items:
    """The items of a file's `meta` box, and what it says of them."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._primary = 0
        self._kinds: dict[int, bytes] = {}
        self._places: dict[int, tuple[int, list[tuple[int, int]]]] = {}
        self._properties: list[Box] = []
        self._of_item: dict[int, list[int]] = {}
        self._references: dict[tuple[bytes, int], list[int]] = {}
        self._inline: tuple[int, int] = (0, 0)
        start, end = self._meta()
        readers = {
            b"pitm": self._read_primary,
            b"iinf": self._read_kinds,
            b"iloc": self._read_places,
            b"iprp": self._read_properties,
            b"iref": self._read_references,
        }
        for kind, first, last in boxes(data, start + 4, end):
            if kind == b"idat":
                self._inline = (first, last)
            elif kind in readers:
                readers[kind](first, last)

    def _meta(self) -> tuple[int, int]:
        """Where the `meta` box is; phones append boxes and bytes of their own behind it, which do not matter."""
        start, kinds = 0, set()
        while len(self._data) - start >= 8:
            try:
                kind, first, last = next(boxes(self._data, start, len(self._data)))
            except HeifError as error:
                raise HeifError(CUT_SHORT) from error
            if kind == b"meta":
                return first, last
            kinds.add(kind)
            start = last
        if b"moov" in kinds:
            raise HeifError("holds a moving picture instead of a photo and is left out: save one of its pictures.")
        raise HeifError(CUT_SHORT)

    def _read_primary(self, start: int, end: int) -> None:
        fields = _Fields(self._data, start, end)
        self._primary = fields.number(2 if fields.version == 0 else 4)

    def _read_kinds(self, start: int, end: int) -> None:
        fields = _Fields(self._data, start, end)
        fields.number(2 if fields.version == 0 else 4)
        for kind, first, last in boxes(self._data, fields.at, end):
            if kind == b"infe":
                entry = _Fields(self._data, first, last)
                if entry.version >= 2:
                    item = entry.number(2 if entry.version == 2 else 4)
                    entry.number(2)
                    self._kinds[item] = entry.number(4).to_bytes(4, "big")

    def _read_places(self, start: int, end: int) -> None:
        fields = _Fields(self._data, start, end)
        sizes = fields.number(2)
        offset_size, length_size, base_size = sizes >> 12, sizes >> 8 & 15, sizes >> 4 & 15
        index_size = sizes & 15 if fields.version in (1, 2) else 0
        number_size = 2 if fields.version < 2 else 4
        for _ in range(fields.number(number_size)):
            item = fields.number(number_size)
            method = fields.number(2) & 15 if fields.version in (1, 2) else 0
            fields.number(2)
            base = fields.number(base_size)
            parts = []
            for _ in range(fields.number(2)):
                fields.number(index_size)
                offset = fields.number(offset_size)
                parts.append((base + offset, fields.number(length_size)))
            self._places[item] = (method, parts)

    def _read_properties(self, start: int, end: int) -> None:
        for kind, first, last in boxes(self._data, start, end):
            if kind == b"ipco":
                self._properties = list(boxes(self._data, first, last))
            elif kind == b"ipma":
                fields = _Fields(self._data, first, last)
                for _ in range(fields.number(4)):
                    item = fields.number(2 if fields.version == 0 else 4)
                    size = 2 if fields.flags & 1 else 1
                    without_mark = 0x7FFF if size == 2 else 0x7F
                    count = fields.number(1)
                    self._of_item[item] = [fields.number(size) & without_mark for _ in range(count)]

    def _read_references(self, start: int, end: int) -> None:
        size = 2 if _Fields(self._data, start, end).version == 0 else 4
        for kind, first, last in boxes(self._data, start + 4, end):
            source = int.from_bytes(self._data[first : first + size], "big")
            count = int.from_bytes(self._data[first + size : first + size + 2], "big")
            places = range(first + size + 2, min(last, first + size + 2 + size * count), size)
            self._references[kind, source] = [int.from_bytes(self._data[at : at + size], "big") for at in places]

    def photo(self) -> Heif:
        """The primary item's picture."""
        item, transformed = self._primary, [self._primary]
        if self._kinds[item] == b"iden":  # another item's picture, transformed once more
            item = self._references[b"dimg", item][0]
            transformed.insert(0, item)
        tile_items, columns = [item], 1
        if self._kinds[item] == b"grid":
            tile_items = self._references[b"dimg", item]
            columns, width, height = self._grid(item)
        tiles = self._tiles(tile_items, columns)
        wide, high = columns * tiles[0].width, len(tiles) // columns * tiles[0].height
        if self._kinds[item] != b"grid":
            width, height = wide, high
        if not 0 < width <= wide or not 0 < height <= high:
            raise HeifError(DAMAGED)
        profile, colour = self._colour([*transformed[::-1], tile_items[0]])
        if colour is not None and not profile:
            if colour.transfer in HDR_TRANSFERS:
                raise HeifError(
                    f"is an HDR picture ({HDR_TRANSFERS[colour.transfer]}), whose brightness a page cannot show, and "
                    "is left out: switch HDR off in the camera, or save it as JPEG."
                )
            profile = profile_of(colour)
        described = [box for each in transformed for box in self._described(each)]
        changes = list(_transformations(self._data, described, (width, height)))
        return Heif(tiles, columns, width, height, changes, self._exif(), profile)

    def _described(self, item: int) -> list[Box]:
        """The properties of an item, in order."""
        numbers = self._of_item.get(item, [])
        return [self._properties[number - 1] for number in numbers if number]

    def _property(self, item: int, wanted: bytes) -> bytes:
        for kind, start, end in self._described(item):
            if kind == wanted:
                return self._data[start:end]
        raise HeifError(DAMAGED)

    def _content(self, item: int) -> bytes:
        """The bytes of an item, together never more than the file has."""
        method, parts = self._places[item]
        if method not in (0, 1):
            raise HeifError(_UNKNOWN.format("items made of items"))
        start, end = (0, len(self._data)) if method == 0 else self._inline
        pieces, size = [], 0
        for offset, length in parts:
            length = length or end - start - offset
            size += length
            if length < 0 or offset + length > end - start or size > end - start:
                raise HeifError(CUT_SHORT)
            pieces.append(self._data[start + offset : start + offset + length])
        return b"".join(pieces)

    def _grid(self, item: int) -> tuple[int, int, int]:
        """Columns, and size of the assembled picture."""
        content = self._content(item)
        _, flags, rows, columns = struct.unpack_from("4B", content)
        width, height = struct.unpack_from(">II" if flags & 1 else ">HH", content, 4)
        if len(self._references.get((b"dimg", item), [])) != (rows + 1) * (columns + 1):
            raise HeifError(DAMAGED)
        return columns + 1, width, height

    def _tiles(self, items: list[int], columns: int) -> list[Tile]:
        """The coded parts of the picture."""
        tiles: dict[int, Tile] = {}
        size = 0
        for item in dict.fromkeys(items):
            if len(items) > 1 and any(kind in _TRANSFORMATIONS for kind, *_ in self._described(item)):
                raise HeifError(_UNKNOWN.format("turned tiles"))
            tiles[item] = self._tile(item)
            size += len(tiles[item].coded)
            if size > len(self._data):
                raise HeifError(DAMAGED)
        if len({(tile.width, tile.height) for tile in tiles.values()}) > 1:
            raise HeifError(DAMAGED)
        first = tiles[items[0]]
        wide, high = columns * first.width, len(items) // columns * first.height
        if wide * high > MOST_PIXELS:
            raise HeifError(
                f"claims to have {wide} x {high} pixels, more than any camera's photo, and is left out: save it "
                "smaller."
            )
        return [tiles[item] for item in items]

    def _tile(self, item: int) -> Tile:
        codec = self._kinds[item]
        if codec not in CONFIGURATIONS:
            raise HeifError(_UNKNOWN.format(codec.decode("ascii", "replace").strip()))
        configuration, coded = self._property(item, CONFIGURATIONS[codec]), self._content(item)
        _, width, height = struct.unpack_from(">III", self._property(item, b"ispe"))
        # The decoder takes memory for the size that the coded picture claims.
        if not width * height or _SIZES[codec](configuration, coded) != {(width, height)}:
            raise HeifError(DAMAGED)
        colour = self._colour([self._primary, item])[1]
        if codec == b"hvc1" and colour is not None and colour.matrix != UNSPECIFIED:
            configuration = hevc.with_colour(configuration, colour)
        return Tile(codec, configuration, width, height, _DEEP[codec](configuration), coded)

    def _colour(self, items: Iterable[int]) -> tuple[bytes, Colour | None]:
        """Colour profile and code points, each from the first of the items that has it."""
        profile, colour = b"", None
        for item in items:
            for kind, start, end in self._described(item):
                content = self._data[start:end]
                if kind == b"colr" and content[:4] in (b"prof", b"rICC"):
                    profile = profile or content[4:]
                elif kind == b"colr" and content[:4] == b"nclx" and colour is None:
                    primaries, transfer, matrix, full = struct.unpack_from(">HHHB", content, 4)
                    if max(primaries, transfer, matrix) > 255:
                        raise HeifError(DAMAGED)
                    colour = Colour(primaries, transfer, matrix, full >= 128)
        return profile, colour

    def _exif(self) -> bytes:
        """The TIFF structure of the EXIF item that describes the photo."""
        for item, kind in self._kinds.items():
            if kind == b"Exif" and self._primary in self._references.get((b"cdsc", item), [self._primary]):
                try:
                    content = self._content(item)
                except (HeifError, KeyError):
                    return b""  # the photo is the same without it
                before = int.from_bytes(content[:4], "big")
                return content[4 + before :].removeprefix(b"Exif\0\0")
        return b""


def _transformations(data: bytes, properties: list[Box], size: tuple[int, int]) -> Iterator[Transformation]:
    """What the properties do to a picture of this size, in order."""
    for kind, start, end in properties:
        if kind == b"clap":
            crop = _crop(data[start:end], size)
            size = crop[2:]
            yield Transformation(kind, crop)
        elif kind == b"irot":
            turns = data[start] & 3
            size = size[::-1] if turns % 2 else size
            yield Transformation(kind, (turns,))
        elif kind == b"imir":
            yield Transformation(kind, (data[start] & 1,))


def _crop(content: bytes, size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Left, top, width and height of a crop, which the file describes by its size and how far its middle is off."""
    numbers = struct.unpack_from(">8i", content)
    if min(numbers[1::2]) <= 0:
        raise HeifError(DAMAGED)
    width, height, right, down = (above / below for above, below in zip(numbers[::2], numbers[1::2]))
    # Half pixels as libheif rounds them.
    left, top = math.floor((size[0] - width) / 2 + right), math.floor((size[1] - height) / 2 + down + 0.5)
    width, height = round(width), round(height)
    if min(left, top) < 0 or min(width, height) < 1 or left + width > size[0] or top + height > size[1]:
        raise HeifError(DAMAGED)
    return left, top, width, height
