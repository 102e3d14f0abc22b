"""Masks grown and shrunk by a disc, and without holes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Mask = NDArray[np.bool_]


def dilated(mask: Mask, radius: float) -> Mask:
    """The pixels within ``radius`` pixels of a mask (h, w), centre to centre.

    Examples
    --------
    >>> dilated(np.eye(1, 7, 3, dtype=bool), 2).astype(int)
    array([[0, 1, 1, 1, 1, 1, 0]])
    """
    result = np.zeros_like(mask)
    around = bounds(mask, int(radius))
    result[around] = _dilated(mask[around], radius)
    return result


def bounds(mask: Mask, margin: int) -> tuple[slice, slice]:
    """The rows and the columns of a mask (h, w) that hold it and this many pixels around it; none if it is empty."""
    rows, columns = (
        slice(max(int(used[0]) - margin, 0), int(used[-1]) + margin + 1) if len(used) else slice(0, 0)
        for used in (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    )
    return rows, columns


def _dilated(mask: Mask, radius: float) -> Mask:
    """Row by row, without the distance of each pixel: for a few pixels, four times as fast as a distance transform."""
    height, width = mask.shape
    nowhere = 2 * width + int(radius) + 1
    column = np.arange(width, dtype=np.int32)
    before = np.maximum.accumulate(np.where(mask, column, -nowhere), axis=1)
    after = np.minimum.accumulate(np.where(mask, column, nowhere)[:, ::-1], axis=1)[:, ::-1]
    away = np.minimum(column - before, after - column)
    result = away <= int(radius)
    for rows in range(1, min(int(radius), height - 1) + 1):
        half = int(np.sqrt(radius**2 - rows**2))
        near = away <= half
        result[rows:] |= near[:-rows]
        result[:-rows] |= near[rows:]
    return np.asarray(result)


def eroded(mask: Mask, radius: float) -> Mask:
    """The pixels of a mask (h, w) that are more than ``radius`` pixels from any outside it; beyond the frame are none.

    Examples
    --------
    >>> eroded(np.array([[0, 1, 1, 1, 1, 1, 1]], bool), 2).astype(int)
    array([[0, 0, 0, 1, 1, 1, 1]])
    """
    result = np.zeros_like(mask)
    around = bounds(mask, 1)
    result[around] = ~_dilated(~mask[around], radius)
    return result


def fill_holes(mask: Mask) -> Mask:
    """The mask and all that it encloses."""
    outside, _ = ndimage.label(np.pad(~mask, 1, constant_values=True))
    return np.asarray(outside[1:-1, 1:-1] != outside[0, 0])
