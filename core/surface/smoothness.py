"""Smoothness terms, as quadratic forms of the inverse depths at the nodes of a grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ..arrays import Array
from .curvature import PrincipalCurvature
from .depth_grid import DepthGrid, SecondDifferences

# phi(0) = 0 leaves a node without any smoothness across its ridge; this floor keeps the equations regular.
_PHI_FLOOR = 1e-2
# The developable prior: stiffness along rulings, and the curvature across them (1 / page length) above which bending
# counts as a crease and only costs its logarithm. On six kinds of synthetic sheets (1200 points, noise of .2 % of the
# page, a tenth of them wrong) a prototype's surfaces were .066 % of the page off with these, .067 with a stiffness of
# 10 and three times the smoothness, and .116 with the published method.
_RULING_STIFFNESS = 100.0
_CREASE_CURVATURE = 2.0
# Isotropic share that supports the nodes at the rim, which have no complete Hessian.
_RIM_SHARE = 0.01


def isotropic_smoothness(differences: SecondDifferences) -> sparse.csr_array:
    """Squared Frobenius norm of the undivided Hessian as (unknowns, unknowns); Eq. 4 with the mixed term it lacks."""
    terms = ((differences.xx.rows, 1.0), (differences.yy.rows, 1.0), (differences.xy.rows, 2.0))
    return sum(weight * (rows.T @ rows) for rows, weight in terms)


def ridge_smoothness(
    size: int,
    differences: SecondDifferences,
    nodes: NDArray[np.int64],
    direction: Array,
    emphasis: float,
) -> sparse.csr_array:
    """The ridge-aware smoothness of Eq. 12 as a quadratic form.

    Ridge candidates carry second differences along x, y and both diagonals, each weighted by
    ``phi = (beta**(c**2) - 1) / (beta - 1)`` with ``c`` the cosine between ridge and difference: full smoothness
    along the ridge and (except for a floor) none across it. All other nodes keep the isotropic smoothness.

    Parameters
    ----------
    size : int
        Number of nodes.
    differences : SecondDifferences
    nodes : (K,) int array
        The ridge candidates.
    direction : (K, 2) array
        Unit vectors along the ridge.
    emphasis : float
        beta.
    """
    is_ridge = np.zeros(size, bool)
    is_ridge[nodes] = True
    along = np.zeros((size, 2))
    along[nodes] = direction
    half = np.sqrt(0.5)
    slanted = (
        (differences.xx, np.array([1.0, 0.0])),
        (differences.yy, np.array([0.0, 1.0])),
        (differences.falling, np.array([half, half])),
        (differences.rising, np.array([-half, half])),
    )
    unknowns = differences.xx.rows.shape[1]
    total = sparse.csr_array((unknowns, unknowns))
    for number, (stencil, unit) in enumerate(slanted):
        cosine = along[stencil.nodes] @ unit
        phi = np.maximum((emphasis ** (cosine**2) - 1) / (emphasis - 1), _PHI_FLOOR)
        plain = 1.0 if number < 2 else 0.0
        weight: Array = np.square(np.where(is_ridge[stencil.nodes], phi, plain))
        total = total + _weighted_square(stencil.rows, weight)
    mixed = differences.xy
    return total + 2.0 * _weighted_square(mixed.rows, (~is_ridge[mixed.nodes]).astype(float))


def developable_smoothness(grid: DepthGrid, curvature: PrincipalCurvature) -> sparse.csr_array:
    """Stiff along the rulings of the current surface, free to bend across them, in undivided differences.

    The energy of a node is ``L (along^2 + 2 twist^2) + c^2 log(1 + (across / c)^2)`` in the frame of the Hessian's
    eigenvectors; this is its quadratic majoriser at the current curvature. It is a smooth prior for the Hessians of
    rank one that developable surfaces have, and blurs a crease less than a quadratic term does.

    Parameters
    ----------
    grid : DepthGrid
    curvature : PrincipalCurvature
        Of the current surface over this grid.

    Returns
    -------
    (unknowns, unknowns) sparse array
    """
    xx, xy, yy, _ = grid.hessian_rows()
    cosine, sine = curvature.direction.T
    along = _combine(xx, xy, yy, cosine**2, 2 * cosine * sine, sine**2)
    twist = _combine(xx, xy, yy, -cosine * sine, cosine**2 - sine**2, cosine * sine)
    across = _combine(xx, xy, yy, sine**2, -2 * cosine * sine, cosine**2)
    freedom = 1 / (1 + (curvature.across / _CREASE_CURVATURE) ** 2)
    prior = _RULING_STIFFNESS * (along.T @ along + 2.0 * (twist.T @ twist)) + _weighted_square(across, freedom)
    return (grid.step**4 * prior + _RIM_SHARE * isotropic_smoothness(grid.second_differences())).tocsr()


def _weighted_square(rows: sparse.csr_array, weight: Array) -> sparse.csr_array:
    return (rows.T @ rows.multiply(weight[:, None])).tocsr()


def _combine(
    xx: sparse.csr_array, xy: sparse.csr_array, yy: sparse.csr_array, a: Array, b: Array, c: Array
) -> sparse.csr_array:
    return (xx.multiply(a[:, None]) + xy.multiply(b[:, None]) + yy.multiply(c[:, None])).tocsr()
