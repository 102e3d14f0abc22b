"""A file that Origami writes: its declaration, and everything that goes into it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import bpy

from ...core.arrays import Array
from ...core.numeric.image import Image
from ...core.page.resolution import MILLIMETRES_PER_INCH
from ..files.image_files import Bits
from ..settings import RunSettings
from ..state import Paged
from .outline_files import crease_ends
from .relief_files import PageRelief, relief_of_page

Figures = dict[str, Any]

# The parts of writing, as the report names them, in order, and the progress text of each.
PAGE, ARRAYS, OUTLINE, RELIEF = "write page", "write arrays", "write outline", "write relief"
DOCUMENT, BAKE = "write document", "bake"
PARTS = {
    PAGE: "Writing the page",
    ARRAYS: "Writing the arrays",
    OUTLINE: "Writing the outline and the creases",
    RELIEF: "Writing the normal map and the displacement map",
    DOCUMENT: "Writing the Blender file and the models",
    BAKE: "Baking the page in Blender",
}


@dataclass(frozen=True)
class Finished:
    """Everything that goes into the files.

    Attributes
    ----------
    state : Paged
    photo : callable
        Returns the pixels of the reference photo.
    profile : bytes or None
        Colour profile of the page, which is that of the reference photo.
    bits : {8, 16} or None
        Bits of each colour in TIFF and PNG; None for as many as the photo has.
    make_object : callable
        Makes the sheet as a Blender object with its page on it, once the page is written.
    home : Path
        The folder in which the files will be in the end.
    title : str
        The name of the document.
    """

    state: Paged
    photo: Callable[[], Image]
    profile: bytes | None
    bits: Bits | None
    make_object: Callable[[Finished], bpy.types.Object]
    home: Path
    title: str

    def in_blender(self) -> bpy.types.Object:
        """The sheet as a Blender object, made on first use."""
        return self._sheet_object

    @cached_property
    def _sheet_object(self) -> bpy.types.Object:
        return self.make_object(self)

    @cached_property
    def relief(self) -> PageRelief:
        """The relief of the page, found on first use."""
        return relief_of_page(self.state.sheet, self.state.flat, self.state.page)

    @property
    def size_mm(self) -> tuple[float, float]:
        """Width and height of the page; if the paper's size is unknown, at the resolution that is assumed.

        A whole number of pixels at one resolution would be up to half a pixel off.
        """
        flat, page = self.state.flat, self.state.page
        if flat.unit == "mm":
            return flat.width, flat.height
        height, width = page.image.shape[:2]
        return width / page.dpi * MILLIMETRES_PER_INCH, height / page.dpi * MILLIMETRES_PER_INCH

    @property
    def creases(self) -> Array:
        """The ends (N, 2, 2) of the creases in the reference photo, pixels as stored."""
        return crease_ends(self.state.sheet, self.state.sheet_reference)


@dataclass(frozen=True)
class Output:
    """A file.

    Attributes
    ----------
    name : str
    help : str
        What it is, beginning in lower case and without a full stop.
    part : str
        The part of the writing to which it belongs.
    write : callable
        ``write(path, finished)``; returns figures for the report.
    label : str
        Its name in the window; the window exports the files that have one.
    kind : str
        Its name for scripts that export.
    in_run : bool
        Whether a whole run may write it.
    asked_for : callable
        Whether a run with given settings does so.
    editable : bool
        Whether a user may edit it and pass it to another run.
    also : tuple of str
        Further files that its writer writes.
    beside : tuple of str
        The files that it refers to.
    why_not : callable
        Why this Blender cannot write it; empty if it can.
    """

    name: str
    help: str
    part: str
    write: Callable[[Path, Finished], Figures | None]
    label: str = ""
    kind: str = ""
    in_run: bool = True
    asked_for: Callable[[RunSettings], bool] = lambda settings: True
    editable: bool = False
    also: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()
    why_not: Callable[[], str] = lambda: ""
