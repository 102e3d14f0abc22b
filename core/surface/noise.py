"""How noisy the points are, measured from the points alone."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Array

_NEIGHBOURS = 24
_QUADRATIC_TERMS = 6
_ITERATIONS = 6
# No photos measure depth better than this share of the page length.
_FLOOR = 1e-5
# Standard deviation of a normal distribution over its median absolute deviation.
_MAD_TO_SIGMA = 1.4826


def point_noise(positions: Array, values: Array) -> float:
    """Standard deviation of scattered values about the smooth surface they sample.

    Each point is compared with the robust quadratic through its nearest neighbours; the median over all points
    forgives creases and outliers.

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
    target = values[near]
    weight = np.ones_like(target)
    for _ in range(_ITERATIONS):
        weighted = terms * weight[..., None]
        normal = np.einsum("nki,nkj->nij", weighted, terms) + 1e-9 * np.eye(_QUADRATIC_TERMS)
        solution = np.linalg.solve(normal, np.einsum("nki,nk->ni", weighted, target)[..., None])[..., 0]
        residual = target - np.einsum("nki,ni->nk", terms, solution)
        spread = np.median(np.abs(residual), axis=1, keepdims=True) + 1e-12
        weight = 1 / np.maximum(np.abs(residual), spread)
    lost = np.sqrt(count / max(count - _QUADRATIC_TERMS, 1))
    return float(max(_MAD_TO_SIGMA * np.median(np.abs(residual)) * lost, _FLOOR))
