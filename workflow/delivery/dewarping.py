"""The dewarping grid of a page in one photo, and PAGE's file of it.

The grid is a lattice of straight lines on the page. For each crossing it has the place in the photo, in whole pixels,
because PAGE's schema (``gts/dewarping/2014-08-26``) knows no others. Pixels are counted from 0 here, so the middle of
the first is at 0, while ``map.npz`` has it at 0.5.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.errors import StepFailed
from .page_in_photos import PhotoOfPage, Pixels
from .xml_text import xml_text

NAMESPACE = "http://schema.primaresearch.org/PAGE/gts/dewarping/2014-08-26"
MEDIA_TYPE = "application/xml"
_FIRST_STEP = 64  # pixels of the page between the lines to begin with
_EXACT = 1.0  # pixels of the photo that the grid may be off
# Halving 64 pixels six times leaves one.
_ROUNDS = 7
# The largest cell, in pixels of the page, of which the photo may show a part only: such a cell is left out.
_AT_THE_EDGE = 16
_HALF = 0.5
# Places along each side of the page by which is decided how the photo lies.
_LOOKED_AT = 9

Turns = Literal[0, 1, 2, 3]


@dataclass(frozen=True)
class DewarpingGrid:
    """Lines on the page and their crossings in the photo.

    Attributes
    ----------
    columns, rows : (C,), (R,) int arrays
        x of the vertical lines and y of the horizontal ones, pixels of the page.
    points : (R, C, 2) int array
        x, y of the crossings in the photo.
    shown : (R, C) bool array
        Whether the photo shows the place.
    largest_error : float
        How far the grid, bilinear between its crossings, is from the map where the photo shows the page; pixels of the
        photo.
    """

    columns: Pixels
    rows: Pixels
    points: Pixels
    shown: NDArray[np.bool_]
    largest_error: float

    @property
    def share(self) -> float:
        """The share of the page in its complete cells."""
        heights, widths = np.diff(self.rows), np.diff(self.columns)
        area = heights[:, None] * widths
        return float((area * _complete(self.shown)).sum() / area.sum())


def quarter_turns(view: PhotoOfPage) -> Turns:
    """How often to turn the photo by 90° clockwise for the page to be upright in it."""
    columns, rows = (np.linspace(0.1, 0.9, _LOOKED_AT) * length for length in view.page.size_px)
    x, y = (each.astype(int).ravel() for each in np.meshgrid(columns, rows))
    found = view.places(x, y)
    pixels = np.where(found.shown[:, None], found.pixels, np.nan).reshape(_LOOKED_AT, _LOOKED_AT, 2)
    steps = np.diff(pixels, axis=1).reshape(-1, 2)
    steps = steps[np.isfinite(steps[:, 0])]
    right, down = steps.sum(axis=0)
    if abs(right) >= abs(down):
        return 0 if right >= 0 else 2
    return 3 if down > 0 else 1


def turned(pixels: Array, size: tuple[int, int], turns: Turns) -> tuple[Array, tuple[int, int]]:
    """Places (..., 2) in a photo, and its size, after quarter turns clockwise."""
    for _ in range(turns):
        pixels, size = np.stack([size[1] - pixels[..., 1], pixels[..., 0]], axis=-1), (size[1], size[0])
    return pixels, size


def dewarping_grid(view: PhotoOfPage, turns: Turns) -> DewarpingGrid:
    """A grid that is nowhere farther than a pixel from the map, with more lines where the paper bends.

    Parameters
    ----------
    view : PhotoOfPage
    turns : int
        How often the photo will be turned by 90° clockwise.

    Raises
    ------
    StepFailed
        If the photo shows nothing of the page, or even lines at every pixel would be farther off.
    """
    columns, rows = (
        np.unique(np.append(np.arange(0, length, _FIRST_STEP), length - 1)) for length in view.page.size_px
    )
    on_page, in_photo = view.stated()
    on_page, in_photo = on_page - _HALF, turned(in_photo, _size(view), turns)[0] - _HALF
    for _ in range(_ROUNDS):
        exact, shown = _places(view, turns, columns, rows)
        grid = DewarpingGrid(columns, rows, np.rint(np.nan_to_num(exact)).astype(int), shown, 0.0)
        error = np.hypot(*(_between(grid, on_page) - in_photo).T)
        largest = float(np.nanmax(error, initial=0))
        columns, rows = _with_lines_between(view, grid, on_page[error > _EXACT])
        column, row = _cells(grid, on_page[np.isnan(error)])
        columns = np.union1d(columns, _at_the_edge(grid.columns, column))
        rows = np.union1d(rows, _at_the_edge(grid.rows, row))
        if len(columns) == len(grid.columns) and len(rows) == len(grid.rows):
            break
    if np.isnan(error).all():
        raise StepFailed(f"The photo {view.camera.name} shows nothing of the page.")
    if largest <= _EXACT:
        return replace(grid, largest_error=largest)
    raise StepFailed(
        f"No grid of whole pixels describes the page in {view.camera.name} to a pixel (the best is "
        f"{largest:.1f} pixels off); map.npz has the exact places."
    )


def _with_lines_between(view: PhotoOfPage, grid: DewarpingGrid, wrong: Array) -> tuple[Pixels, Pixels]:
    """The grid's lines, and others in the middle of the cells with these places (N, 2), across the way they bend."""
    if not len(wrong):
        return grid.columns, grid.rows
    column, row = np.unique(np.stack(_cells(grid, wrong), axis=1), axis=0).T
    left, right, top, bottom = grid.columns[column], grid.columns[column + 1], grid.rows[row], grid.rows[row + 1]
    middle_x, middle_y = (left + right) // 2, (top + bottom) // 2
    along_x = np.maximum(*(_bend(view, (left, y), (middle_x, y), (right, y)) for y in (top, bottom)))
    along_y = np.maximum(*(_bend(view, (x, top), (x, middle_y), (x, bottom)) for x in (left, right)))
    # Where neither bends, whole pixels are too coarse for so long a cell.
    across = (along_x >= along_y / 2) & (right - left > 1)
    down = (along_y >= along_x / 2) & (bottom - top > 1)
    neither = ~across & ~down
    columns = np.unique(np.concatenate([grid.columns, middle_x[across | neither]]))
    return columns, np.unique(np.concatenate([grid.rows, middle_y[down | neither]]))


