"""Lay out the page upright: by the direction of its text, or, if that is unclear, as the photo was held."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import linear_light, perceptual
from ..sheet import FlatMap, Sheet
from ..watch import SILENT, Watch
from .page import PaperSize, lay_out
from .page_cells import ReadPhoto
from .single_photo import page_of_photo
from .upright import reading_direction

# Values without a figure are choices; no measurement of them is recorded.
# Pixels of the page's long side at which the direction of the text is found.
_READING_SIDE = 1600
# Above this confidence, the page is turned to make the text upright.
_SURE_DIRECTION = 0.5


@dataclass(frozen=True)
class UprightPage:
    """A page that was laid out upright, and the direction of its text.

    Attributes
    ----------
    flat : FlatMap
    quarter_turns : int
        Clockwise quarter turns from the way the photo was held to upright text; applied if the direction is sure.
    confidence : float
        In that direction, 0 to 1.
    """

    flat: FlatMap
    quarter_turns: int
    confidence: float


def lay_out_upright(
    sheet: Sheet,
    uv: Array,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    up: Array,
    paper: PaperSize | None = None,
    watch: Watch = SILENT,
) -> UprightPage:
    """Lay out a page so that its text stands upright.

    Parameters
    ----------
    sheet : Sheet
    uv : (V, 2) array
        As from `flatten`.
    cameras : sequence of Camera
    read_photo : callable
        As for `single_photo.page_of_photo`.
    reference : int
        Index of the reference photo.
    up : (2,) array
        Direction in that photo, in pixels (y down), that counts as up if the text does not show it.
    paper : PaperSize, optional
    watch : Watch

    Raises
    ------
    Cancelled
    """
    flat = lay_out(sheet, uv, cameras[reference], up, paper)
    watch.step(0.3, "Finding which way up the text is")
    scale = _READING_SIDE / max(flat.width, flat.height)
    size = (max(round(flat.width * scale), 1), max(round(flat.height * scale), 1))
    page = page_of_photo(sheet, flat, cameras, read_photo, reference, size)
    quarters, confidence = reading_direction(perceptual(linear_light(page.image))[..., 0])
    if quarters and confidence >= _SURE_DIRECTION:
        flat = lay_out(sheet, uv, cameras[reference], up, paper, quarter_turns=quarters)
    return UprightPage(flat, quarters, confidence)


def up_after(degrees: int) -> Array:
    """Direction in a photo, (2,), that points up once the photo has been turned clockwise by a multiple of 90."""
    return np.array({0: (0.0, -1.0), 90: (-1.0, 0.0), 180: (0.0, 1.0), 270: (1.0, 0.0)}[degrees])


def up_of_exif(orientation: int) -> Array:
    """Direction in a photo's stored pixels, (2,), that is up for the viewer, by its EXIF orientation."""
    return up_after({3: 180, 6: 90, 8: 270}.get(orientation, 0))
