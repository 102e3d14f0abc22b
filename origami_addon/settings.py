"""All settings of a run in one place; the same ones for the command line, a settings file and the report."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ..core.errors import UsageError
from ..core.flatten import FlattenSettings
from ..core.polygon import signed_area
from ..core.simple_polygon import is_simple
from ..core.surface import SurfaceSettings
from .sfm.client import SfmSettings

PaperSize = tuple[float, float | None]
EverySheet = Literal["all"]

LONGEST_PAGE_SIDE = 32000  # pixels
MILLIMETRES_PER_INCH = 25.4
MOST_SHEETS = 100


@dataclass(frozen=True)
class PageSettings:
    """Size and orientation of the flat page.

    Attributes
    ----------
    paper_size_mm : (width, height) or None
        Of the page, either way round. The height may be None: then it follows from the sheet, as for a receipt of
        known width. None where nothing is known.
    turn : {"auto", "0", "90", "180", "270"}
        Degrees clockwise from the reference photo to the page; ``auto`` takes the direction of the text, and the
        photos' up where that cannot be told.
    """

    paper_size_mm: PaperSize | None = None
    turn: Literal["auto", "0", "90", "180", "270"] = "auto"


@dataclass(frozen=True)
class ImageSettings:
    """The page image.

    Attributes
    ----------
    dpi : float or None
        Pixels per inch; None for the photo's own pixel density. Needs the paper's size.
    source : {"healed", "reference", "best"}
        From the reference photo, with its glare, blur and passing shadows healed from other photos; all from the
        reference photo, untouched; or each region from the photo that shows it largest and sharpest.
    bake : bool
        Whether Blender bakes the page as well, from the reference photo, into a second file.
    """

    dpi: float | None = None
    source: Literal["healed", "reference", "best"] = "healed"
    bake: bool = False


@dataclass(frozen=True)
class RunSettings:
    """Everything that decides what a run computes.

    Attributes
    ----------
    sfm : SfmSettings
    surface : SurfaceSettings
    flatten : FlattenSettings
    page : PageSettings
    image : ImageSettings
    colmap_model : str or None
        Folder of an existing COLMAP model (binary or text) of the photos, instead of structure from motion.
    reference : str or None
        Name of the reference photo; None to choose it.
    sheet : int or "all"
        Which of the sheets in view: 1 is the one that the photos are most likely of. All of them become a page each on
        the command line alone.
    outline : tuple of (x, y) or None
        The paper's edge in the reference photo, which must then be named, pixels as stored in the file; None to find
        it.
    creases : tuple of (x0, y0, x1, y1) or None
        The ends of all straight creases, in the same pixels as the outline; none for a sheet without any, None to
        find them.
    """

    sfm: SfmSettings = field(default_factory=SfmSettings)
    surface: SurfaceSettings = field(default_factory=SurfaceSettings)
    flatten: FlattenSettings = field(default_factory=FlattenSettings)
    page: PageSettings = field(default_factory=PageSettings)
    image: ImageSettings = field(default_factory=ImageSettings)
    colmap_model: str | None = None
    reference: str | None = None
    sheet: int | EverySheet = 1
    outline: tuple[tuple[float, float], ...] | None = None
    creases: tuple[tuple[float, float, float, float], ...] | None = None

    def check(self) -> None:
        """Look for values that no run could use.

        Raises
        ------
        UsageError
            With one sentence on the first of them.
        """
        size = self.page.paper_size_mm
        if size is not None and not all(s is None or 5 <= s <= 5000 for s in size):
            raise UsageError(
                "The paper size must lie between 5 and 5000 mm; write it like A4, 210x297, 80 (width alone) or none."
            )
        if self.image.dpi is not None and size is None:
            raise UsageError(
                "A resolution in dpi needs the paper's size; name it, for example A4 (--paper, or Paper in Blender)."
            )
        self._check_outline()
        self._check_creases()
        self._check_sheet()
        for name, value, lowest, highest in (
            ("grid_rows", self.surface.grid_rows, 20, 400),
            ("smoothness", self.surface.smoothness, 1e-4, 1e4),
            ("ridge_curvature", self.surface.ridge_curvature, 1e-3, 1e4),
            ("ridge_emphasis", self.surface.ridge_emphasis, 1.001, 1e6),
            ("dpi", self.image.dpi, 20, 4800),
            ("threads", self.sfm.threads, 1, 1024),
            ("seed", self.sfm.seed, 0, 2**31 - 1),
            ("max_image_size", self.sfm.max_image_size, 400, 20000),
            ("max_features", self.sfm.max_features, 100, 100000),
        ):
            if value is not None and not lowest <= value <= highest:
                raise UsageError(f"{name} must lie between {lowest:g} and {highest:g}, not be {value:g}; change it.")
        self._check_page_size()

    def _check_sheet(self) -> None:
        if self.sheet != "all":
            if not 1 <= self.sheet <= MOST_SHEETS:
                raise UsageError(
                    f"sheet must be all, or a number from 1 to {MOST_SHEETS}, not {self.sheet}; change it."
                )
        elif self.outline is not None or self.creases is not None:
            raise UsageError(
                "An outline and creases belong to one sheet; name it (--sheet 1, --sheet 2, ...), or leave them out."
            )

    def _check_page_size(self) -> None:
        if self.image.dpi is None or self.page.paper_size_mm is None:
            return
        longest = max(side for side in self.page.paper_size_mm if side is not None)
        pixels = longest * self.image.dpi / MILLIMETRES_PER_INCH
        if pixels > LONGEST_PAGE_SIDE:
            raise UsageError(
                f"At {self.image.dpi:g} dpi a page of {longest:g} mm would be {pixels:.0f} pixels long; choose fewer, "
                f"at most {LONGEST_PAGE_SIDE * MILLIMETRES_PER_INCH / longest:.0f}."
            )

    def _check_outline(self) -> None:
        if self.outline is None:
            return
        if self.reference is None:
            raise UsageError("An outline belongs to one photo; name it with --reference.")
        if len(self.outline) < 3:
            raise UsageError("The outline needs at least three corners [x, y], in pixels of the reference photo.")
        polygon = np.array(self.outline)
        if not is_simple(polygon) or signed_area(polygon) == 0:
            raise UsageError(
                "The outline crosses or touches itself; give its corners in their order around the paper, each once."
            )

    def _check_creases(self) -> None:
        if not self.creases:
            return
        if self.reference is None:
            raise UsageError("Creases belong to one photo; name it with --reference.")
        for number, (x0, y0, x1, y1) in enumerate(self.creases, 1):
            if (x0, y0) == (x1, y1):
                raise UsageError(f"Crease {number} has no length; give its two ends [x0, y0, x1, y1], or take it out.")