def _at_the_edge(lines: Pixels, cells: Pixels) -> Pixels:
    """Lines in the middle of large cells, of which the photo shows a part only."""
    wide = cells[lines[cells + 1] - lines[cells] > _AT_THE_EDGE]
    return (lines[wide] + lines[wide + 1]) // 2


def _bend(view: PhotoOfPage, *lines: tuple[Pixels, Pixels]) -> Array:
    """How far the middle of each line from a first place over a second to a third is from straight, pixels."""
    first, middle, last = (view.places(x, y).pixels for x, y in lines)
    (x0, y0), (x1, y1), (x2, y2) = lines
    share = (x1 - x0 + y1 - y0) / np.maximum(x2 - x0 + y2 - y0, 1)
    return np.nan_to_num(np.hypot(*(first + share[:, None] * (last - first) - middle).T))


def _places(view: PhotoOfPage, turns: Turns, columns: Pixels, rows: Pixels) -> tuple[Array, NDArray[np.bool_]]:
    """The places of the page's pixels in the turned photo, (R, C, 2), counted from 0, and whether it shows them."""
    x, y = np.meshgrid(columns, rows)
    found = view.places(x.ravel(), y.ravel())
    upright, size = turned(found.pixels.reshape(*x.shape, 2), _size(view), turns)
    return np.clip(upright - _HALF, 0, np.array(size) - 1), found.shown.reshape(x.shape)


def _size(view: PhotoOfPage) -> tuple[int, int]:
    return view.camera.width, view.camera.height


