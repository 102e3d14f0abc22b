"""The flat map that changes lengths least and never folds over, by reweighted least squares.

After M. Rabinovich et al., "Scalable Locally Injective Mappings", 2017. A triangle with the singular values s, t has
the symmetric Dirichlet energy s^2 + t^2 + 1/s^2 + 1/t^2: 4 where lengths are kept, and infinite where it would
collapse. So a map that starts without flips stays so. Here the energy's square counts too, or few triangles would bear
what all others save.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..arrays import Array, Indices
from ..numeric.triangles import areas, gradient_rows, signed_areas
from ..sheet import Sheet
from ..watch import SILENT, Watch
from .pins import HeldSystem, Pins

_ITERATIONS = 100
# It ends once an iteration lowers the energy by less than this share.
_TOLERANCE = 1e-7
# Of the step to the place where a triangle would collapse, at most.
_SHARE_OF_STEP = 0.8
# The step is halved until the energy falls; after so many times it does not.
_HALVINGS = 30
# Share of the mean diagonal that holds each vertex near its place, because a map may turn and move freely.
_HOLD = 1e-6
# Weight of the square of a triangle's energy above 4. From 0 to 100, the worst stretch falls from 13.5 to 11.3 % on a
# rumpled cloth, from 12.0 to 10.4 % on half a ball and from 15 to 11 times on Blender's monkey, the mean rises by a
# tenth; Blender's own methods leave at least 13.7 %, 10.7 % and 16 times.
_SQUARE = 100.0
_EXACT = 1e-12  # an energy of a map that keeps all lengths
_NEAR_ONE = 1e-6  # singular values so near to 1 have the weight of their limit


def least_stretch(
    sheet: Sheet, start: Array, straight: sparse.csr_array, watch: Watch = SILENT, *, pins: Pins | None = None
) -> Array:
    """Minimise the energy of all triangles, weighted by area, from a map without flips.

    Parameters
    ----------
    sheet : Sheet
        Of about unit area.
    start : (V, 2) array
        u right, v up, without flips.
    straight : (R, 2 V) sparse array
        Rows whose squares are added to the energy; unknowns are all u, then all v.
    watch : Watch
    pins : Pins, optional
        Vertices that stay where they are in ``start``.

    Returns
    -------
    flat : (V, 2) array
        Without flips.
    """
    share = areas(sheet.vertices, sheet.triangles)
    share = share / share.sum()
    gradient = gradient_rows(sheet.vertices, sheet.triangles)
    held = np.zeros(0, np.int64) if pins is None else np.concatenate([pins.vertices, pins.vertices + len(start)])
    flat = start.astype(float)
    energy = _energy(gradient, share, straight, flat)
    for iteration in range(_ITERATIONS):
        watch.step(iteration / _ITERATIONS, "Flattening")
        step = _step(gradient, share, straight, flat, held)
        length = min(1.0, _SHARE_OF_STEP * _collapse(flat, step, sheet.triangles))
        for _ in range(_HALVINGS):
            update = flat + length * step
            after = _energy(gradient, share, straight, update)
            if after < energy:
                break
            length /= 2
        else:
            return flat
        gain = (energy - after) / max(energy, _EXACT)
        flat, energy = update, after
        if gain < _TOLERANCE:
            break
    return flat


def _jacobian(gradient: tuple[sparse.csr_array, sparse.csr_array], flat: Array) -> Array:
    """The map of each triangle, (F, 2, 2): rows u and v, columns its own axes."""
    return np.stack([rows @ flat for rows in gradient], axis=-1)


def _energy(
    gradient: tuple[sparse.csr_array, sparse.csr_array], share: Array, straight: sparse.csr_array, flat: Array
) -> float:
    jacobian = _jacobian(gradient, flat)
    determinant = jacobian[:, 0, 0] * jacobian[:, 1, 1] - jacobian[:, 0, 1] * jacobian[:, 1, 0]
    if not (determinant > 0).all():
        return np.inf
    square = (jacobian**2).sum(axis=(1, 2))
    wave = straight @ flat.T.ravel()
    excess = square * (1 + 1 / determinant**2) - 4
    return float(share @ (excess + _SQUARE * excess**2) + wave @ wave)


def _step(
    gradient: tuple[sparse.csr_array, sparse.csr_array],
    share: Array,
    straight: sparse.csr_array,
    flat: Array,
    held: Indices,
) -> Array:
    """From the map to the minimum of a quadratic energy that agrees with the true one there."""
    jacobian = _jacobian(gradient, flat)
    left, singular, right = np.linalg.svd(jacobian)
    away = singular - 1
    flat_there = np.abs(away) < _NEAR_ONE
    weight = np.where(flat_there, 4.0, (singular - singular**-3) / np.where(flat_there, 1.0, away))
    excess = (singular**2 + singular**-2).sum(axis=1) - 4
    weight = np.sqrt(weight * (1 + 2 * _SQUARE * excess)[:, None])
    weights = (left * weight[:, None, :]) @ left.transpose(0, 2, 1) * np.sqrt(share)[:, None, None]
    target = weights @ (left @ right)
    rows = sparse.vstack(
        [
            sparse.hstack([_scaled(weights[:, row, 0], along), _scaled(weights[:, row, 1], along)])
            for row in (0, 1)
            for along in gradient
        ],
        format="csr",
    )
    right_side = np.concatenate([target[:, row, column] for row in (0, 1) for column in (0, 1)])
    matrix = (rows.T @ rows + straight.T @ straight).tocsr()
    hold = _HOLD * matrix.diagonal().mean()
    now = flat.T.ravel()
    system = HeldSystem(matrix + hold * sparse.eye_array(len(now)), held)
    return (system.solve(rows.T @ right_side + hold * now, now[held]) - now).reshape(2, -1).T


def _scaled(factor: Array, rows: sparse.csr_array) -> sparse.csr_array:
    return rows.multiply(factor[:, None]).tocsr()


def _collapse(flat: Array, step: Array, triangles: Indices) -> float:
    """How many steps it takes until a triangle has no area any more; infinite if none does."""
    corners, moves = flat[triangles], step[triangles]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    to_first, to_second = moves[:, 1] - moves[:, 0], moves[:, 2] - moves[:, 0]
    constant = _cross(first, second)
    linear = _cross(first, to_second) + _cross(to_first, second)
    square = _cross(to_first, to_second)
    discriminant = linear**2 - 4 * square * constant
    with np.errstate(divide="ignore", invalid="ignore"):
        # Both roots in the form without cancellation.
        half = -(linear + np.copysign(np.sqrt(np.maximum(discriminant, 0)), linear)) / 2
        roots = np.stack([half / square, constant / half])
    roots[:, discriminant < 0] = np.inf
    roots[~(roots > 0)] = np.inf
    return float(roots.min(initial=np.inf))


def _cross(one: Array, other: Array) -> Array:
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])


def has_flips(flat: Array, triangles: Indices) -> bool:
    """Whether any triangle of a map with v up is turned over or has no area."""
    return not bool((signed_areas(flat, triangles) > 0).all())
