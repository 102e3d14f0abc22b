"""Affine maps and similarities applied to points, and what they leave of the distance between two sets of points."""

from __future__ import annotations

import numpy as np

from ..core.arrays import Array
from ..core.flat.distortion import apply_affine


def displacement(source: Array, target: Array, transform: Array) -> Array:
    """Distance (N,) from ``target`` (N, 2) to ``source`` (N, 2) once ``transform`` (2, 3) is applied to ``source``."""
    return np.linalg.norm(apply_affine(transform, source) - target, axis=1)
