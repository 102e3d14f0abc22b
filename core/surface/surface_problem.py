"""The least-squares problem of a sheet's surface: what the points, the prior and the creases ask of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ..arrays import Array
from ..errors import StepFailed
from ..numeric.robust import Loss
from .depth_grid import DepthGrid, SecondDifferences, ViewFrame
from .edge_points import EdgePoints
from .hinges import Hinges
from .noise import point_noise
from .surface_settings import SurfaceSettings

# Values without a figure are choices; no measurement of them is recorded.
# Smoothness that suits 1200 points with noise of 0.2 % of the page length, on grids of 50 to 140 rows alike (six kinds
# of synthetic sheets); that it scales with noise / sqrt(points) is an assumption, which the stiffness then corrects.
_BASE_SMOOTHNESS = 3e-5
_BASE_NOISE = 2e-3
_BASE_POINTS = 1200
# Scales at which the l1 loss becomes quadratic and Cauchy's turns over, in noise levels. On a synthetic sheet with two
# creases and 15 % wrong points, l1 from .25 to .5 and then Cauchy at 2 left a tenth less error within the page, and a
# quarter less on all of it, than l1 alone.
_L1_SCALE = 0.25
_CAUCHY_SCALE = 2.0
# Four times the minimum for a plane: 24 points of a flat sheet on a clipboard give a page whose squares are square.
MINIMUM_POINTS = 12
# Accuracy of a hand-drawn end of a crease, as a share of the page length.
_HAND = 2e-3
# Cost of a hinge's turn, as a share of its cost without a hinge: it determines hinges where there are no points.
_HINGE_STIFFNESS = 1e-5
# The place of a hinge that hardly turns is determined as if it turned by this.
_LEAST_TURN = 0.05


@dataclass(frozen=True)
class SurfaceProblem:
    """One sheet's least-squares problem: data rows, noise, smoothness weight and finite differences.

    Attributes
    ----------
    grid : DepthGrid
    plane : (M, 2) array
        The points over the grid, plane coordinates.
    rows : (M, unknowns) sparse array
    target : (M,) array
        Their scaled inverse depths.
    noise : float
        Their standard deviation.
    smoothness : float
        Weight of the prior against the points.
    differences : SecondDifferences
    settings : SurfaceSettings
    """

    grid: DepthGrid
    plane: Array
    rows: sparse.csr_array
    target: Array
    noise: float
    smoothness: float
    differences: SecondDifferences
    settings: SurfaceSettings

    @classmethod
    def of(cls, points: Array, frame: ViewFrame, grid: DepthGrid, settings: SurfaceSettings) -> SurfaceProblem:
        plane, inverse_depth = frame.from_world(points)
        rows, inside = grid.sampling_rows(plane)
        if inside.sum() < MINIMUM_POINTS:
            raise StepFailed("Too few of the points are inside the outline; check the outline.")
        noise = point_noise(plane[inside], inverse_depth[inside])
        count = int(inside.sum())
        # E = mean |r| + mu sum h^2 |H|^2, which keeps its optimum over all grid steps; here times the count.
        mu = _BASE_SMOOTHNESS * (noise / _BASE_NOISE) * np.sqrt(_BASE_POINTS / count)
        smoothness = settings.smoothness * mu * count / grid.step**2
        differences = grid.second_differences()
        return cls(grid, plane[inside], rows, inverse_depth[inside], noise, smoothness, differences, settings)

    def with_hinges(self, hinges: Hinges) -> SurfaceProblem:
        """The same problem with other hinges."""
        grid = replace(self.grid, hinges=hinges)
        rows, _ = grid.sampling_rows(self.plane)
        return replace(self, grid=grid, rows=rows, differences=grid.second_differences())

    def with_edge(self, edge: EdgePoints) -> SurfaceProblem:
        """The same problem with points of the paper's edge, which count by their deviation."""
        rows, inside = self.grid.sampling_rows(edge.plane)
        weight = self.noise / np.maximum(edge.deviation[inside], self.noise)
        return replace(
            self,
            plane=np.concatenate([self.plane, edge.plane[inside]]),
            rows=sparse.vstack([self.rows, rows.multiply(weight[:, None])]).tocsr(),
            target=np.concatenate([self.target, weight * edge.inverse_depth[inside]]),
        )

    def without(self, left_out: NDArray[np.bool_]) -> SurfaceProblem:
        """The same problem, the prior's weight included, without some of the points (M,)."""
        keep = ~left_out
        return replace(self, plane=self.plane[keep], rows=self.rows[keep], target=self.target[keep])

    def l1(self) -> Loss:
        return Loss("l1", _L1_SCALE * self.noise)

    def cauchy(self) -> Loss:
        return Loss("cauchy", _CAUCHY_SCALE * self.noise)

    def settled(self, smoothness: sparse.csr_array) -> sparse.csr_array:
        """The smoothness, plus a term that keeps turns of hinges small if no points determine them."""
        hinges = self.grid.hinges
        if not len(hinges):
            return smoothness
        diagonal = np.zeros(self.grid.unknowns)
        turns = slice(self.grid.size, self.grid.size + len(hinges))
        diagonal[turns] = _HINGE_STIFFNESS * self.smoothness * self.grid.step * hinges.lengths
        return (smoothness + sparse.diags_array(diagonal)).tocsr()

    def hand(self, drawn: Hinges, turn: Array) -> tuple[sparse.csr_array, Array]:
        """Quadratic and linear term of the lifts: hinges are within a hand's error of where they were ``drawn``."""
        size = np.maximum(np.abs(turn), _LEAST_TURN)
        # The loss of the points is this multiple of their negative log-likelihood.
        share = self.noise / _CAUCHY_SCALE
        weight = np.tile(share / (2 * (_HAND * size) ** 2), 2)
        before = np.zeros(self.grid.size + len(turn))
        linear = -weight * (turn * self.grid.hinges.displacement(drawn)).ravel()
        return sparse.diags_array(np.concatenate([before, weight])).tocsr(), np.concatenate([before, linear])
