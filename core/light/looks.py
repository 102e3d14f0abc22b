"""The looks of a page: as photographed, evenly lit with its paper's own tone, or on white."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..numeric.image import Image, encoded, linear_light
from ..sheet import FlatMap, Sheet
from .crease_light import light_beside_creases
from .crumbs import find_crumbs, find_slivers
from .shading import find_shading

Look = Literal["paper", "white", "as-photographed"]

# Linear light of the strongest channel of blank paper in the look "paper": white paper reflects about this much of it.
_PAPER = 0.88
_ROWS = 256  # of the page image at once


@dataclass(frozen=True)
class Relit:
    """A page in a look.

    Attributes
    ----------
    image : (H, W, 3) array
        Of the page's type.
    blank : (h, w) bool array or None
        Which of the page's cells (`blank_paper.even_cells`) are blank paper; None if there is too little to know the
        light by, and the page is as photographed.
    paper : (3,) array or None
        Linear light of blank paper in the photos, median over the page.
    """

    image: Image
    blank: NDArray[np.bool_] | None
    paper: Array | None


def relit(image: Image, covered: NDArray[np.bool_], sheet: Sheet, flat: FlatMap, look: Look) -> Relit:
    """Take the light off a page, and the crumbs of the table along its edge.

    Parameters
    ----------
    image : (H, W, 3) uint8 or uint16 array
        The page in sRGB, as photographed.
    covered : (H, W) bool array
        Where it is in a photo; the rest stays.
    sheet : Sheet
    flat : FlatMap
    look : {"paper", "white", "as-photographed"}
        ``"paper"``: evenly lit, the paper in its own tone. ``"white"``: the paper is white. ``"as-photographed"``: the
        page as it is.
    """
    if look not in get_args(Look):
        raise ValueError(f"look must be one of {get_args(Look)}, not {look!r}")
    shading = find_shading(image, covered, sheet, flat)
    if shading is None:
        return Relit(image, None, None)
    if look == "as-photographed":
        return Relit(image, shading.blank, shading.paper)
    target = _PAPER * shading.paper / shading.paper.max() if look == "paper" else np.ones(3)
    height, width = covered.shape
    creases = light_beside_creases(image, sheet, flat, partial(shading.on_rows, width))
    out = image.copy()
    share_of_paper = np.ones((height, width), np.float32)
    for top in range(0, height, _ROWS):
        rows = slice(top, min(top + _ROWS, height))
        light = shading.on_rows(width, rows)
        creases.correct(light, top)
        # the page's outermost pixels lie partly off the sheet
        light = np.where(np.isfinite(light), light, shading.paper.astype(np.float32))
        lit = covered[rows]
        reflected = linear_light(image[rows]) / light
        out[rows][lit] = encoded(reflected[lit] * target.astype(np.float32), image.dtype)
        share_of_paper[rows][lit] = reflected[lit].mean(axis=-1)
    out[find_crumbs(share_of_paper, covered) | find_slivers(covered)] = encoded(target.astype(np.float32), image.dtype)
    return Relit(out, shading.blank, shading.paper)
