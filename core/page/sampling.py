"""How finely the photos sample the page: on paper that is seen at a slant, more coarsely than the page's pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Array
from ..sheet import FlatMap, Sheet
from .texture import PageTexture

_STEP = 4  # page pixels along rows and columns between the places that are looked at
_LOWEST = 5  # percentile: the least finely sampled twentieth of the page
_NEAR = 0.01  # of the page's longer side: how near to a crease counts as at it, 3 mm on A4


@dataclass(frozen=True)
class Sampling:
    """Photo pixels per page pixel, in that direction on the page in which there are fewer.

    Below 1, the page has more pixels than detail can be in them.

    Attributes
    ----------
    median : float
        Over the page.
    lowest : float
        Which a twentieth of the page does not reach.
    at_creases : float or None
        Median near creases; None without creases.
    """

    median: float
    lowest: float
    at_creases: float | None


def measure_sampling(texture: PageTexture, sheet: Sheet, flat: FlatMap) -> Sampling | None:
    """Measure how finely the photos that count most in each pixel sample the page; None if no photo shows it."""
    here = texture.position[:-1:_STEP, :-1:_STEP].astype(float)
    right, below = texture.position[:-1:_STEP, 1::_STEP], texture.position[1::_STEP, :-1:_STEP]
    photo = texture.photo[:-1:_STEP, :-1:_STEP]
    same = (photo == texture.photo[:-1:_STEP, 1::_STEP]) & (photo == texture.photo[1::_STEP, :-1:_STEP])
    known = (photo >= 0) & same & np.isfinite(here + right + below).all(axis=-1)
    if not known.any():
        return None
    fewest = _smallest_stretch((right - here)[known], (below - here)[known])
    row, column = np.nonzero(known)
    shape = np.array(texture.photo.shape[::-1])
    places = (np.stack([column, row], axis=1) * _STEP + 0.5) * ([flat.width, flat.height] / shape)
    at = _near_creases(places, sheet, flat)
    low, median = np.percentile(fewest, [_LOWEST, 50])
    return Sampling(float(median), float(low), float(np.median(fewest[at])) if at.any() else None)


def _smallest_stretch(right: Array, below: Array) -> Array:
    """Smaller singular value (N,) of the matrices with these columns (N, 2)."""
    square = (right**2).sum(axis=1) + (below**2).sum(axis=1)
    twice_area = 2 * np.abs(right[:, 0] * below[:, 1] - right[:, 1] * below[:, 0])
    return np.asarray(np.sqrt(square + twice_area) - np.sqrt(np.maximum(square - twice_area, 0))) / 2


def _near_creases(places: Array, sheet: Sheet, flat: FlatMap) -> Array:
    """Which places (N, 2) on the page, in its unit, are at a crease."""
    near = _NEAR * max(flat.width, flat.height)
    lines = [flat.uv[ridge] for ridge in sheet.ridges if len(ridge) > 1]
    if not lines:
        return np.zeros(len(places), bool)
    points = []
    for line in lines:
        length = np.append(0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
        at = np.arange(0, length[-1] + near / 2, near / 2)
        points.append(np.stack([np.interp(at, length, line[:, k]) for k in (0, 1)], axis=1))
    distance, _ = cKDTree(np.concatenate(points)).query(places, distance_upper_bound=near)
    return np.isfinite(distance)
