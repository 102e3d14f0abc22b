"""What blank paper says of a page image: its colour, how evenly it is lit, and how noisy it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..numeric.cielab import cielab
from ..numeric.image import Image, linear_light
from .blank_paper import even_cells

# Values without a figure are choices; no measurement of them is recorded.
_SPREAD = (5, 95)  # percentiles between which light is uneven: of print and dirt beside blank paper little is left
_MOST_TILES = 2000  # in which noise is measured: with this many, its median is right to 2 %
_WHOLE = 0.99  # share of a tile's pixels that are even


@dataclass(frozen=True)
class PaperFigures:
    """The blank paper of a page in CIELAB, under the white of sRGB.

    Attributes
    ----------
    color : (3,) array
        L*, a* and b*, median. The paper's own tone, and what white balance is off, are both in it.
    unevenness : float
        L*, between the 5th and the 95th percentile of places of 1/256 of the page's longer side.
    noise : float or None
        L*, standard deviation of pixels within such a place, median over all places; None if none is wholly blank.
    """

    color: Array
    unevenness: float
    noise: float | None


def measure_paper(image: Image, covered: NDArray[np.bool_], blank: NDArray[np.bool_]) -> PaperFigures | None:
    """Measure the blank paper of a page.

    Parameters
    ----------
    image : (H, W, 3) uint8 or uint16 array
        The page in sRGB.
    covered : (H, W) bool array
        Where it is in a photo.
    blank : (h, w) bool array
        Which of its cells, as by `blank_paper.even_cells`, are blank paper.

    Returns
    -------
    PaperFigures or None
        None if no cell of the image is even where paper is blank.
    """
    cells = even_cells(image, covered)
    known = blank & (cells.share > 0)
    if not known.any():
        return None
    color = cielab(np.exp(cells.color[known]))
    low, high = np.percentile(color[:, 0], _SPREAD)
    noise = _noise(image, known & (cells.share > _WHOLE), round(cells.per_cell))
    return PaperFigures(np.median(color, axis=0).astype(float), float(high - low), noise)


def _noise(image: Image, whole: NDArray[np.bool_], side: int) -> float | None:
    """Standard deviation of L* within a tile of this many pixels, less its slope, which is light: median of tiles."""
    rows, columns = np.nonzero(whole)
    if not len(rows):
        return None
    chosen = np.linspace(0, len(rows) - 1, min(len(rows), _MOST_TILES)).astype(int)
    tiles = np.stack([image[y : y + side, x : x + side] for y, x in (side * np.stack([rows, columns], axis=1))[chosen]])
    light = cielab(linear_light(tiles.reshape(-1, side, 3)))[..., 0].reshape(len(tiles), -1).astype(float)
    y, x = np.mgrid[:side, :side].reshape(2, -1)
    plane = np.linalg.qr(np.stack([np.ones(side**2), x, y], axis=1))[0]
    rest = light - light @ plane @ plane.T
    return float(np.median(np.sqrt((rest**2).sum(axis=1) / (side**2 - 3))))
