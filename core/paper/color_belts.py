"""Compare the colours in wide belts inside and outside a region's edge: a cloth's pattern is the same in both."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..numeric.morphology import Mask, bounds

# The values below are choices; no measurement of them is recorded.
# Width of a belt, as a part of the region's side (the root of its area), and width of the strip beside the edge that is
# left out, cells.
_WIDTH, _BLURRED = 0.15, 1.5
# Size of the bins of lightness and of both opponent colours, which are doubled, in Oklab times 100; and the standard
# deviation that softens the histogram, bins.
_BIN = np.array([10.0, 12.0, 12.0])
_SOFT = 0.7
# A belt with fewer known cells says nothing.
_FEWEST_CELLS = 20


class ColorBelts:
    """A map's colours, counted in bins.

    Parameters
    ----------
    color : (h, w, 3) float32 array
        Lightness, and the opponent colours times two.
    known : (h, w) bool array
        Which cells count.
    """

    def __init__(self, color: NDArray[np.float32], known: Mask) -> None:
        bins = np.round(color / _BIN).astype(np.int64)
        bins -= bins.min(axis=(0, 1))
        self.shape = tuple(int(most) + 1 for most in bins.max(axis=(0, 1)))
        self.bin = np.ravel_multi_index(tuple(np.moveaxis(bins, -1, 0)), self.shape)
        self.known = known

    def difference(self, mask: Mask) -> float:
        """How differently a region (h, w) and its surroundings are coloured along its edge.

        Returns
        -------
        float
            1 minus the coefficient of Bhattacharyya (1943) of the two belts' histograms: 0 if they are alike and 1 if
            they share no colour. 0 if hardly any of a belt is known.
        """
        width = _WIDTH * np.sqrt(mask.sum())
        around = bounds(mask, int(width) + 1)
        mask, known, bins = mask[around], self.known[around], self.bin[around]
        histograms = []
        for side in (mask, ~mask):
            depth = ndimage.distance_transform_edt(side)
            belt = (depth > _BLURRED) & (depth < width) & known
            if belt.sum() < _FEWEST_CELLS:
                return 0.0
            counts = np.bincount(bins[belt], minlength=int(np.prod(self.shape))).reshape(self.shape)
            soft = ndimage.gaussian_filter(counts.astype(float), _SOFT, mode="constant")
            histograms.append(soft / soft.sum())
        return float(1 - np.sqrt(histograms[0] * histograms[1]).sum())
