"""Where a page may be blank paper: even in colour, away from print."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..numeric.image import Image, reduced, reduction_factor, shrink, whole_blocks

# Values without a figure are choices; no measurement of them is recorded.
LIT = 1e-3  # linear light below which a colour is too dark to have a logarithm that means something

# Pixels of the page's longer side at which print is distinguished from paper: letters are 8 pixels high on A4.
_PICTURE = 1024
_CELL = 4  # pixels of that picture along a cell's side
# Largest difference in a square of this many pixels, share of its brightest: noise has 0.02 to 0.04, light across a
# fold 0.05, the soft edge of a shadow 0.1 in the larger square; strokes have more in the smaller one.
_EVEN = {3: 0.07, 7: 0.14}
_EDGE = 6  # pixels along the page's edge, which may show what is beside the paper
_FEWEST = 0.2  # of a cell's pixels that must be even; a choice, as the sizes above are


@dataclass(frozen=True)
class EvenCells:
    """A page of (h, w) cells, and the colour of those that are even.

    Attributes
    ----------
    color : (h, w, 3) float32 array
        Logarithm of linear light, mean over the cell's even pixels; 0 where there are none.
    share : (h, w) float32 array
        Of the cell's pixels that are even; 0 below a fifth.
    light : (h, w) float32 array
        Linear light, mean over all of the cell; 0 near the page's edge.
    per_cell : float
        Pixels of the page image along a cell's side.
    """

    color: NDArray[np.float32]
    share: NDArray[np.float32]
    light: NDArray[np.float32]
    per_cell: float


def even_cells(image: Image, covered: NDArray[np.bool_]) -> EvenCells:
    """The even cells of a page.

    Parameters
    ----------
    image : (H, W, 3) uint8 or uint16 array
    covered : (H, W) bool array
        Where the page is in a photo.
    """
    factor, picture = reduction_factor(image, _PICTURE), reduced(image, _PICTURE)
    inside = whole_blocks(covered, factor)
    inside = ndimage.binary_erosion(inside, iterations=_EDGE)
    light = picture.mean(axis=2)
    even = inside & (picture.min(axis=2) > LIT)
    for side, largest in _EVEN.items():
        most, least = ndimage.maximum_filter(light, side), ndimage.minimum_filter(light, side)
        even &= most - least < largest * most
    share = shrink(even.astype(np.float32), _CELL)
    total = shrink(np.where(even[..., None], np.log(np.maximum(picture, LIT)), 0).astype(np.float32), _CELL)
    share[share < _FEWEST] = 0
    color = np.where(share[..., None] > 0, total / np.maximum(share, 1e-6)[..., None], 0).astype(np.float32)
    whole = whole_blocks(inside, _CELL)
    return EvenCells(color, share, shrink(light, _CELL) * whole, float(factor * _CELL))
