"""Points and cameras as other errors of the observations would have made them.

The wild bootstrap (C. F. J. Wu, "Jackknife, bootstrap and other resampling methods in regression analysis", 1986): each
residual gets a random factor of mean 0 and variance 1. Neighbouring residuals of a photo share what the lens model
cannot take or what the print's windows have in common, so each is split into means over squares of the page, from large
to small, and a rest; each mean has a factor of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..camera import Camera
from ..numeric.robust import observation_weight
from .equations import LENS, LENS_CHANGE, POSE, Equations, expected_lens, linearized, moved
from .triangulation import scatter

# Squares along the page's longer side in which residuals are averaged. Of rendered sheets whose lens is known, the
# principal point scatters by .09 and .18 px with these and is .07 and .14 off; with independent residuals it scatters
# by .03 and .05.
_SQUARES = (3, 9, 27)
# Similarities of space move all cameras and points at no cost: this many combinations of unknowns are left as they are.
_FREE = 7
# Observations that determine a point use up this many coordinates of them.
_USED_UP = 3


def resampled(
    cameras: Sequence[Camera], points: Array, observed: Array, place: Array, times: int, random: np.random.Generator
) -> Iterator[tuple[Array, tuple[Camera, ...]]]:
    """Points (N, 3) and cameras after other errors, ``times`` over.

    Parameters
    ----------
    cameras : sequence of Camera
    points : (N, 3) array
        As triangulated.
    observed : (N, C, 2) array
        Distorted pixels; NaN where a photo does not show a point.
    place : (N, 2) array
        Where the points lie on the paper, any unit.
    times : int
    random : Generator
    """
    seen = np.isfinite(observed[..., 0])
    off, by_camera, by_point = linearized(cameras, points, observed)
    off[~seen] = 0
    length = np.linalg.norm(off, axis=2)
    deviation = scatter(length[seen])
    equations = Equations.of(by_camera, by_point, seen * observation_weight(length, deviation))
    expected = expected_lens(deviation)
    system = equations.system.copy()
    system[range(LENS), range(LENS)] += expected
    inverse = _without_similarities(system)
    coordinates = 2 * seen.sum(axis=1)
    lost = np.sqrt(coordinates / np.maximum(coordinates - _USED_UP, 1))
    parts = list(_parts(off * lost[:, None, None], seen, place))
    for _ in range(times):
        noise = np.zeros_like(off)
        for mean, square in parts:
            noise += (mean * random.standard_normal((*mean.shape[:2], 1)))[square]
        noise[~seen] = 0
        of_points, right = equations.right(noise)
        right[:LENS] += expected * LENS_CHANGE * random.standard_normal(LENS)
        step = -inverse @ right
        poses = step[LENS:].reshape(-1, POSE)
        there = tuple(moved(camera, step[:LENS], pose) for camera, pose in zip(cameras, poses, strict=True))
        yield points + equations.of_points(of_points, step), there


def _without_similarities(system: Array) -> Array:
    """The inverse of the cameras' system on what it determines."""
    unit = np.sqrt(np.diagonal(system))
    value, vector = np.linalg.eigh(system / np.outer(unit, unit))
    value, vector = value[_FREE:], vector[:, _FREE:]
    return np.asarray((vector / value) @ vector.T / np.outer(unit, unit))


def _parts(off: Array, seen: NDArray[np.bool_], place: Array) -> Iterator[tuple[Array, NDArray[np.int64]]]:
    """Means (S, C, 2) over squares of the page, with the square of each point (N,); at last the points' own rests."""
    low = place.min(axis=0)
    share = (place - low) / (np.ptp(place, axis=0).max() * (1 + 1e-9) + 1e-300)
    rest = off.copy()
    for squares in _SQUARES:
        column, row = np.floor(squares * share).astype(np.int64).T
        square = np.unique(column * squares + row, return_inverse=True)[1].ravel()
        count = square.max() + 1
        mean = np.stack([[np.bincount(square, part, count) for part in photo.T] for photo in rest.transpose(1, 0, 2)])
        shown = np.stack([np.bincount(square, one, count) for one in seen.T.astype(float)])
        mean = (mean / np.maximum(shown, 1)[:, None]).transpose(2, 0, 1)
        rest -= mean[square] * seen[..., None]
        yield mean, square
    yield rest, np.arange(len(rest))
