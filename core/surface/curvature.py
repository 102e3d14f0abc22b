"""The Hessian of the inverse depth, its eigenvectors, and the ridge candidates (Eq. 10-11)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..numeric.image import gaussian_mean
from .depth_grid import DepthGrid

# Width in nodes of the Gaussian that smooths the Hessian before its eigenvectors are computed. A choice.
_SMOOTHING_NODES = 0.7
# Nodes within this many grid steps of a hinge have their rulings along it.
_BESIDE_HINGE = 4.5


@dataclass(frozen=True)
class PrincipalCurvature:
    """Principal curvatures at the nodes that have all eight neighbours.

    Attributes
    ----------
    nodes : (K,) int array
    along, across : (K,) arrays
        kappa_1 and kappa_2, 1 / page length, with ``|along| <= |across|``.
    direction : (K, 2) array
        p_1, the unit eigenvector of ``along``: on a developable surface, the ruling.
    """

    nodes: NDArray[np.int64]
    along: Array
    across: Array
    direction: Array


def principal_curvature(grid: DepthGrid, inverse_depth: Array) -> PrincipalCurvature:
    """Principal curvatures of the inverse depth over the grid (Eq. 10-11)."""
    xx, xy, yy, nodes = grid.hessian_rows()
    known = np.zeros(grid.size, bool)
    known[nodes] = True
    inside = grid.to_image(known.astype(float)) == 1
    hxx, hxy, hyy = (_smooth(grid, rows @ inverse_depth, nodes, inside) for rows in (xx, xy, yy))
    mean, half, twist = (hxx + hyy) / 2, (hxx - hyy) / 2, hxy
    radius = np.hypot(half, twist)
    across = np.where(mean >= 0, mean + radius, mean - radius)
    along = 2 * mean - across
    angle = np.arctan2(twist, half) / 2
    # `angle` belongs to the algebraically larger eigenvalue; the ruling is the other one where that is `across`.
    angle = np.where(mean >= 0, angle + np.pi / 2, angle)
    return PrincipalCurvature(nodes, along, across, np.stack([np.cos(angle), np.sin(angle)], axis=1))


def ruled_along_hinges(grid: DepthGrid, curvature: PrincipalCurvature) -> PrincipalCurvature:
    """The curvature with the rulings beside the grid's hinges turned along them, and no crease beside them.

    A straight crease is a ruling of the paper on both sides. The points do not determine the rulings of a hardly bent
    surface, such as paper between creases.
    """
    if not len(grid.hinges):
        return curvature
    nearest, distance = grid.hinges.nearest(grid.node_positions()[curvature.nodes])
    beside = distance < _BESIDE_HINGE * grid.step
    direction = np.where(beside[:, None], grid.hinges.directions[nearest], curvature.direction)
    return replace(curvature, direction=direction, across=np.where(beside, 0.0, curvature.across))


def _smooth(grid: DepthGrid, values: Array, nodes: NDArray[np.int64], inside: NDArray[np.bool_]) -> Array:
    """Gaussian smoothing over only the nodes that have a value."""
    everywhere = np.zeros(grid.size)
    everywhere[nodes] = values
    return gaussian_mean(grid.to_image(everywhere), inside, _SMOOTHING_NODES, mode="constant")[0][inside]


def ridge_candidates(curvature: PrincipalCurvature, threshold: float) -> NDArray[np.bool_]:
    """Nodes (K,) whose larger curvature exceeds kappa_th, in 1 / page length."""
    return np.abs(curvature.across) > threshold
