"""The residual between two sets of points after an affine map or a similarity."""

from __future__ import annotations

import numpy as np

from ..core.arrays import Array


def displacement(source: Array, target: Array, transform: Array) -> Array:
    """Distance (N,) from ``target`` (N, 2) to ``source`` (N, 2) once ``transform`` (2, 3) is applied to ``source``."""
    return np.linalg.norm(source @ transform[:, :2].T + transform[:, 2] - target, axis=1)
