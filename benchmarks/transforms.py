"""Affine maps and similarities applied to points, and what they leave of the distance between two sets of points."""

from __future__ import annotations

import numpy as np

from ..core.arrays import Array


def apply(transform: Array, points: Array) -> Array:
    """Points (N, 2) once ``transform`` (2, 3) is applied to them."""
    return points @ transform[:, :2].T + transform[:, 2]


def displacement(source: Array, target: Array, transform: Array) -> Array:
    """Distance (N,) from ``target`` (N, 2) to ``source`` (N, 2) once ``transform`` (2, 3) is applied to ``source``."""
    return np.linalg.norm(apply(transform, source) - target, axis=1)
