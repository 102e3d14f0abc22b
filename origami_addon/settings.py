"""All settings of a run, shared by the command line, settings files and the report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..core.errors import UsageError
from ..core.flat.flatten import FlattenSettings
from ..core.light.looks import Look
from ..core.numeric.polygon import signed_area
from ..core.numeric.simple_polygon import is_simple
from ..core.page.resolution import MILLIMETRES_PER_INCH
from ..core.placing.result import SfmSettings
from ..core.setting import Choice, check_ranges, declaration, group_of_settings, setting
from ..core.surface.surface_settings import SurfaceSettings
from .paper_size import HOW_WRITTEN, PaperSize

EverySheet = Literal["all"]
Colour = Literal["colour", "grey", "black-and-white"]

LONGEST_PAGE_SIDE = 32000  # pixels
_MOST_CORNERS = 20000  # of an outline; whether it crosses itself takes seconds with as many
_MOST_PIXELS = 1_000_000  # a JPEG is at most 65535 pixels wide


@dataclass(frozen=True)
class PageSettings:
    """Size and orientation of the flat page.

    The paper's size is width and height, in either order. The height may be None: the sheet then determines it.
    """

    paper_size_mm: PaperSize | None = setting(
        None,
        "the paper's true size",
        label="Paper",
        option="--paper SIZE",
        typed=HOW_WRITTEN,
        least=5,
        most=5000,
        unit="mm",
        without="the page has the right shape but no true size",
    )
    turn: Literal["auto", "0", "90", "180", "270"] = setting(
        "auto",
        "degrees clockwise from the reference photo to the page",
        label="Turn",
        option="--turn",
        choices={
            "auto": Choice("Automatic", "by the direction of the text; if that is unclear, upright as in the photos"),
            "0": Choice("As in the Photo", "the page stands as in the reference photo"),
            "90": Choice("90° Clockwise", "the reference photo turned to the right"),
            "180": Choice("180°", "the reference photo upside down"),
            "270": Choice("90° Counter-Clockwise", "the reference photo turned to the left"),
        },
    )


@dataclass(frozen=True)
class ImageSettings:
    """The page image."""

    dpi: float | None = setting(
        None,
        "pixels per inch of the page; needs the paper's size",
        label="Resolution (dpi)",
        option="--dpi N",
        least=20,
        most=4800,
        unit="dpi",
        without="as many as the photo has",
    )
    source: Literal["fused", "reference"] = setting(
        "fused",
        "which photos the page's pixels come from",
        label="Pixels From",
        option="--image",
        choices={
            "fused": Choice(
                "All Photos",
                "all photos: each part from those that show it largest and sharpest, without the reflections, passing "
                "shadows and hands of single ones",
            ),
            "reference": Choice("Reference Photo", "the reference photo alone"),
        },
        formerly={"healed": "fused", "best": "fused"},
    )
    light: Look = setting(
        "paper",
        "the light on the page",
        label="Light",
        option="--light",
        choices={
            "paper": Choice("Paper", "evenly lit, without the shading of folds; the paper keeps its own tone"),
            "white": Choice("White", "evenly lit, and the paper becomes white"),
            "as-photographed": Choice("As Photographed", "the light of the photos"),
        },
    )
    colour: Colour = setting(
        "colour",
        "the colours of the page",
        label="Colour",
        option="--colour",
        choices={
            "colour": Choice("Colour", "as in the photos"),
            "grey": Choice("Greyscale", "shades of grey"),
            "black-and-white": Choice(
                "Black and White", "ink black, paper white; page.tif and page.pdf are then small and lossless (Group 4)"
            ),
        },
    )
    bake: bool = setting(
        False,
        "also have Blender bake the page into page_baked.tif, from the reference photo with linear sampling",
        label="Bake",
        option="--bake",
        in_panel=False,
    )


@dataclass(frozen=True)
class RunSettings:
    """Everything that decides what a run computes.

    The outline is a list of corners (x, y), the creases a list of ends (x0, y0, x1, y1), both in pixels of the
    reference photo as stored; they need a named reference photo.
    """

    sfm: SfmSettings = group_of_settings(SfmSettings, "how the photos are placed", label="Placement", stage="place")
    surface: SurfaceSettings = group_of_settings(
        SurfaceSettings, "how the surface is fitted", label="Surface", stage="surface"
    )
    flatten: FlattenSettings = group_of_settings(
        FlattenSettings, "how the sheet is unwrapped", label="Unwrap", stage="unwrap"
    )
    page: PageSettings = group_of_settings(
        PageSettings, "size and orientation of the page", label="Page", stage="lay_out"
    )
    image: ImageSettings = group_of_settings(ImageSettings, "the page image", label="Image", stage="page")
    colmap_model: str | None = setting(
        None,
        "folder of an existing COLMAP model of the photos, binary or text, to use instead of structure from motion",
        label="COLMAP Model",
        option="--colmap-model DIR",
        stage="place",
    )
    reference: str | None = setting(
        None,
        "file name of the photo in which the paper's edge is found and its surface built; with its folder if several "
        "photos have that name",
        label="Reference Photo",
        option="--reference NAME",
        without="the photo that shows the sheet largest, sharpest, whole and least oblique",
        stage="find",
    )
    sheet: int | EverySheet = setting(
        1,
        "which sheet to take if several are in view: 1 is the one in the middle that most photos show",
        label="Sheet",
        option="--sheet N",
        least=1,
        most=100,
        choices={"all": Choice("All", "make a page of each, in OUT/sheet-1, OUT/sheet-2 and so on")},
        stage="find",
    )
    outline: tuple[tuple[float, float], ...] | None = setting(
        None,
        "the paper's edge in the reference photo: the outline.json of another run, or a JSON list of corners [[x, y], "
        "...] in pixels of the file as stored, before any EXIF rotation; a list needs --reference",
        option="--outline FILE",
        without="found",
        stage="find",
    )
    creases: tuple[tuple[float, float, float, float], ...] | None = setting(
        None,
        "all straight creases of the sheet: the creases.json of another run, or a JSON list of their ends [[x0, y0, "
        "x1, y1], ...] in the same pixels as the outline, or [] for a sheet without creases; a list needs --reference",
        option="--creases FILE",
        without="found",
        stage="surface",
    )

    def check(self) -> None:
        """Check that a run can use all values.

        Raises
        ------
        UsageError
            If it cannot; the message is one sentence about the first such value.
        """
        size, allowed = self.page.paper_size_mm, declaration(PageSettings, "paper_size_mm")
        assert allowed.least is not None and allowed.most is not None
        if size is not None and not all(s is None or allowed.least <= s <= allowed.most for s in size):
            raise UsageError(
                f"The paper size must be between {allowed.least:g} and {allowed.most:g} mm; write it as A4, 210x297, "
                "80 (the width alone) or none."
            )
        if self.image.dpi is not None and size is None:
            raise UsageError(
                "A resolution in dpi needs the paper's size; give it, for example A4 (--paper, or Paper in Blender)."
            )
        self._check_outline()
        self._check_creases()
        if self.sheet == "all" and (self.outline is not None or self.creases is not None):
            raise UsageError(
                "An outline and creases belong to one sheet; name that sheet (--sheet 1, --sheet 2, ...), or leave "
                "them out."
            )
        check_ranges(self)
        self._check_page_size()

    def _check_page_size(self) -> None:
        if self.image.dpi is None or self.page.paper_size_mm is None:
            return
        longest = max(side for side in self.page.paper_size_mm if side is not None)
        pixels = longest * self.image.dpi / MILLIMETRES_PER_INCH
        if pixels > LONGEST_PAGE_SIDE:
            raise UsageError(
                f"At {self.image.dpi:g} dpi a page of {longest:g} mm would be {pixels:.0f} pixels long; choose "
                f"fewer dpi, at most {LONGEST_PAGE_SIDE * MILLIMETRES_PER_INCH / longest:.0f}."
            )

    def _check_outline(self) -> None:
        if self.outline is None:
            return
        if len(self.outline) > _MOST_CORNERS:
            raise UsageError(f"The outline has {len(self.outline)} corners; give at most {_MOST_CORNERS}.")
        _check_in_a_photo("outline", self.outline)
        if self.reference is None:
            raise UsageError("An outline belongs to one photo; name it with --reference.")
        if len(self.outline) < 3:
            raise UsageError("The outline needs at least three corners [x, y], in pixels of the reference photo.")
        polygon = np.array(self.outline)
        if not is_simple(polygon) or signed_area(polygon) == 0:
            raise UsageError(
                "The outline crosses or touches itself; list its corners in order around the paper, each one once."
            )

    def _check_creases(self) -> None:
        if not self.creases:
            return
        _check_in_a_photo("creases", self.creases)
        if self.reference is None:
            raise UsageError("Creases belong to one photo; name it with --reference.")
        for number, (x0, y0, x1, y1) in enumerate(self.creases, 1):
            if (x0, y0) == (x1, y1):
                raise UsageError(f"Crease {number} has no length; give its two ends [x0, y0, x1, y1], or remove it.")


def _check_in_a_photo(what: str, pixels: Sequence[tuple[float, ...]]) -> None:
    """Refuse pixels beside any photo, because their squares might have no number.

    Raises
    ------
    UsageError
    """
    if any(abs(number) > _MOST_PIXELS for place in pixels for number in place):
        raise UsageError(
            f"The {what} would leave any photo; give pixels of the file as stored, before any EXIF rotation."
        )
