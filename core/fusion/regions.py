"""Few and large regions of the page, each with the photo that shows it best."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array

# The values below are choices; no measurement of them is recorded.
_SMALLEST_REGION = 0.005  # of the page
# How much the logarithm of a photo's score counts, and how much the photos chosen around a cell within this standard
# deviation (cells), which is applied this many times. Not seeing a cell outweighs both.
_SCORE_WEIGHT, _AROUND_WEIGHT, _AROUND, _ROUNDS, _UNSEEN = 4, 8, 5.0, 15, -1e3


def choose_regions(score: NDArray[np.float32], visible: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Give each cell the photo of the best score, in large regions.

    Parameters
    ----------
    score : (n, h, w) array
        Positive where a photo shows the cell well.
    visible : (n, h, w) bool array

    Returns
    -------
    (h, w) int array
        A photo that sees the cell; -1 where none does.
    """
    cost: Array = np.where(visible, np.log(np.maximum(score, 1e-12)), _UNSEEN)
    cost -= cost.max(axis=0)
    belief = _softmax(_SCORE_WEIGHT * cost)
    for _ in range(_ROUNDS):
        around = np.stack([ndimage.gaussian_filter(part, _AROUND) for part in belief])
        belief = _softmax(_SCORE_WEIGHT * cost + _AROUND_WEIGHT * around)
    label = np.where(visible.any(axis=0), belief.argmax(axis=0), -1)
    return _without_islands(label, visible)


def _softmax(values: Array) -> Array:
    powers = np.exp(values - values.max(axis=0))
    return powers / powers.sum(axis=0)


def _without_islands(label: NDArray[np.int64], visible: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Give small regions to the photo beside them, if it sees them."""
    large = np.zeros(label.shape, bool)
    for photo in range(len(visible)):
        region, count = ndimage.label(label == photo)
        size = np.bincount(region.ravel(), minlength=count + 1)
        size[0] = 0
        large |= size[region] >= _SMALLEST_REGION * label.size
    if not large.any():
        return label
    nearest = ndimage.distance_transform_edt(~large, return_distances=False, return_indices=True)
    beside = label[tuple(nearest)]
    sees = np.take_along_axis(visible, beside[None], axis=0)[0]
    return np.where(~large & sees & (label >= 0), beside, label)
