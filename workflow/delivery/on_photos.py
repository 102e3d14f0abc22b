"""The words of a page in each of its photos."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core.arrays import Array
from ...core.errors import UsageError
from .finished_run import FinishedRun
from .hocr import Block, Box, without_words, words_of
from .page_map import PageMap
from .page_xml import corners, write_page_xml

# Between two points of an outline; a word is straight between them even across a crease.
_POINT_EVERY = 16  # pixels of the page


@dataclass(frozen=True)
class WordsInPhoto:
    """What a photo shows of the text.

    Attributes
    ----------
    photo : str
    file : str
        The PAGE file with the words.
    shown : int
        How many words are in it.
    hidden : list of str
        The ids of the others.
    """

    photo: str
    file: str
    shown: int
    hidden: list[str]


def write_words_in_photos(folder: Path, run: FinishedRun, page_map: PageMap, blocks: list[Block]) -> list[WordsInPhoto]:
    """Write a PAGE file for each photo, with the outlines of the words that the photo shows whole.

    Raises
    ------
    UsageError
        If the report and the map are not of the same run.
    OSError
    """
    photos = run.photos
    unknown = [name for name in page_map.photo_names if name not in photos]
    if unknown:
        raise UsageError(
            f"map.npz and report.json in {run.folder} are of different runs ({unknown[0]} is in the map only); run "
            "rectify.py again with --resume."
        )
    words = words_of(blocks)
    found = []
    for index, name in enumerate(page_map.photo_names):
        size = photos[name].size
        outlines = _outlines([word.box for word in words], page_map, index, size)
        hidden = [word.id for word, outline in zip(words, outlines) if outline is None]
        in_photo = {word.box: outline for word, outline in zip(words, outlines) if outline is not None}
        file = f"photo_{index + 1:02d}.xml"
        write_page_xml(
            folder / file,
            without_words(blocks, set(hidden)),
            name,
            size,
            outlines=in_photo,
            comment=f"{len(words) - len(hidden)} of the page's {len(words)} words; the photo does not show the others "
            "whole. Pixels are those of the file as stored, before any EXIF rotation.",
        )
        found.append(WordsInPhoto(name, file, len(words) - len(hidden), hidden))
    return found


def _outlines(boxes: Sequence[Box], page_map: PageMap, photo: int, size: tuple[int, int]) -> list[Array | None]:
    """The outline of each box of the page in a photo; None if the photo does not show all of it."""
    if not boxes:
        return []
    around = [_with_points_between(outline) for outline in corners(boxes)]
    places = page_map.places(photo, np.concatenate(around), size)
    ends = np.cumsum([len(outline) for outline in around])[:-1]
    return [
        pixels if shown.all() else None
        for pixels, shown in zip(np.split(places.pixels, ends), np.split(places.shown, ends))
    ]


def _with_points_between(outline: Array) -> Array:
    """A closed outline with further points on its sides."""
    sides = []
    for start, end in zip(outline, np.roll(outline, -1, axis=0)):
        count = max(1, int(np.ceil(np.abs(end - start).max() / _POINT_EVERY)))
        sides.append(start + np.linspace(0, 1, count, endpoint=False)[:, None] * (end - start))
    return np.concatenate(sides)
