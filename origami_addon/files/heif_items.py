"""The items of a HEIC or AVIF file: their kinds, places, properties and references (ISO/IEC 23008-12)."""

from __future__ import annotations

from .heif_boxes import CUT_SHORT, DAMAGED, Box, Fields, HeifError, boxes

UNKNOWN = "is packed in a way that Origami cannot read ({}) and is left out: save it as JPEG to use it."


class Items:
    """The items of a file's `meta` box, and what it says of them.

    Attributes
    ----------
    data : bytes
        The whole file.
    primary : int
        The item that is the photo.
    kinds : dict of int to bytes
        The kind of each item.
    references : dict of (bytes, int) to list of int
        The items to which an item refers, by the kind of the reference.
    """

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.primary = 0
        self.kinds: dict[int, bytes] = {}
        self._places: dict[int, tuple[int, list[tuple[int, int]]]] = {}
        self._properties: list[Box] = []
        self._of_item: dict[int, list[int]] = {}
        self.references: dict[tuple[bytes, int], list[int]] = {}
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
        while len(self.data) - start >= 8:
            try:
                kind, first, last = next(boxes(self.data, start, len(self.data)))
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
        fields = Fields(self.data, start, end)
        self.primary = fields.number(2 if fields.version == 0 else 4)

    def _read_kinds(self, start: int, end: int) -> None:
        fields = Fields(self.data, start, end)
        fields.number(2 if fields.version == 0 else 4)
        for kind, first, last in boxes(self.data, fields.at, end):
            if kind == b"infe":
                entry = Fields(self.data, first, last)
                if entry.version >= 2:
                    item = entry.number(2 if entry.version == 2 else 4)
                    entry.number(2)
                    self.kinds[item] = entry.number(4).to_bytes(4, "big")

    def _read_places(self, start: int, end: int) -> None:
        fields = Fields(self.data, start, end)
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
        for kind, first, last in boxes(self.data, start, end):
            if kind == b"ipco":
                self._properties = list(boxes(self.data, first, last))
            elif kind == b"ipma":
                fields = Fields(self.data, first, last)
                for _ in range(fields.number(4)):
                    item = fields.number(2 if fields.version == 0 else 4)
                    size = 2 if fields.flags & 1 else 1
                    without_mark = 0x7FFF if size == 2 else 0x7F
                    count = fields.number(1)
                    self._of_item[item] = [fields.number(size) & without_mark for _ in range(count)]

    def _read_references(self, start: int, end: int) -> None:
        size = 2 if Fields(self.data, start, end).version == 0 else 4
        for kind, first, last in boxes(self.data, start + 4, end):
            source = int.from_bytes(self.data[first : first + size], "big")
            count = int.from_bytes(self.data[first + size : first + size + 2], "big")
            places = range(first + size + 2, min(last, first + size + 2 + size * count), size)
            self.references[kind, source] = [int.from_bytes(self.data[at : at + size], "big") for at in places]

    def described(self, item: int) -> list[Box]:
        """The properties of an item, in order."""
        numbers = self._of_item.get(item, [])
        return [self._properties[number - 1] for number in numbers if number]

    def property(self, item: int, wanted: bytes) -> bytes:
        for kind, start, end in self.described(item):
            if kind == wanted:
                return self.data[start:end]
        raise HeifError(DAMAGED)

    def content(self, item: int) -> bytes:
        """The bytes of an item, together never more than the file has."""
        method, parts = self._places[item]
        if method not in (0, 1):
            raise HeifError(UNKNOWN.format("items made of items"))
        start, end = (0, len(self.data)) if method == 0 else self._inline
        pieces, size = [], 0
        for offset, length in parts:
            length = length or end - start - offset
            size += length
            if length < 0 or offset + length > end - start or size > end - start:
                raise HeifError(CUT_SHORT)
            pieces.append(self.data[start + offset : start + offset + length])
        return b"".join(pieces)
