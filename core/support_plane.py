"""The desk: the plane that carries the sheet and goes on around it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .camera import Array
from .sparse_model import SparseModel

_TRIALS = 600
_SECTORS = 12


def height_above_desk(model: SparseModel, prominence: Array) -> Array | None:
    """Signed distance (N,) of each point from the desk, in units of the noise of the desk's points; up is positive.

    The desk is a plane with nothing below it and points of its own on most sides around what stands above it. A sheet
    that lies flat on a desk cannot be told from it, nor a desk without texture: then there is none.

    Parameters
    ----------
    model : SparseModel
    prominence : (N,) array
        As `reference_view.prominence` gives it; points of 0 are left out of the search.
    """
    used = np.flatnonzero(prominence > 0)
    if len(used) < 50:
        return None
    points = model.points[used]
    centre = np.median(points, axis=0)
    size = float(np.median(np.linalg.norm(points - centre, axis=1)))
    tolerance = 0.004 * size
    up = np.mean([camera.center for camera in model.cameras], axis=0) - centre
    random = np.random.default_rng(0)
    outlying = np.argsort(prominence[used])[: max(len(used) // 2, 50)]
    best, best_count = None, 0
    for _ in range(_TRIALS):
        first, second, third = points[random.choice(outlying, 3, replace=False)]
        normal = np.cross(second - first, third - first)
        length = float(np.linalg.norm(normal))
        if length < 1e-9 * size**2:
            continue
        normal *= np.sign(normal @ up) / length
        height = (points - first) @ normal
        on = int((np.abs(height) < tolerance).sum())
        if on > best_count and (height < -3 * tolerance).mean() < 0.03:
            best, best_count = (first, normal), on
    if best is None or best_count < 30:
        return None
    origin, normal = best
    for _ in range(3):
        on_plane = points[np.abs((points - origin) @ normal) < tolerance]
        origin = on_plane.mean(axis=0)
        fitted = np.linalg.svd(on_plane - origin, full_matrices=False)[2][2]
        normal = fitted * np.sign(fitted @ up)
    height = (points - origin) @ normal
    on = np.abs(height) < tolerance
    above = height > 3 * tolerance
    if not _surrounds(points[on], points[above], prominence[used][above], origin, normal):
        return None
    noise = max(1.4826 * float(np.median(np.abs(height[on]))), 1e-3 * tolerance)
    return np.asarray((model.points - origin) @ normal / noise)


def _surrounds(ground: Array, above: Array, weight: Array, origin: Array, normal: Array) -> bool:
    """Whether, seen from above, there is ground on most sides beyond what stands above it."""
    if len(above) < 20:
        return False
    axes = np.linalg.svd(normal[None])[2][1:]
    flat_ground, flat_above = (ground - origin) @ axes.T, (above - origin) @ axes.T
    middle = (weight**2 @ flat_above) / (weight**2).sum()
    covered = 0
    for sector in range(_SECTORS):
        inside_ground, inside_above = (
            np.linalg.norm(flat[_sector(flat - middle) == sector] - middle, axis=1)
            for flat in (flat_ground, flat_above)
        )
        reach = np.quantile(inside_above, 0.9) if len(inside_above) else 0.0
        covered += int((inside_ground > reach).sum() >= 3)
    return bool(covered >= 0.6 * _SECTORS)


def _sector(offset: Array) -> NDArray[np.int64]:
    angle = np.arctan2(offset[:, 1], offset[:, 0]) / (2 * np.pi) + 0.5
    return np.minimum((angle * _SECTORS).astype(np.int64), _SECTORS - 1)
