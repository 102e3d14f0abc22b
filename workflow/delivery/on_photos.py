"""The words of a page in each of its photos."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core.arrays import Array
from .hocr import Block, Box, without_words, words_of
from .page_in_photos import PageInPhotos, PhotoOfPage, Pixels
from .page_xml import write_page_xml

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


def write_words_in_photos(folder: Path, page: PageInPhotos, blocks: list[Block]) -> list[WordsInPhoto]:
    """Write a PAGE file for each photo, with the outlines of the words that the photo shows whole.

    Raises
    ------
    OSError
    """
    words = words_of(blocks)
    found = []
    for index, camera in enumerate(page.cameras):
        outlines = _outlines([word.box for word in words], page.view(index))
        hidden = [word.id for word, outline in zip(words, outlines) if outline is None]
        in_photo = {word.box: outline for word, outline in zip(words, outlines) if outline is not None}
        file = f"photo_{index + 1:02d}.xml"
        write_page_xml(
            folder / file,
            without_words(blocks, set(hidden)),
            camera.name,
            (camera.width, camera.height),
            outlines=in_photo,
            comment=f"{len(words) - len(hidden)} of the page's {len(words)} words; the photo does not show the others "
            "whole. Pixels are those of the file as stored, before any EXIF rotation.",
        )
        found.append(WordsInPhoto(camera.name, file, len(words) - len(hidden), hidden))
    return found


def _outlines(boxes: Sequence[Box], view: PhotoOfPage) -> list[Array | None]:
    """The outline of each box of the page in a photo, pixels counted from 0; None where not all of it is shown."""
    if not boxes:
        return []
    around = [_outer_pixels(box, view.page.size_px) for box in boxes]
    columns, rows = np.concatenate(around).T
    places = view.places(columns, rows)
    ends = np.cumsum([len(outline) for outline in around])[:-1]
    return [
        pixels - 0.5 if shown.all() else None
        for pixels, shown in zip(np.split(places.pixels, ends), np.split(places.shown, ends))
    ]


def _outer_pixels(box: Box, size_px: tuple[int, int]) -> Pixels:
    """Pixels (n, 2) along the inner edge of a box, clockwise: its corners, and some between them."""
    left, top, right, bottom = box
    corners = np.array([[left, top], [right - 1, top], [right - 1, bottom - 1], [left, bottom - 1]])
    corners = np.clip(corners, 0, np.array(size_px) - 1)
    sides = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0)):
        count = max(1, int(np.ceil(np.abs(end - start).max() / _POINT_EVERY)))
        sides.append(start + np.rint(np.linspace(0, 1, count, endpoint=False)[:, None] * (end - start)).astype(int))
    return np.concatenate(sides)
