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
from .heif_boxes import DAMAGED, Box, HeifError
from .heif_colour import HDR_TRANSFERS, UNSPECIFIED, Colour, profile_of
from .heif_items import UNKNOWN, Items

# Kinds of coded pictures that Blender's ffmpeg decodes, with the property that configures their decoder.
CONFIGURATIONS = {b"hvc1": b"hvcC", b"av01": b"av1C"}
_SIZES = {b"hvc1": hevc.sizes, b"av01": av1.sizes}
_DEEP = {b"hvc1": hevc.is_deep, b"av01": av1.is_deep}
# The largest sensors in phones have 200 megapixels.
MOST_PIXELS = 2**28
_TRANSFORMATIONS = (b"clap", b"irot", b"imir")


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
        return _Photo(data).photo()
    except (struct.error, IndexError, KeyError) as error:
        raise HeifError(DAMAGED) from error


class _Photo(Items):
    """How the items of a file become its photo."""

    def photo(self) -> Heif:
        """The primary item's picture."""
        item, transformed = self.primary, [self.primary]
        if self.kinds[item] == b"iden":  # another item's picture, transformed once more
            item = self.references[b"dimg", item][0]
            transformed.insert(0, item)
        tile_items, columns = [item], 1
        if self.kinds[item] == b"grid":
            tile_items = self.references[b"dimg", item]
            columns, width, height = self._grid(item)
        tiles = self._tiles(tile_items, columns)
        wide, high = columns * tiles[0].width, len(tiles) // columns * tiles[0].height
        if self.kinds[item] != b"grid":
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
        described = [box for each in transformed for box in self.described(each)]
        changes = list(_transformations(self.data, described, (width, height)))
        return Heif(tiles, columns, width, height, changes, self._exif(), profile)

    def _grid(self, item: int) -> tuple[int, int, int]:
        """Columns, and size of the assembled picture."""
        content = self.content(item)
        _, flags, rows, columns = struct.unpack_from("4B", content)
        width, height = struct.unpack_from(">II" if flags & 1 else ">HH", content, 4)
        if len(self.references.get((b"dimg", item), [])) != (rows + 1) * (columns + 1):
            raise HeifError(DAMAGED)
        return columns + 1, width, height

    def _tiles(self, items: list[int], columns: int) -> list[Tile]:
        """The coded parts of the picture."""
        tiles: dict[int, Tile] = {}
        size = 0
        for item in dict.fromkeys(items):
            if len(items) > 1 and any(kind in _TRANSFORMATIONS for kind, *_ in self.described(item)):
                raise HeifError(UNKNOWN.format("turned tiles"))
            tiles[item] = self._tile(item)
            size += len(tiles[item].coded)
            if size > len(self.data):
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
        codec = self.kinds[item]
        if codec not in CONFIGURATIONS:
            raise HeifError(UNKNOWN.format(codec.decode("ascii", "replace").strip()))
        configuration, coded = self.property(item, CONFIGURATIONS[codec]), self.content(item)
        _, width, height = struct.unpack_from(">III", self.property(item, b"ispe"))
        # The decoder takes memory for the size that the coded picture claims.
        if not width * height or _SIZES[codec](configuration, coded) != {(width, height)}:
            raise HeifError(DAMAGED)
        colour = self._colour([self.primary, item])[1]
        if codec == b"hvc1" and colour is not None and colour.matrix != UNSPECIFIED:
            configuration = hevc.with_colour(configuration, colour)
        return Tile(codec, configuration, width, height, _DEEP[codec](configuration), coded)

    def _colour(self, items: Iterable[int]) -> tuple[bytes, Colour | None]:
        """Colour profile and code points, each from the first of the items that has it."""
        profile, colour = b"", None
        for item in items:
            for kind, start, end in self.described(item):
                content = self.data[start:end]
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
        for item, kind in self.kinds.items():
            if kind == b"Exif" and self.primary in self.references.get((b"cdsc", item), [self.primary]):
                try:
                    content = self.content(item)
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
