"""Measures the noise of the points, from the points alone."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Array
from ..numeric.local_fit import local_fits
from ..numeric.robust import MAD_TO_SIGMA

# Four neighbours for each of the six unknowns of a quadratic, found in this many rounds of least squares. Choices.
_NEIGHBOURS = 24
_QUADRATIC_TERMS = 6
_ITERATIONS = 6
_RIDGE = 1e-9  # on the diagonal of the normal equations: neighbours in a row determine no quadratic
# No photos measure depth better than this share of the page length.
_FLOOR = 1e-5


def point_noise(positions: Array, values: Array) -> float:
    """Standard deviation of scattered values about the smooth surface that they sample.

    Each point is compared with the robust quadratic through its nearest neighbours; the median over all points is
    robust to creases and outliers.

    Parameters
    ----------
    positions : (N, 2) array
    values : (N,) array

    Returns
    -------
    float
        In the unit of ``values``, page lengths.
    """
    count = min(_NEIGHBOURS, len(values))
    _, near = cKDTree(positions).query(positions, k=count)
    offset = positions[near] - positions[:, None]
    offset = offset / (np.abs(offset).max(axis=(1, 2), keepdims=True) + 1e-300)
    x, y = offset[..., 0], offset[..., 1]
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    _, residual = local_fits(terms, values[near][..., None], np.ones(near.shape), _reweighed, _ITERATIONS, ridge=_RIDGE)
    lost = np.sqrt(count / max(count - _QUADRATIC_TERMS, 1))
    return float(max(MAD_TO_SIGMA * np.median(residual) * lost, _FLOOR))


def _reweighed(residual: Array) -> Array:
    """Weights of a loss that is linear beyond the median residual of each neighbourhood."""
    return 1 / np.maximum(residual, np.median(residual, axis=1, keepdims=True) + 1e-12)
