"""The words that text recognition found on a page, from its hOCR."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ...core.arrays import Array
from ...core.errors import StepFailed

Box = tuple[int, int, int, int]  # left, top, right, bottom
_NUMBERS = re.compile(r"-?\d+(?:\.\d+)?")


@dataclass(frozen=True)
class Word:
    """A word.

    Attributes
    ----------
    id : str
        The same in every file about this page.
    text : str
    box : Box
        Pixels of the page; like those of `Line` and `Block`.
    confidence : float
        From 0 to 1, as the program for text recognition gives it.
    """

    id: str
    text: str
    box: Box
    confidence: float


@dataclass(frozen=True)
class Line:
    """A line of text.

    Attributes
    ----------
    baseline : (2, 2) array or None
        Its ends, x, y in pixels of the page.
    words : list of Word
        At least one.
    """

    id: str
    box: Box
    baseline: Array | None
    words: list[Word]

    @property
    def text(self) -> str:
        """The words, with spaces between them."""
        return " ".join(word.text for word in self.words)


@dataclass(frozen=True)
class Block:
    """A block of text: at least one line."""

    id: str
    box: Box
    lines: list[Line]

    @property
    def text(self) -> str:
        """The lines, each on a line."""
        return "\n".join(line.text for line in self.lines)


def read_hocr(path: Path, size_px: tuple[int, int]) -> list[Block]:
    """The blocks of text in an hOCR file, in reading order, without empty ones.

    Parameters
    ----------
    path : Path
    size_px : (width, height)
        Of the page image; boxes are scaled to it, because the program that read the PDF chose its own resolution.

    Raises
    ------
    StepFailed
        If the file has another form.
    """
    try:
        root = ElementTree.parse(path).getroot()
        page = next(_of_class(root, "ocr_page"))
        _, _, width, height = _numbers(page, "bbox")
        scale = np.array([size_px[0] / width, size_px[1] / height])
        blocks = [_block(each, scale) for each in _of_class(page, "ocr_carea")]
    except (ElementTree.ParseError, StopIteration, KeyError, ValueError, ZeroDivisionError) as error:
        raise StepFailed(
            f"The program for text recognition wrote an hOCR file of another form ({error!r}); install the versions "
            "that .ci/requirements-text.txt names."
        ) from error
    return [block for block in blocks if block.lines]


def _block(element: ElementTree.Element, scale: Array) -> Block:
    found = [_line(each, scale) for each in element.iter() if _is_line(each)]
    lines = [line for line in found if line.words]
    return Block(element.attrib["id"], _around([_box(element, scale), *(line.box for line in lines)]), lines)


def _line(element: ElementTree.Element, scale: Array) -> Line:
    left, _, right, bottom = _numbers(element, "bbox")
    baseline = None
    if "baseline" in element.attrib["title"]:
        slope, offset = _numbers(element, "baseline")
        ends = [[left, bottom + offset], [right, bottom + offset + slope * (right - left)]]
        baseline = np.array(ends) * scale
    found = [_word(each, scale) for each in _of_class(element, "ocrx_word")]
    words = [word for word in found if word.text]
    return Line(element.attrib["id"], _around([_box(element, scale), *(word.box for word in words)]), baseline, words)


def _word(element: ElementTree.Element, scale: Array) -> Word:
    text = "".join(element.itertext()).strip()
    (confidence,) = _numbers(element, "x_wconf")
    return Word(element.attrib["id"], text, _box(element, scale), confidence / 100)


def _is_line(element: ElementTree.Element) -> bool:
    """Tesseract has other classes for headings, captions and text that floats."""
    return element.attrib.get("class") in ("ocr_line", "ocr_header", "ocr_caption", "ocr_textfloat")


def _of_class(element: ElementTree.Element, name: str) -> Iterator[ElementTree.Element]:
    return (each for each in element.iter() if each.attrib.get("class") == name)


def _box(element: ElementTree.Element, scale: Array) -> Box:
    left, top, right, bottom = (np.array(_numbers(element, "bbox")).reshape(2, 2) * scale).reshape(-1)
    return round(left), round(top), round(right), round(bottom)


def _around(boxes: list[Box]) -> Box:
    """The box around boxes: Tesseract's words may be higher than their line, which PAGE does not allow."""
    left, top, right, bottom = zip(*boxes)
    return min(left), min(top), max(right), max(bottom)


def _numbers(element: ElementTree.Element, name: str) -> list[float]:
    """The numbers of a property in an hOCR element's title, such as ``bbox 10 20 30 40``.

    Raises
    ------
    KeyError
        If it has no such property.
    """
    for part in element.attrib["title"].split(";"):
        word, _, rest = part.strip().partition(" ")
        if word == name:
            return [float(number) for number in _NUMBERS.findall(rest)]
    raise KeyError(name)


def without_words(blocks: list[Block], hidden: set[str]) -> list[Block]:
    """The same blocks without some words, given by their ids, and without what is then empty."""
    kept = [
        replace(
            block,
            lines=[replace(line, words=[word for word in line.words if word.id not in hidden]) for line in block.lines],
        )
        for block in blocks
    ]
    kept = [replace(block, lines=[line for line in block.lines if line.words]) for block in kept]
    return [block for block in kept if block.lines]


def words_of(blocks: list[Block]) -> list[Word]:
    """All words, in reading order."""
    return [word for block in blocks for line in block.lines for word in line.words]
