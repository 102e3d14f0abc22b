"""Specks of something else along the page's edge, where the outline is a pixel or two outside the paper."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

# Values without a figure are choices; no measurement of them is recorded.
# Of the page's longer side: a crumb reaches no farther in, 1.2 mm on A4. Outlines are right to a third of that.
_DEEPEST = 0.004
# Share of the paper's light below which a pixel is not paper, and below which one beside it belongs to it.
_DARK, _DIM = 0.75, 0.93
_TOUCHES = 2  # pixels from the page's edge
# Side of a block of the page, in the depth of a crumb. A strip all along an edge is judged block by block: somewhere it
# meets print that goes on inside.
_BLOCK = 4


def find_crumbs(light: NDArray[np.float32], covered: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which pixels (H, W) of an evenly lit page show what is beside the paper.

    A crumb is dark, touches the page's edge, and ends close to it. Print that runs over the edge goes on inside.

    Parameters
    ----------
    light : (H, W) array
        Light of each pixel as a share of blank paper's.
    covered : (H, W) bool array
        Where the page is in a photo.
    """
    deepest = max(round(_DEEPEST * max(light.shape)), _TOUCHES + 1)
    rim = covered & ~_eroded(covered, deepest + 1)
    dim = rim & (light < _DIM)
    part, count = _parts(dim, _BLOCK * deepest)
    if not count:
        return dim
    touches, dark, inner = (
        np.bincount(part[where], minlength=count + 1) > 0
        for where in (dim & ~_eroded(covered, _TOUCHES), dim & (light < _DARK), dim & _eroded(covered, deepest))
    )
    crumb = touches & dark & ~inner
    crumb[0] = False
    return np.asarray(ndimage.binary_dilation(crumb[part], np.ones((3, 3))) & rim)


def find_slivers(covered: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which pixels (H, W) lie in what no photo shows and is thinner than a crumb is deep, as beside the paper's edge.

    Parameters
    ----------
    covered : (H, W) bool array
        Where the page is in a photo.
    """
    radius = max(round(_DEEPEST * max(covered.shape) / 2), 1)
    hidden = ~covered
    thick = ndimage.maximum_filter(_eroded(hidden, radius), 2 * radius + 1, mode="constant", cval=0)
    return np.asarray(hidden & ~thick)


def _parts(mask: NDArray[np.bool_], block: int) -> tuple[NDArray[np.int64], int]:
    """The number (H, W) of each part of a mask that hangs together within a block, 0 outside, and how many they are."""
    part, _ = ndimage.label(mask, np.ones((3, 3)))
    rows, columns = np.nonzero(mask)
    blocks = (rows // block) * (mask.shape[1] // block + 1) + columns // block
    number = np.zeros(mask.shape, np.int64)
    pairs = np.stack([part[rows, columns].astype(np.int64), blocks])
    each, index = np.unique(pairs, axis=1, return_inverse=True)
    number[rows, columns] = index.reshape(-1) + 1
    return number, each.shape[1]


def _eroded(mask: NDArray[np.bool_], pixels: int) -> NDArray[np.bool_]:
    """The mask without what is nearer to its edge, or the picture's, than this."""
    return np.asarray(ndimage.minimum_filter(mask, 2 * pixels + 1, mode="constant", cval=0))
