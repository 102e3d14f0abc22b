"""The pixels of a HEIC or AVIF photo: Blender decodes its tiles; they are joined, cropped, turned and mirrored here."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ...core.errors import StepFailed
from .heif import CONFIGURATIONS, Heif, Tile, Transformation
from .heif_boxes import DAMAGED, HeifError
from .movie_frames import Frame, MovieError, movie_frames
from .still_movie import still_movie

_STEP = 8  # pixels between those that are compared: all of them would take a third of a second


def decode_heif(heif: Heif) -> Frame:
    """The picture as every reader shows it.

    Parameters
    ----------
    heif : Heif

    Returns
    -------
    (h, w, 3) uint8 array, or uint16 if the file has more than 8 bits
        In the file's own colour profile.

    Raises
    ------
    HeifError
        If its tiles cannot be decoded.
    StepFailed
        If the disk is full.
    """
    first = heif.tiles[0]
    rows = len(heif.tiles) // heif.columns
    deep = any(tile.deep for tile in heif.tiles)
    size = (rows * first.height, heif.columns * first.width, 3)
    picture: Frame = np.empty(size, np.uint16) if deep else np.empty(size, np.uint8)
    # A tile may appear in several places; together, different tiles have no more bytes than the file.
    places: dict[Tile, list[int]] = {}
    for place, tile in enumerate(heif.tiles):
        places.setdefault(tile, []).append(place)
    for codec, configuration in dict.fromkeys((tile.codec, tile.configuration) for tile in places):
        same = [tile for tile in places if (tile.codec, tile.configuration) == (codec, configuration)]
        for tile, frame in zip(same, _frames(same, deep=deep), strict=True):
            for place in places[tile]:
                row, column = divmod(place, heif.columns)
                top, left = row * first.height, column * first.width
                picture[top : top + first.height, left : left + first.width] = frame
    picture = picture[: heif.height, : heif.width]
    if (picture[::_STEP, ::_STEP] == picture[0, 0]).all():  # nothing was decoded
        raise HeifError(DAMAGED)
    for transformation in heif.transformations:
        picture = _transformed(picture, transformation)
    return picture.copy()


def _frames(tiles: Sequence[Tile], *, deep: bool) -> Iterator[Frame]:
    """The pixels of tiles that have one configuration."""
    first = tiles[0]
    coded = [tile.coded for tile in tiles]
    movie = still_movie(first.codec, CONFIGURATIONS[first.codec], first.configuration, first.width, first.height, coded)
    before = None
    try:
        with tempfile.TemporaryDirectory(prefix="origami-photo-") as folder:
            _check_room(Path(folder), len(movie) + len(tiles) * (first.width + 1) * first.height * (6 if deep else 3))
            path = Path(folder) / "tiles.mp4"
            path.write_bytes(movie)
            for tile, frame in zip(
                tiles, movie_frames(path, first.width, first.height, len(tiles), deep=deep), strict=True
            ):
                if before is not None and tile.coded != before[0].coded and _shows_another(frame, before[1]):
                    raise HeifError(DAMAGED)
                before = tile, frame
                yield frame
    except MovieError as error:
        raise HeifError(DAMAGED) from error
    except OSError as error:
        raise _no_room(str(error.strerror)) from error


def _check_room(folder: Path, size: int) -> None:
    """Blender does not say that a disk is full."""
    if shutil.disk_usage(folder).free < size:
        raise _no_room(os.strerror(errno.ENOSPC))


def _no_room(reason: str) -> StepFailed:
    return StepFailed(
        f"There is no room to decode photos in the folder for temporary files ({reason}): make room in "
        f"{tempfile.gettempdir()}, or set TMPDIR to another folder."
    )


def _shows_another(frame: Frame, before: Frame) -> bool:
    """Whether Blender gave the picture before in place of one that it could not decode; a blank one proves nothing."""
    return bool((frame[0, 0] == before[0, 0]).all() and (frame == before).all() and (frame != frame[0, 0]).any())


def _transformed(picture: Frame, transformation: Transformation) -> Frame:
    if transformation.kind == b"clap":
        left, top, width, height = transformation.values
        return picture[top : top + height, left : left + width]
    (value,) = transformation.values
    if transformation.kind == b"irot":
        for _ in range(value):
            picture = picture.swapaxes(0, 1)[::-1]
        return picture
    return picture[:, ::-1] if value else picture[::-1]
