"""The boxes of a HEIC or AVIF file, and the numbers in them (ISO/IEC 14496-12)."""

from __future__ import annotations

import struct
from collections.abc import Iterator

DAMAGED = "is damaged and is left out: copy it again."
CUT_SHORT = "is cut short and is left out: copy it again."

Box = tuple[bytes, int, int]


class HeifError(Exception):
    """The photo cannot be read; the text continues a sentence that begins with the file's name."""


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


class Fields:
    """Reads whole numbers one after the other from a box."""

    def __init__(self, data: bytes, start: int, end: int) -> None:
        self._data, self.at, self._end = data, start, end
        self.version, self.flags = self.number(1), self.number(3)

    def number(self, size: int) -> int:
        if self.at + size > self._end:
            raise HeifError(DAMAGED)
        self.at += size
        return int.from_bytes(self._data[self.at - size : self.at], "big")
