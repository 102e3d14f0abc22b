"""The pixels of a HEIC or AVIF photo: Blender decodes its tiles; they are joined, cropped, turned and mirrored here."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .heif import CONFIGURATIONS, DAMAGED, Heif, HeifError, Tile, Transformation
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
    """
    first = heif.tiles[0]
    rows = len(heif.tiles) // heif.columns
    deep = any(tile.deep for tile in heif.tiles)
    picture = np.empty((rows * first.height, heif.columns * first.width, 3), np.uint16 if deep else np.uint8)
    for codec, configuration in dict.fromkeys((tile.codec, tile.configuration) for tile in heif.tiles):
        numbers = [i for i, tile in enumerate(heif.tiles) if (tile.codec, tile.configuration) == (codec, configuration)]
        _decode([heif.tiles[number] for number in numbers], numbers, heif.columns, picture)
    picture = picture[: heif.height, : heif.width]
    if (picture[::_STEP, ::_STEP] == picture[0, 0]).all():  # nothing was decoded
        raise HeifError(DAMAGED)
    for transformation in heif.transformations:
        picture = _transformed(picture, transformation)
    return np.ascontiguousarray(picture)


def _decode(tiles: Sequence[Tile], places: Sequence[int], columns: int, picture: Frame) -> None:
    """Decode tiles that have one configuration, into their places in the picture."""
    first = tiles[0]
    movie = still_movie(
        first.codec,
        CONFIGURATIONS[first.codec],
        first.configuration,
        first.width,
        first.height,
        [tile.coded for tile in tiles],
    )
    deep = picture.dtype == np.uint16
    try:
        with tempfile.TemporaryDirectory(prefix="origami-photo-") as folder:
            path = Path(folder) / "tiles.mp4"
            path.write_bytes(movie)
            frames = movie_frames(path, first.width, first.height, len(tiles), deep=deep)
            before = None
            for tile, place, frame in zip(tiles, places, frames, strict=True):
                if before is not None and tile.coded != before[0].coded and _shows_another(frame, before[1]):
                    raise HeifError(DAMAGED)
                before = tile, frame
                row, column = divmod(place, columns)
                top, left = row * first.height, column * first.width
                picture[top : top + first.height, left : left + first.width] = frame
    except MovieError as error:
        raise HeifError(DAMAGED) from error


def _shows_another(frame: Frame, before: Frame) -> bool:
    """Whether Blender gave the picture before in place of one that it could not decode; a blank one proves nothing."""
    return bool((frame[0, 0] == before[0, 0]).all() and (frame == before).all() and (frame != frame[0, 0]).any())


def _transformed(picture: Frame, transformation: Transformation) -> Frame:
    if transformation.kind == b"clap":
        left, top, width, height = transformation.values
        return picture[top : top + height, left : left + width]
    (value,) = transformation.values
    if transformation.kind == b"irot":
        return np.rot90(picture, value)
    return picture[:, ::-1] if value else picture[::-1]
