"""The facing page of an open book: what lies beyond a valley and out of the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .camera import Array
from .sparse_model import SparseModel

_DIRECTIONS = 60
_OFFSETS = 60
_MOST_POINTS = 2000
_FEWEST_BESIDE = 12
_LEAST_SLOPE = 0.15


def facing_page(model: SparseModel, prominence: Array) -> NDArray[np.bool_]:
    """Points (N,) of a page that adjoins the sheet at a valley but is no part of it.

    A valley alone may be a fold of the sheet. The facing page is told by this: most photos cut it off, while they show
    what lies on the other side whole.

    Parameters
    ----------
    model : SparseModel
    prominence : (N,) array
        As `reference_view.prominence` gives it, 0 for points to be left out (those of the desk).
    """
    result = np.zeros(len(model.points), bool)
    used = np.flatnonzero(prominence > 0)
    if len(used) < 2 * _FEWEST_BESIDE:
        return result
    plane, height = _over_main_plane(model, model.points[used], prominence[used])
    few = np.random.default_rng(0).permutation(len(used))[:_MOST_POINTS]
    size = float(np.sqrt(prominence[used] ** 2 @ (plane**2).sum(axis=1) / (prominence[used] ** 2).sum()))
    best, best_score = None, 0.0
    for angle in np.arange(_DIRECTIONS) * (2 * np.pi / _DIRECTIONS):
        across = plane @ np.array([np.cos(angle), np.sin(angle)])
        # only lines off the middle: what lies beyond them is the smaller part
        for offset in np.linspace(0.2, 2.5, _OFFSETS) * size:
            score = _valley(across[few] - offset, height[few], 0.4 * size)
            if score > best_score:
                best, best_score = across > offset, score
    if best is not None and _is_cut_off(model, used[best], used[~best]):
        result[used[best]] = True
    return result


def _over_main_plane(model: SparseModel, points: Array, weight: Array) -> tuple[Array, Array]:
    """Position in (N, 2) and height over (N,) the plane through the most prominent points, towards the cameras."""
    share = weight**2 / (weight**2).sum()
    centre = share @ points
    offset = points - centre
    axes = np.linalg.eigh((offset * share[:, None]).T @ offset)[1]
    up = np.mean([camera.center for camera in model.cameras], axis=0) - centre
    normal = axes[:, 0] * np.sign(axes[:, 0] @ up)
    return offset @ axes[:, 1:], offset @ normal


def _valley(across: Array, height: Array, reach: float) -> float:
    """How steeply, and by how many points, the surface rises to both sides of a line; 0 where it does not."""
    slopes, counts = [], []
    for side in (across, -across):
        near = (side > 0) & (side < reach)
        if near.sum() < _FEWEST_BESIDE:
            return 0.0
        distance, rise = side[near], height[near]
        distance = distance - distance.mean()
        slopes.append(float(distance @ rise) / max(float(distance @ distance), 1e-12))
        counts.append(int(near.sum()))
    if min(slopes) < _LEAST_SLOPE:
        return 0.0
    return min(slopes) * float(np.sqrt(min(counts)))


def _is_cut_off(model: SparseModel, beyond: NDArray[np.int64], here: NDArray[np.int64]) -> bool:
    """Whether at least half of the photos end within what lies beyond, but not within what lies here."""
    cut = 0
    for camera in model.cameras:
        outside = []
        for part in (beyond, here):
            pixels = camera.project(model.points[part]) / [camera.width, camera.height]
            outside.append(float((~((pixels > 0.01) & (pixels < 0.99)).all(axis=1)).mean()))
        cut += outside[0] > 0.1 and outside[1] < 0.3 * outside[0]
    return cut >= 0.5 * len(model.cameras)
