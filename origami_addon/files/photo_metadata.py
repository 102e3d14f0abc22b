"""The metadata of a photo's file: EXIF, colour profile, and whether the file is complete.

It is read here and not by the decoder, so every Blender gives the same result, with or without OpenImageIO.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from .heif import read_heif

_EXIF_FOLDER = 0x8769
_NUMBER = (int, float)
# Name and required type of each value: a file may have any type under any tag.
_TAGS: dict[int, tuple[str, type | tuple[type, ...]]] = {
    0x010F: ("make", str),
    0x0110: ("model", str),
    0x0112: ("orientation", int),
    0x0132: ("changed", str),
    0x8773: ("icc_profile", bytes),
    0x9003: ("taken", str),
    0x920A: ("focal_length", _NUMBER),
    0xA002: ("width", int),
    0xA003: ("height", int),
    0xA20E: ("plane_resolution", _NUMBER),
    0xA210: ("plane_unit", int),
    0xA405: ("focal_length_35mm", _NUMBER),
}
_FORMATS = {1: "B", 2: "s", 3: "H", 4: "I", 5: "II", 7: "s", 8: "h", 9: "i", 10: "ii"}
_LARGEST_PROFILE = 1 << 24  # bytes; printers' profiles have a few million
_MILLIMETRES = {2: 25.4, 3: 10.0, 4: 1.0}
_DIAGONAL_35MM = 43.267


@dataclass(frozen=True)
class Metadata:
    """Attributes
    ----------
    orientation : int
        EXIF orientation, 1 to 8; 1 if missing.
    make, model, taken : str
        Empty if missing; ``taken`` as EXIF writes it, ``2014:05:11 10:20:05``.
    icc_profile : bytes or None
        The embedded colour profile.
    whole : bool
        False if the file ends before its end mark.
    """

    orientation: int
    make: str
    model: str
    taken: str
    icc_profile: bytes | None
    whole: bool
    tags: dict[str, Any]

    def focal_length_pixels(self, width: int, height: int) -> float | None:
        """Focal length in pixels of a photo of this size; None if EXIF does not have it."""
        if equivalent := self.tags.get("focal_length_35mm"):
            return float(equivalent) / _DIAGONAL_35MM * float(width**2 + height**2) ** 0.5
        focal, density = self.tags.get("focal_length"), self.tags.get("plane_resolution")
        millimetres = _MILLIMETRES.get(self.tags.get("plane_unit", 2))
        taken_at = max(self.tags.get("width", 0), self.tags.get("height", 0))
        if focal and density and millimetres and taken_at:
            return float(focal * density / millimetres * max(width, height) / taken_at)
        return None


def read_metadata(data: bytes) -> Metadata:
    """Metadata of the JPEG, PNG, TIFF, WebP, HEIC or AVIF file with this content; empty for any other content.

    The last two are turned by properties of their own, and EXIF's orientation does not count.

    Raises
    ------
    HeifError
        If a HEIC or AVIF file is damaged, or Origami cannot read it.
    """
    exif, icc, whole, turned = b"", b"", True, True
    if data.startswith(b"\xff\xd8"):
        exif, icc, whole = _jpeg(data)
    elif data.startswith(b"\x89PNG"):
        exif, icc, whole = _png(data)
    elif data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        exif, icc, whole = _webp(data)
    elif data[:4] in (b"II*\0", b"MM\0*"):
        exif = data
    elif data[4:8] == b"ftyp":
        heif = read_heif(data)
        exif, icc, turned = heif.exif, heif.icc_profile, False
    tags = _exif_tags(exif)
    orientation = tags.get("orientation", 1)
    return Metadata(
        orientation if turned and orientation in range(1, 9) else 1,
        tags.get("make", ""),
        tags.get("model", ""),
        tags.get("taken", tags.get("changed", "")),
        icc or tags.get("icc_profile") or None,
        whole,
        tags,
    )


def _jpeg(data: bytes) -> tuple[bytes, bytes, bool]:
    exif, profile, position = b"", {}, 2
    while position + 4 <= len(data) and data[position] == 0xFF:
        marker, size = data[position + 1], int.from_bytes(data[position + 2 : position + 4], "big")
        content = data[position + 4 : position + 2 + size]
        if marker == 0xE1 and content.startswith(b"Exif\0\0") and not exif:
            exif = content[6:]
        elif marker == 0xE2 and content.startswith(b"ICC_PROFILE\0") and len(content) > 14:
            profile[content[12]] = content[14:]
        elif marker == 0xDA:
            break
        position += 2 + size
    return exif, b"".join(profile[key] for key in sorted(profile)), data.find(b"\xff\xd9", position) >= 0


def _png(data: bytes) -> tuple[bytes, bytes, bool]:
    exif, icc, position = b"", b"", 8
    while position + 12 <= len(data):
        size, kind = int.from_bytes(data[position : position + 4], "big"), data[position + 4 : position + 8]
        content = data[position + 8 : position + 8 + size]
        if kind == b"eXIf":
            exif = content
        elif kind == b"iCCP":
            try:
                packed = zlib.decompressobj()
                icc = packed.decompress(content[content.index(b"\0") + 2 :], _LARGEST_PROFILE)
                icc = b"" if packed.unconsumed_tail else icc
            except (ValueError, zlib.error):
                icc = b""
        elif kind == b"IEND":
            return exif, icc, True
        position += 12 + size
    return exif, icc, False


def _webp(data: bytes) -> tuple[bytes, bytes, bool]:
    exif, icc, position = b"", b"", 12
    whole = int.from_bytes(data[4:8], "little") + 8 <= len(data) + 1
    while position + 8 <= len(data):
        kind, size = data[position : position + 4], int.from_bytes(data[position + 4 : position + 8], "little")
        content = data[position + 8 : position + 8 + size]
        if kind == b"EXIF":
            exif = content.removeprefix(b"Exif\0\0")
        elif kind == b"ICCP":
            icc = content
        position += 8 + size + size % 2
    return exif, icc, whole


def _exif_tags(exif: bytes) -> dict[str, Any]:
    """The known tags of a TIFF structure that have the right type, up to the first damaged place."""
    tags: dict[str, Any] = {}
    if exif[:2] not in (b"II", b"MM") or len(exif) < 8:
        return tags
    order = "<" if exif[:2] == b"II" else ">"
    try:
        inner = None
        first = struct.unpack_from(order + "I", exif, 4)[0]
        for tag, value in _folder(exif, order, first):
            if tag == _EXIF_FOLDER and isinstance(value, int):
                inner = value
            _note(tags, tag, value)
        if inner is not None:  # a single one, as damaged files may point to themselves thousands of times
            for tag, value in _folder(exif, order, inner):
                _note(tags, tag, value)
    except struct.error:
        pass
    return tags


def _note(tags: dict[str, Any], tag: int, value: Any) -> None:
    name, kind = _TAGS.get(tag, ("", ()))
    if isinstance(value, kind):
        tags[name] = value


def _folder(exif: bytes, order: str, start: int) -> Iterator[tuple[int, Any]]:
    for entry in range(struct.unpack_from(order + "H", exif, start)[0]):
        at = start + 2 + 12 * entry
        tag, kind, count = struct.unpack_from(order + "HHI", exif, at)
        if kind not in _FORMATS or (tag not in _TAGS and tag != _EXIF_FOLDER):
            continue
        size = struct.calcsize(order + _FORMATS[kind])
        where = at + 8 if size * count <= 4 else struct.unpack_from(order + "I", exif, at + 8)[0]
        if _FORMATS[kind] == "s":
            raw = struct.unpack_from(f"{count}s", exif, where)[0]
            yield tag, raw.split(b"\0")[0].decode("utf-8", "replace").strip() if kind == 2 else raw
        elif len(_FORMATS[kind]) == 2:
            above, below = struct.unpack_from(order + _FORMATS[kind], exif, where)
            yield tag, above / below if below else None
        else:
            yield tag, struct.unpack_from(order + _FORMATS[kind], exif, where)[0]
