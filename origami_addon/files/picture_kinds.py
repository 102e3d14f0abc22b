"""What kind of picture a file holds, by its first bytes: phones, downloads and converters give files wrong names."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import BinaryIO

JPEG, PNG, TIFF, WEBP, HEIC, AVIF = "JPEG", "PNG", "TIFF", "WebP", "HEIC", "AVIF"
READ = frozenset((JPEG, PNG, TIFF, WEBP, HEIC, AVIF))
MOVIE, RAW = "movie", "RAW"
UNKNOWN = ""
# Names of the kinds that are read.
EXTENSIONS = tuple(".jpg .jpeg .jpe .jfif .mpo .png .tif .tiff .webp .heic .heif .hif .avif".split())
# Names of movies, for file browsers.
MOVIE_EXTENSIONS = (".mp4", ".mov", ".m4v", ".avi", ".mkv", ".webm")
# Many RAW files are TIFF inside, with a small picture first; some of them can only be recognised by their names.
_RAW_EXTENSIONS = frozenset(
    ".dng .nef .nrw .arw .sr2 .srf .pef .srw .3fr .fff .iiq .erf .dcr .kdc .mos .rwl .raw .raf .orf .rw2 .x3f .cr2 "
    ".cr3 .crw".split()
)
_BEGINNINGS = {
    b"\xff\xd8": JPEG,
    b"\x89PNG": PNG,
    b"II*\0": TIFF,
    b"MM\0*": TIFF,
    b"II+\0": TIFF,
    b"MM\0+": TIFF,
    b"GIF8": "GIF",
    b"%PDF": "PDF",
    b"8BPS": "Photoshop",
    b"\xff\x0a": "JPEG XL",
    b"\0\0\0\x0cJXL ": "JPEG XL",
    b"\0\0\0\x0cjP  ": "JPEG 2000",
    b"\xff\x4f\xff\x51": "JPEG 2000",
    b"\x76\x2f\x31\x01": "OpenEXR",
    b"#?RADIANCE": "Radiance",
    b"SDPX": "DPX",
    b"XPDS": "DPX",
    b"FUJIFILMCCD-RAW": RAW,
    b"IIRO": RAW,
    b"IIRS": RAW,
    b"MMOR": RAW,
    b"IIU\0": RAW,
    b"FOVb": RAW,
    b"\0MRM": RAW,
    b"II\x1a\0\0\0HEAPCCDR": RAW,
    b"II*\0\x10\0\0\0CR": RAW,
    b"\x1aE\xdf\xa3": MOVIE,  # Matroska and WebM
}
# The first boxes of QuickTime files from before `ftyp`.
_QUICKTIME = (b"moov", b"mdat", b"wide", b"skip")
# In their place a text has a letter, where a box of less than 512 MB has the first byte of its size.
_FIRST_LETTER = 0x20
# Brands of ISO/IEC 14496-12 files.
_BRANDS = {b"crx ": RAW} | dict.fromkeys((b"avif", b"avis"), AVIF)
_BRANDS |= dict.fromkeys((b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"mif2", b"msf1"), HEIC)
_LONGEST_BRANDS = 256
_SUBFILE_TYPE, _SUBFOLDERS, _DNG_VERSION = 254, 330, 50706
_REDUCED = 1  # the value of the first for a small copy of another picture
_LARGEST_TIFF_FOLDER = 4096  # entries


RAW_ADVICE = (
    "use the JPEG that the camera makes of the same photo, or convert it to TIFF or JPEG with the camera maker's "
    "program or another RAW converter, such as darktable"
)


def kind_of_file(path: Path) -> str:
    """One of `READ`, the name of another kind of file, or `UNKNOWN`.

    Raises
    ------
    OSError
    """
    with path.open("rb") as file:
        return kind_of(file, path.suffix)


def kind_of(file: BinaryIO, extension: str) -> str:
    """One of `READ`, the name of another kind of file, or `UNKNOWN`.

    Parameters
    ----------
    file : binary file
        At its beginning.
    extension : str
        Of its name, with the dot; it only decides whether a TIFF or something unknown is a camera's RAW file.
    """
    start = file.read(_LONGEST_BRANDS)
    if start[4:8] == b"ftyp":
        size = int.from_bytes(start[:4], "big")
        brands = [start[at : at + 4] for at in (8, *range(16, min(size, len(start)), 4))]
        return next((_BRANDS[brand] for brand in brands if brand in _BRANDS), MOVIE)
    if start[4:8] in _QUICKTIME and start[0] < _FIRST_LETTER:
        return MOVIE
    if start[:4] == b"RIFF":
        return WEBP if start[8:12] == b"WEBP" else MOVIE if start[8:12] == b"AVI " else UNKNOWN
    if start[:2] == b"BM" and start[6:10] == bytes(4):
        return "BMP"
    # The longest first: a RAW file may begin like a TIFF.
    beginnings = sorted(_BEGINNINGS, key=len, reverse=True)
    kind = next((_BEGINNINGS[beginning] for beginning in beginnings if start.startswith(beginning)), UNKNOWN)
    if kind in (TIFF, UNKNOWN) and extension.lower() in _RAW_EXTENSIONS:
        return RAW
    return RAW if kind == TIFF and _is_raw(file, start) else kind


def left_out(name: str, kind: str) -> str:
    """The sentence about a file of a kind that is not read."""
    if kind == RAW:
        return f"{name} is a camera's RAW file and is left out: {RAW_ADVICE}."
    if kind == MOVIE:
        return f"{name} is a movie and is left out, because only photos can be used here."
    if kind == UNKNOWN:
        return f"{name} is not a photo that can be decoded and is left out."
    return f"{name} is of the kind {kind}, which Origami does not read, and is left out: save it as JPEG, PNG or TIFF."


def _is_raw(file: BinaryIO, start: bytes) -> bool:
    """Whether a TIFF is a DNG, or begins with a small picture of a larger one, as RAW files do."""
    order = "<" if start[:2] == b"II" else ">"
    try:
        file.seek(struct.unpack_from(order + "I", start, 4)[0])
        count = struct.unpack(order + "H", file.read(2))[0]
        entries = file.read(12 * min(count, _LARGEST_TIFF_FOLDER))
        places = range(0, len(entries) - 11, 12)
        tags = {struct.unpack_from(order + "H", entries, at)[0]: entries[at + 8 : at + 12] for at in places}
    except (struct.error, OSError):
        return False
    return _DNG_VERSION in tags or (_SUBFOLDERS in tags and _REDUCED in tags.get(_SUBFILE_TYPE, b""))
