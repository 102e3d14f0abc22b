"""Checks the files of a COLMAP model before COLMAP reads them, which believes every count in them.

A binary file that is cut short may ask for any amount of memory. The formats are those of COLMAP's
`src/colmap/scene/reconstruction_io_binary.cc`.
"""

from __future__ import annotations

import mmap
import stat
import struct
from collections.abc import Callable
from pathlib import Path

from ...core.errors import UnusablePhotos

_KINDS = (".bin", ".txt")
_NEEDED = ("cameras", "images", "points3D")
_ALL = (*_NEEDED, "rigs", "frames")
# How many numbers each lens model has, in the order of COLMAP's `models.h`.
_LENS_PARAMETERS = (3, 4, 4, 5, 8, 8, 12, 5, 4, 5, 12, 16, 4, 5, 3, 4, 6, 2)
# The bytes of the parts of entries with fixed size.
_CAMERA, _POSE, _POINT2D, _POINT, _SEEN, _SENSOR, _DATUM = 24, 64, 24, 43, 8, 8, 16
# All but the first sensor of a rig say in one byte whether their pose follows, and how long that is.
_SAYS_POSE, _SENSOR_POSE = 1, 56


class _CutShort(Exception):
    """A file ends before the entries that it states."""


def model_folder(given: Path) -> Path:
    """The folder of a COLMAP model: the given one, or ``sparse/0``, ``sparse`` or ``0`` in it.

    Raises
    ------
    UnusablePhotos
        If there is none.
    """
    for below in ("", "sparse/0", "sparse", "0"):
        folder = given / below
        if any(all((folder / f"{name}{kind}").exists() for name in _NEEDED) for kind in _KINDS):
            return folder
    raise UnusablePhotos(
        f"{given} holds no COLMAP model: name the folder with cameras, images and points3D (.bin or .txt)."
    )


def check_files(folder: Path) -> int:
    """Check that a model's files are files and hold as many entries as they state; returns their size in bytes.

    Raises
    ------
    UnusablePhotos
    """
    size = 0
    for path in (folder / f"{name}{kind}" for name in _ALL for kind in _KINDS):
        try:
            status = path.stat()
            if not stat.S_ISREG(status.st_mode):
                raise UnusablePhotos(_unreadable(folder, f"{path.name} is not a file"))
            if path.suffix == ".bin":
                _check_counts(path, status.st_size)
            size += status.st_size
        except FileNotFoundError:
            continue
        except OSError as error:
            raise UnusablePhotos(_unreadable(folder, f"{path.name} cannot be opened, {error.strerror}")) from error
        except (_CutShort, struct.error, IndexError, OverflowError) as error:
            raise UnusablePhotos(
                _unreadable(folder, f"{path.name} with its {status.st_size} bytes is cut short or damaged")
            ) from error
    return size


def _unreadable(folder: Path, why: str) -> str:
    return f"The COLMAP model in {folder} cannot be read ({why}): copy it again, or export it again from COLMAP."


def _check_counts(path: Path, size: int) -> None:
    """Go from entry to entry; the last must end where the file ends."""
    if size < 8:
        raise _CutShort
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        (count,) = struct.unpack_from("<Q", content)
        position, behind = 8, _BEHIND[path.stem]
        for _ in range(count):
            position = behind(content, position)
            if position > size:
                raise _CutShort
        if position != size:
            raise _CutShort


def _behind_camera(content: mmap.mmap, at: int) -> int:
    return at + _CAMERA + 8 * _LENS_PARAMETERS[struct.unpack_from("<I", content, at + 4)[0]]


def _behind_image(content: mmap.mmap, at: int) -> int:
    name_ends = content.find(b"\0", at + _POSE)
    if name_ends < 0:
        raise _CutShort
    return name_ends + 9 + _POINT2D * int(struct.unpack_from("<Q", content, name_ends + 1)[0])


def _behind_point(content: mmap.mmap, at: int) -> int:
    return at + _POINT + 8 + _SEEN * int(struct.unpack_from("<Q", content, at + _POINT)[0])


def _behind_rig(content: mmap.mmap, at: int) -> int:
    (sensors,) = struct.unpack_from("<I", content, at + 4)
    at += 8
    for number in range(sensors):
        at += _SENSOR
        if number:
            at += _SAYS_POSE + (_SENSOR_POSE if content[at] else 0)
    return at


def _behind_frame(content: mmap.mmap, at: int) -> int:
    return at + _POSE + 4 + _DATUM * int(struct.unpack_from("<I", content, at + _POSE)[0])


_BEHIND: dict[str, Callable[[mmap.mmap, int], int]] = {
    "cameras": _behind_camera,
    "images": _behind_image,
    "points3D": _behind_point,
    "rigs": _behind_rig,
    "frames": _behind_frame,
}
