"""A contour smoothed without losing its corners, and how ragged it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..numeric.local_fit import local_fits
from ..numeric.polygon import resample

# Values without a figure are choices; no measurement of them is recorded.
# The misfit of the parabola about a point counts this much: if leaving it were free, noise alone would choose another.
_PREFER_CENTRE = 0.7
# Parabolas: a point counts less beyond this distance, all points beyond the second distance alike, and this is added to
# the mean square, so that hardly different misfits do not decide. Distances in pixels (in `raggedness`, places). Found
# in this many rounds of reweighting, with this on the diagonal of the normal equations, because points of no weight
# determine no parabola.
_FIT_SCALE, _FIT_LIMIT, _FIT_FLOOR = 0.7, 6.0, 0.01
_FIT_ROUNDS, _FIT_RIDGE = 3, 1e-9
# Two lines make a corner if they turn by this (sine of the angle) and cross within this many gaps between their points.
_LEAST_TURN, _NEAR_CORNER = 0.1, 2.0
# Raggedness is measured at this many places along an outline, by parabolas through this many of them each: about a
# fiftieth of the outline, far shorter than a side.
_PLACES = 1000
_STRETCH = 18
_STRETCHES = (-_STRETCH, -_STRETCH // 2, 0)


def smooth_sides(points: Array, weights: Array, window: int) -> Array:
    """Smooth an evenly spaced contour and keep its corners and kinks.

    Three robust, weighted parabolas are fitted at each point: to the ``window`` points before, after and around it. The
    one that fits best is taken, so no parabola spans a corner. Where that changes from the points before to the points
    after, and the two parabolas meet at an angle, the corner is where they cross.

    Parameters
    ----------
    points : (M, 2) array
        Pixels.
    weights : (M,) array
        Trust in each point, at least 0.

    Returns
    -------
    (K, 2) array
        The smoothed contour with its corners inserted.
    """
    count = len(points)
    before, centre, after = (
        _parabolas(points, weights, np.arange(first, first + window + 1)) for first in (-window, -window // 2, 0)
    )
    misfit = np.stack([before.misfit, _PREFER_CENTRE * centre.misfit, after.misfit])
    choice = misfit.argmin(axis=0)
    positions = np.stack([before.position, centre.position, after.position])
    tangents = np.stack([before.tangent, centre.tangent, after.tangent])
    every = np.arange(count)
    smooth, tangent = positions[choice, every], tangents[choice, every]
    result: list[Array] = []
    for index in range(count):
        following = (index + 1) % count
        result.append(smooth[index])
        if choice[index] == 0 and choice[following] == 2:
            corner = _crossing(smooth[index], tangent[index], smooth[following], tangent[following])
            if corner is not None:
                result.append(corner)
    return np.array(result)


def raggedness(points: Array) -> Array:
    """How far each part of a closed contour strays from a smooth line or a corner of two.

    Parameters
    ----------
    points : (M, 2) array
        Clockwise.

    Returns
    -------
    (N,) array
        At places evenly spaced along the contour: root mean square distance from the parabola that fits best before,
        around or after the place, as a part of that parabola's length.
    """
    closed = np.vstack([points, points[:1]])
    spacing = float(np.linalg.norm(np.diff(closed, axis=0), axis=1).sum()) / _PLACES
    places = resample(points, spacing)
    if len(places) <= _STRETCH:
        return np.zeros(len(places))
    trust = np.ones(len(places))
    fits = (_parabolas(places / spacing, trust, np.arange(at, at + _STRETCH + 1)) for at in _STRETCHES)
    return np.sqrt(np.min([fit.misfit for fit in fits], axis=0)) / _STRETCH


@dataclass(frozen=True)
class _Parabolas:
    position: Array
    tangent: Array
    misfit: Array


def _parabolas(points: Array, weights: Array, offsets: NDArray[np.int64]) -> _Parabolas:
    """Position, tangent and weighted mean square misfit at each point of the parabola through its neighbours."""
    index = (np.arange(len(points))[:, None] + offsets) % len(points)
    near = points[index] - points[:, None]
    t = offsets / np.abs(offsets).max()
    basis = np.stack([np.ones_like(t), t, t**2], axis=1)
    trust = weights[index]
    coefficients, residual = local_fits(
        basis,
        near,
        trust,
        lambda residual: trust / np.maximum(residual, _FIT_SCALE),
        rounds=_FIT_ROUNDS,
        ridge=_FIT_RIDGE,
    )
    misfit = (trust * np.minimum(residual, _FIT_LIMIT) ** 2).sum(axis=1) / np.maximum(trust.sum(axis=1), 1e-9)
    length = np.linalg.norm(coefficients[:, 1], axis=1, keepdims=True)
    tangent = coefficients[:, 1] / np.maximum(length, 1e-12)
    return _Parabolas(points + coefficients[:, 0], tangent, misfit + _FIT_FLOOR)


def _crossing(first: Array, direction: Array, second: Array, other: Array) -> Array | None:
    """Where two lines cross, if they meet at an angle and the crossing lies between and near the two points."""
    turn = direction[0] * other[1] - direction[1] * other[0]
    gap = second - first
    if abs(turn) < _LEAST_TURN:
        return None
    along = (gap[0] * other[1] - gap[1] * other[0]) / turn
    back = (gap[0] * direction[1] - gap[1] * direction[0]) / turn
    near = _NEAR_CORNER * float(np.linalg.norm(gap))
    if not (-near <= along <= near and -near <= -back <= near):
        return None
    return np.asarray(first + along * direction)
