"""Still pictures as the frames of an MP4 file: a way to Blender's video decoder.

Source: ISO/IEC 14496-12 and 14496-14. The file has one track, and each picture is a frame that can be decoded alone.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

FRAMES_PER_SECOND = 24
_NO_TURN = struct.pack(">9i", 1 << 16, 0, 0, 0, 1 << 16, 0, 0, 0, 1 << 30)
_DPI_72 = 72 << 16


def still_movie(
    codec: bytes, configuration_box: bytes, configuration: bytes, width: int, height: int, pictures: Sequence[bytes]
) -> bytes:
    """An MP4 file whose frames are the pictures.

    Parameters
    ----------
    codec, configuration_box : bytes
        Four letters each, for example ``hvc1`` and ``hvcC``.
    configuration : bytes
        What the decoder needs to know of all pictures.
    width, height : int
        Pixels of each picture.
    pictures : sequence of bytes
    """
    sample_entry = _box(
        codec,
        bytes(6) + struct.pack(">H", 1) + bytes(16),
        struct.pack(">HHIIIH", width, height, _DPI_72, _DPI_72, 0, 1),
        bytes(32) + struct.pack(">Hh", 24, -1),
        _box(configuration_box, configuration),
    )
    start = _box(b"ftyp", b"isom" + struct.pack(">I", 512) + b"isomiso2mp41")
    media_start = len(start) + len(_movie(sample_entry, width, height, pictures, 0)) + 8
    return start + _movie(sample_entry, width, height, pictures, media_start) + _box(b"mdat", *pictures)


def _movie(sample_entry: bytes, width: int, height: int, pictures: Sequence[bytes], media_start: int) -> bytes:
    count = len(pictures)
    samples = _box(
        b"stbl",
        _full_box(b"stsd", 0, struct.pack(">I", 1), sample_entry),
        _full_box(b"stts", 0, struct.pack(">III", 1, count, 1)),
        _full_box(b"stsc", 0, struct.pack(">IIII", 1, 1, count, 1)),
        _full_box(b"stsz", 0, struct.pack(">II", 0, count), *(struct.pack(">I", len(each)) for each in pictures)),
        _full_box(b"stco", 0, struct.pack(">II", 1, media_start)),
    )
    here = _box(b"dinf", _full_box(b"dref", 0, struct.pack(">I", 1), _full_box(b"url ", 1)))
    media = _box(
        b"mdia",
        _full_box(b"mdhd", 0, struct.pack(">IIIIHH", 0, 0, FRAMES_PER_SECOND, count, 0x55C4, 0)),
        _full_box(b"hdlr", 0, bytes(4) + b"vide" + bytes(13)),
        _box(b"minf", _full_box(b"vmhd", 1, bytes(8)), here, samples),
    )
    size = struct.pack(">II", width << 16, height << 16)
    track_header = _full_box(b"tkhd", 7, struct.pack(">IIIII", 0, 0, 1, 0, count), bytes(16), _NO_TURN, size)
    timing = struct.pack(">IIIIIH", 0, 0, FRAMES_PER_SECOND, count, 1 << 16, 1 << 8)
    movie_header = _full_box(b"mvhd", 0, timing, bytes(10), _NO_TURN, bytes(24), struct.pack(">I", 2))
    return _box(b"moov", movie_header, _box(b"trak", track_header, media))


def _box(kind: bytes, *content: bytes) -> bytes:
    joined = b"".join(content)
    return struct.pack(">I4s", 8 + len(joined), kind) + joined


def _full_box(kind: bytes, flags: int, *content: bytes) -> bytes:
    return _box(kind, struct.pack(">I", flags), *content)
