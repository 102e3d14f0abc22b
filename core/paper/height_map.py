"""Fit a smooth surface to scattered heights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..arrays import Array
from ..numeric.image import sample_bilinear
from ..numeric.robust import solve_symmetric

# The values below are choices; no measurement of them is recorded.
# Weight of bending, for heights and nodes in the same unit, beside a weight of 1 for all samples of a square together.
_BENDING = 0.03
# Cells off the surface beyond which a sample counts less, and rounds of reweighting.
_TOLERANCE = 1.35
_ROUNDS = 6
# The surface is limited to the heights of all but this part of the samples at either end, and half as much beyond.
_STRAY, _BEYOND = 0.005, 0.5


@dataclass(frozen=True)
class Stiffness:
    """How a surface continues where there are no samples.

    Attributes
    ----------
    nodes : int
        Along the map's longer side.
    tension : float
        Weight of its slopes: keeps it level, as bending keeps it straight.
    pull : float
        Weight of its heights: draws it to height 0.
    """

    nodes: int
    tension: float
    pull: float

    def energy(self) -> sparse.spmatrix:
        """The quadratic form of the heights of all nodes, row by row."""
        one = sparse.identity(self.nodes)
        bend = sparse.diags([1.0, -2.0, 1.0], [0, 1, 2], shape=(self.nodes - 2, self.nodes))
        step = sparse.diags([-1.0, 1.0], [0, 1], shape=(self.nodes - 1, self.nodes))
        bending = sparse.vstack([sparse.kron(one, bend), sparse.kron(bend, one), np.sqrt(2) * sparse.kron(step, step)])
        slope = sparse.vstack([sparse.kron(one, step), sparse.kron(step, one)])
        return (
            _BENDING * bending.T @ bending + self.tension * slope.T @ slope + self.pull * sparse.identity(self.nodes**2)
        )


def height_map(samples: Array, corner: Array, cell: float, shape: tuple[int, int], stiffness: Stiffness) -> Array:
    """Fit a smooth surface to samples, robustly.

    Parameters
    ----------
    samples : (N, 3) array
        Right, down and height, world units.
    corner : (2,) array
        Right and down of the map's first corner.
    cell : float
        Side of a cell, world units.
    shape : (int, int)
        Rows and columns of the map.
    stiffness : Stiffness

    Returns
    -------
    (h, w) array
        Height of each cell's centre, world units; 0 everywhere if no sample is on the map.
    """
    nodes = stiffness.nodes
    spacing = max(shape) * cell / (nodes - 1)
    at = (samples[:, :2] - corner) / spacing
    near = ((at > 0) & (at < nodes - 1)).all(axis=1)
    at, height = at[near], samples[near, 2]
    if not len(at):
        return np.zeros(shape)
    index = np.arange(nodes**2).reshape(nodes, nodes)
    column, row = np.floor(at).astype(np.int64).T
    x, y = (at - np.floor(at)).T
    corners = [(row, column, (1 - x) * (1 - y)), (row, column + 1, x * (1 - y))]
    corners += [(row + 1, column, (1 - x) * y), (row + 1, column + 1, x * y)]
    places = np.tile(np.arange(len(at)), 4), np.concatenate([index[r, c] for r, c, _ in corners])
    sampling = sparse.csr_matrix((np.concatenate([share for _, _, share in corners]), places), (len(at), index.size))
    held = stiffness.energy()
    # all samples of a square count as one: otherwise dense print would outweigh sparse margins
    crowd = np.bincount(index[row, column], minlength=index.size)[index[row, column]]
    trust = 1 / crowd
    found = np.zeros(index.size)
    for _ in range(_ROUNDS):
        weighted = sparse.diags(trust) @ sampling
        found = solve_symmetric((sampling.T @ weighted + held).tocsc(), weighted.T @ height)
        off = np.abs(height - sampling @ found)
        trust = 1 / crowd / np.maximum(off / (_TOLERANCE * cell), 1)
    lowest, highest = np.quantile(height, [_STRAY, 1 - _STRAY])
    margin = _BEYOND * (highest - lowest)
    grid = np.clip(found, lowest - margin, highest + margin).reshape(nodes, nodes)
    down, across = ((np.arange(length) + 0.5) * cell / spacing + 0.5 for length in shape)
    return sample_bilinear(grid[..., None], np.stack(np.meshgrid(across, down), axis=-1))[..., 0].astype(np.float64)