def _complete(shown: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether all four corners of each cell are shown."""
    return shown[:-1, :-1] & shown[:-1, 1:] & shown[1:, :-1] & shown[1:, 1:]


def _cells(grid: DewarpingGrid, at: Array) -> tuple[Pixels, Pixels]:
    """The column and the row of the cell with each place (N, 2) of the page."""
    column = np.clip(np.searchsorted(grid.columns, at[:, 0], side="right") - 1, 0, len(grid.columns) - 2)
    row = np.clip(np.searchsorted(grid.rows, at[:, 1], side="right") - 1, 0, len(grid.rows) - 2)
    return column, row


def _between(grid: DewarpingGrid, at: Array) -> Array:
    """The grid's points at places (N, 2) between its crossings, bilinear as programs read it; NaN where it has none."""
    column, row = _cells(grid, at)
    x = ((at[:, 0] - grid.columns[column]) / np.diff(grid.columns)[column])[:, None]
    y = ((at[:, 1] - grid.rows[row]) / np.diff(grid.rows)[row])[:, None]
    upper = grid.points[row, column] * (1 - x) + grid.points[row, column + 1] * x
    lower = grid.points[row + 1, column] * (1 - x) + grid.points[row + 1, column + 1] * x
    return np.where(_complete(grid.shown)[row, column][:, None], upper * (1 - y) + lower * y, np.nan)


def rectangles(shown: NDArray[np.bool_]) -> list[tuple[slice, slice]]:
    """Cut the complete cells of a grid into rectangles, each as its rows and columns of crossings.

    A file of PAGE has one grid for each: a grid has no holes.
    """
    found: list[tuple[slice, slice]] = []
    open_runs: dict[tuple[int, int], int] = {}
    cells = _complete(shown)
    for row in range(len(cells) + 1):
        runs = set(_runs(cells[row])) if row < len(cells) else set()
        for run in sorted(open_runs.keys() - runs):
            found.append((slice(open_runs.pop(run), row + 1), slice(run[0], run[1] + 1)))
        for run in runs - open_runs.keys():
            open_runs[run] = row
    return found


def _runs(row: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Where each run of true values begins, and where it ends."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], row.astype(int), [0]])))
    return [(int(begin), int(end)) for begin, end in edges.reshape(-1, 2)]


def write_dewarping_xml(path: Path, grid: DewarpingGrid, image: str, comment: str) -> None:
    """Write a grid in PAGE's schema for dewarping.

    Parameters
    ----------
    path : Path
    grid : DewarpingGrid
    image : str
        The photo, as a path from the folder that holds the METS file.
    comment : str
        For whoever reads the file.

    Raises
    ------
    OSError
    """
    ElementTree.register_namespace("", NAMESPACE)
    root = ElementTree.Element(f"{{{NAMESPACE}}}DwGts", dwGtsId="dewarping")
    described = _inside(root, "Metadata")
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    for name, text in (("Creator", "Origami"), ("Created", now), ("LastChange", now), ("Comments", comment)):
        _inside(described, name).text = xml_text(text)
    _inside(root, "DocumentImage", filename=xml_text(image))
    for rows, columns in rectangles(grid.shown):
        element = _inside(root, "Grid")
        for index, x in enumerate(grid.columns[columns]):
            _inside(element, "Column", index=str(index), refLinePos=str(x))
        for index, (y, points) in enumerate(zip(grid.rows[rows], grid.points[rows, columns])):
            listed = " ".join(f"{across},{down}" for across, down in points)
            _inside(element, "Row", index=str(index), refLinePos=str(y), points=listed)
    tree = ElementTree.ElementTree(root)
    ElementTree.indent(tree)
    tree.write(path, encoding="utf-8", xml_declaration=True)


def _inside(parent: ElementTree.Element, name: str, **attributes: str) -> ElementTree.Element:
    return ElementTree.SubElement(parent, f"{{{NAMESPACE}}}{name}", attributes)
