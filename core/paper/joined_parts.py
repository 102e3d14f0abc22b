"""Regions that touch along a whole side: the parts of one folded sheet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..numeric.morphology import Mask, fill_holes
from ..numeric.polygon import resample, signed_area, smallest_rectangle
from .sheet_hypotheses import COARSE, Hypothesis

# Values without a figure are choices; no measurement of them is recorded.
# Two outlines touch where they are this near, coarse cells: both end at the same fold, each to within a cell.
_TOUCH = 2.5
# A whole side touches if the touching length differs from the side's by less than this part of it.
_WHOLE_SIDE = 0.2
# Together, the parts of a sheet fill this part of the smallest rectangle around them. Chosen, not measured: the gap at
# the fold is missing, and a raised part is a little askew in the map.
_FILLED = 0.85


def lie_flush(hypotheses: Sequence[Hypothesis]) -> NDArray[np.bool_]:
    """Which pairs of regions (K, K) touch along a whole side of both, and together look like one sheet.

    The parts of a folded sheet do. Two sheets on a table hardly ever share a whole side.
    """
    count = len(hypotheses)
    flush = np.zeros((count, count), bool)
    outlines = [resample(each.polygon / COARSE, 1.0) for each in hypotheses]
    away = [ndimage.distance_transform_edt(~each.mask) for each in hypotheses]
    sides = [_sides(each.polygon / COARSE) for each in hypotheses]
    for first, second in zip(*np.triu_indices(count, 1), strict=True):
        touching = [_touching(outlines[a], away[b]) for a, b in ((first, second), (second, first))]
        whole = all(
            (np.abs(length - sides[index]) < _WHOLE_SIDE * sides[index]).any()
            for length, index in zip(touching, (first, second), strict=True)
        )
        if whole and _filled(hypotheses[first], hypotheses[second]) > _FILLED:
            flush[first, second] = flush[second, first] = True
    return flush


def joined(first: Hypothesis, second: Hypothesis) -> Hypothesis:
    """The sheet of which two touching regions are the parts."""
    return Hypothesis.around(_together(first.mask, second.mask))


def _sides(polygon: Array) -> Array:
    """Lengths (2,) of the smallest rectangle around a polygon."""
    rectangle = smallest_rectangle(polygon)
    return np.linalg.norm(rectangle[[1, 2]] - rectangle[[0, 1]], axis=1)


def _touching(outline: Array, away: Array) -> int:
    """How long an outline, in points one cell apart, runs within reach of a region; ``away`` is the distance to it."""
    column, row = np.floor(outline).astype(np.int64).T
    inside = (row >= 0) & (column >= 0) & (row < away.shape[0]) & (column < away.shape[1])
    return int((away[row[inside], column[inside]] < _TOUCH).sum())


def _filled(first: Hypothesis, second: Hypothesis) -> float:
    around = smallest_rectangle(np.vstack([first.polygon, second.polygon])) / COARSE
    return float((first.mask | second.mask).sum() / max(abs(signed_area(around)), 1.0))


def _together(first: Mask, second: Mask) -> Mask:
    """Both regions and the gap between them."""
    reach = round(_TOUCH)
    padded = np.pad(first | second, reach)
    closed = ndimage.binary_closing(padded, iterations=reach)
    return fill_holes(closed[reach:-reach, reach:-reach])
