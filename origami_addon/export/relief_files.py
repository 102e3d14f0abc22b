"""The sheet's relief as pictures for a plane with the page on it: the normal map and the displacement map."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ...core.arrays import Indices
from ...core.page.raster import PageLookup
from ...core.relief.relief import Relief, find_relief
from ...core.relief.relief_maps import covering_lookup, displacement_map, normal_map
from ...core.sheet import FlatMap, Sheet
from ..files.exr import write_exr
from ..files.image_files import write_data_png
from ..state import Page

# Pixels of a map's longer side: 4K, the largest picture that all programs of 3D artists take.
_LONGEST = 4096
_NORMALS = (
    "Normal map in tangent space: x right, y up (OpenGL), z out of the printed side; 0 is -1, white is 1. Not a colour."
)
_HEIGHTS = (
    "Height over the flat page in page heights (Midlevel 0; Scale: the height of the plane), positive out of the "
    "printed side."
)


@dataclass(frozen=True)
class PageRelief:
    """The relief of a page, and the pixels of its maps.

    Attributes
    ----------
    relief : Relief
    triangles : (F, 3) int array
        Of the sheet.
    lookup : PageLookup
        Of the maps' pixels: as large as the page, up to 4K.
    dpi : float
        Their resolution.
    """

    relief: Relief
    triangles: Indices
    lookup: PageLookup
    dpi: float


def relief_of_page(sheet: Sheet, flat: FlatMap, page: Page) -> PageRelief:
    """Find the relief of a page."""
    height, width = page.texture.image.shape[:2]
    scale = min(1, _LONGEST / max(height, width))
    lookup = covering_lookup(sheet, flat, (max(round(width * scale), 1), max(round(height * scale), 1)))
    return PageRelief(find_relief(sheet, flat), sheet.triangles, lookup, page.dpi * lookup.triangle.shape[0] / height)


def write_normal_map(path: Path, page: PageRelief) -> None:
    """Write where the paper faces, with 16 bits for each number.

    Raises
    ------
    StepFailed
        If it could not be written (as for all functions here).
    """
    write_data_png(path, normal_map(page.relief, page.lookup), page.dpi, _NORMALS)


def write_displacement_map(path: Path, page: PageRelief) -> dict[str, float]:
    """Write the height of the relief; returns its lowest and highest place, in page heights, for the report."""
    heights = displacement_map(page.relief, page.triangles, page.lookup)
    write_exr(path, heights, _HEIGHTS)
    return {"lowest_page_heights": float(heights.min()), "highest_page_heights": float(heights.max())}
