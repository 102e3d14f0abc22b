"""Writes PAGE XML: the page's blocks, lines and words, on the page itself or in a photo."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ...core.arrays import Array
from .hocr import Block, Box, Line
from .xml_text import xml_text

NAMESPACE = "http://schema.primaresearch.org/PAGE/gts/pagecontent/2019-07-15"
MEDIA_TYPE = "application/vnd.prima.page+xml"
Outlines = Mapping[Box, Array]


def corners(boxes: Sequence[Box]) -> list[Array]:
    """The corners (4, 2) of each box, from the upper left one clockwise: the outlines on the page itself."""
    return [np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], float) for x0, y0, x1, y1 in boxes]


def write_page_xml(
    path: Path,
    blocks: list[Block],
    image: str,
    size_px: tuple[int, int],
    *,
    outlines: Outlines | None = None,
    id: str = "page",
    comment: str = "",
) -> None:
    """Write the text of a page.

    Parameters
    ----------
    path : Path
    blocks : list of Block
    image : str
        The picture that the coordinates belong to, as a path from the folder that holds the METS file, or a name.
    size_px : (width, height)
        Its size.
    outlines : mapping, optional
        For the box of each word its outline (n, 2) in the picture, in which lines and blocks are then as large as their
        words; without it the picture is the page itself.
    id : str
        Of the document; in a workspace, that of the file.
    comment : str
        For whoever reads the file.

    Raises
    ------
    OSError
    """
    ElementTree.register_namespace("", NAMESPACE)
    root = _Element(None, "PcGts", pcGtsId=id)
    described = root.inside("Metadata")
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    for name, text in (("Creator", "Origami"), ("Created", now), ("LastChange", now), ("Comments", comment)):
        if text:
            described.inside(name).text(text)
    page = root.inside("Page", imageFilename=xml_text(image), imageWidth=str(size_px[0]), imageHeight=str(size_px[1]))
    if blocks:
        order = page.inside("ReadingOrder").inside("OrderedGroup", id="reading_order")
        for number, block in enumerate(blocks):
            order.inside("RegionRefIndexed", index=str(number), regionRef=block.id)
    for block in blocks:
        _write_block(page, block, size_px, outlines)
    tree = ElementTree.ElementTree(root.element)
    ElementTree.indent(tree)
    tree.write(path, encoding="utf-8", xml_declaration=True)


class _Element:
    """An element in PAGE's namespace."""

    def __init__(self, parent: ElementTree.Element | None, name: str, **attributes: str) -> None:
        qualified = f"{{{NAMESPACE}}}{name}"
        if parent is None:
            self.element = ElementTree.Element(qualified, attributes)
        else:
            self.element = ElementTree.SubElement(parent, qualified, attributes)

    def inside(self, name: str, **attributes: str) -> _Element:
        """A new element at its end."""
        return _Element(self.element, name, **attributes)

    def text(self, text: str) -> None:
        """Set its text."""
        self.element.text = xml_text(text)


def _write_block(page: _Element, block: Block, size_px: tuple[int, int], outlines: Outlines | None) -> None:
    region = page.inside("TextRegion", id=block.id)
    words = [word for line in block.lines for word in line.words]
    if outlines is None:
        of_words = corners([word.box for word in words])
        outline = corners([block.box])[0]
    else:
        of_words = [outlines[word.box] for word in words]
        outline = _hull(of_words)
    _write_coordinates(region, outline, size_px)
    done = 0
    for line in block.lines:
        _write_line(region, line, of_words[done : done + len(line.words)], size_px, on_page=outlines is None)
        done += len(line.words)
    region.inside("TextEquiv").inside("Unicode").text(block.text)


def _write_line(
    region: _Element, line: Line, of_words: list[Array], size_px: tuple[int, int], *, on_page: bool
) -> None:
    element = region.inside("TextLine", id=line.id)
    _write_coordinates(element, corners([line.box])[0] if on_page else _hull(of_words), size_px)
    if on_page and line.baseline is not None:
        element.inside("Baseline", points=_points(line.baseline, size_px))
    for word, outline in zip(line.words, of_words):
        inside = element.inside("Word", id=word.id)
        _write_coordinates(inside, outline, size_px)
        inside.inside("TextEquiv", conf=f"{word.confidence:.2f}").inside("Unicode").text(word.text)
    element.inside("TextEquiv").inside("Unicode").text(line.text)


def _write_coordinates(element: _Element, outline: Array, size_px: tuple[int, int]) -> None:
    element.inside("Coords", points=_points(outline, size_px))


def _points(places: Array, size_px: tuple[int, int]) -> str:
    """PAGE's points: whole numbers inside the picture."""
    inside = np.clip(np.rint(places), 0, np.array(size_px) - 1).astype(int)
    return " ".join(f"{x},{y}" for x, y in inside)


def _hull(outlines: list[Array]) -> Array:
    """The convex polygon around outlines."""
    together = np.concatenate(outlines)
    try:
        return together[ConvexHull(together).vertices]
    except QhullError:  # all on one line
        return together[[0, 0, -1]]
