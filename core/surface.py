"""From points to a depth grid: the paper's section 3.1 (Eq. 1-9, 12) and the developable prior that succeeds it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import sparse

from .camera import Array, Camera
from .curvature import PrincipalCurvature, principal_curvature, ridge_candidates
from .depth_grid import DepthGrid, SecondDifferences, ViewFrame, frame_for, grid_over
from .errors import StepFailed
from .noise import point_noise
from .robust import Loss, minimize
from .smoothness import developable_smoothness, isotropic_smoothness, ridge_smoothness
from .watch import SILENT, Watch

SurfaceMethod = Literal["developable", "ridge_aware", "poisson", "poisson_l2"]

# Smoothness that suits 1200 points with noise of 0.2 % of the page length; it scales with noise / sqrt(points).
_BASE_SMOOTHNESS = 3e-5
_BASE_NOISE = 2e-3
_BASE_POINTS = 1200
# The developable prior needs this share of it: most of its stiffness lies along the rulings.
_DEVELOPABLE_SHARE = 1 / 30
# Where the l1 loss turns quadratic and where Cauchy's turns over, in noise levels.
_L1_SCALE = 0.25
_CAUCHY_SCALE = 2.0
_MINIMUM_POINTS = 30


@dataclass(frozen=True)
class SurfaceSettings:
    """How the surface is reconstructed.

    Attributes
    ----------
    method : {"developable", "ridge_aware", "poisson", "poisson_l2"}
        ``poisson_l2``: plain Poisson; ``poisson``: with the l1 data term (Eq. 6); ``ridge_aware``: the paper's second
        solve (Eq. 12); ``developable``: smooth along the rulings, free to bend across them.
    grid_rows : int
        Nodes along the page's long side.
    smoothness : float
        Factor on the smoothness that follows from noise and number of points.
    ridge_curvature : float
        kappa_th of the ridge candidates, 1 / page length.
    ridge_emphasis : float
        beta of Eq. 12.
    """

    method: SurfaceMethod = "developable"
    grid_rows: int = 85
    smoothness: float = 1.0
    ridge_curvature: float = 4.0
    ridge_emphasis: float = 10.0


@dataclass(frozen=True)
class Surface:
    """The sheet's surface over the reference view.

    Attributes
    ----------
    grid : DepthGrid
    inverse_depth : (size,) array
        Scaled inverse depth at the nodes in use.
    curvature : PrincipalCurvature
    noise : float
        Standard deviation of the points along the ray, page lengths.
    residuals : (M,) array
        Point minus surface, page lengths, for the points over the grid.
    """

    grid: DepthGrid
    inverse_depth: Array
    curvature: PrincipalCurvature
    noise: float
    residuals: Array

    def at(self, plane: Array) -> Array:
        """World points (N, 3) of the surface at plane coordinates (N, 2), which must lie over the grid."""
        return self.grid.frame.to_world(plane, self.grid.interpolate(self.inverse_depth, plane))


def reconstruct(
    points: Array,
    reference: Camera,
    polygon: Array,
    settings: SurfaceSettings | None = None,
    watch: Watch = SILENT,
) -> Surface:
    """Fit a surface to the points on the sheet.

    Parameters
    ----------
    points : (N, 3) array
        Points on the sheet, world frame; outliers are allowed.
    reference : Camera
        A view in which the sheet hides no part of itself.
    polygon : (K, 2) array
        The paper's outline in the reference view, distorted pixels.
    settings : SurfaceSettings, optional
    watch : Watch

    Raises
    ------
    StepFailed
        If there are too few points.
    """
    settings = settings or SurfaceSettings()
    if len(points) < _MINIMUM_POINTS:
        raise StepFailed(
            f"Only {len(points)} points were found on the sheet; {_MINIMUM_POINTS} are needed. "
            "Take sharper photos from nearer, or of a sheet with more print."
        )
    frame = frame_for(points, reference, polygon)
    grid = grid_over(frame, frame.from_pixels(polygon), settings.grid_rows)
    problem = _Problem.of(points, frame, grid, settings)
    inverse_depth = _SOLVERS[settings.method](problem, watch)
    residuals = problem.target - problem.rows @ inverse_depth
    return Surface(grid, inverse_depth, principal_curvature(grid, inverse_depth), problem.noise, residuals)


@dataclass(frozen=True)
class _Problem:
    """One sheet's least-squares problem: data rows, noise, smoothness weight and finite differences."""

    grid: DepthGrid
    rows: sparse.csr_array
    target: Array
    noise: float
    smoothness: float
    differences: SecondDifferences
    settings: SurfaceSettings

    @classmethod
    def of(cls, points: Array, frame: ViewFrame, grid: DepthGrid, settings: SurfaceSettings) -> _Problem:
        plane, inverse_depth = frame.from_world(points)
        rows, inside = grid.sampling_rows(plane)
        if inside.sum() < _MINIMUM_POINTS:
            raise StepFailed("Too few of the points lie within the outline; check the outline.")
        noise = point_noise(plane[inside], inverse_depth[inside])
        count = int(inside.sum())
        # E = mean |r| + mu sum h^2 |H|^2, which keeps its optimum over all grid steps; here times the count.
        mu = _BASE_SMOOTHNESS * (noise / _BASE_NOISE) * np.sqrt(_BASE_POINTS / count)
        smoothness = settings.smoothness * mu * count / grid.step**2
        return cls(grid, rows, inverse_depth[inside], noise, smoothness, grid.second_differences(), settings)

    def l1(self) -> Loss:
        return Loss("l1", _L1_SCALE * self.noise)


def _poisson_l2(problem: _Problem, watch: Watch) -> Array:
    loss = Loss("squared", problem.noise)
    return minimize(
        problem.rows, problem.target, loss, problem.smoothness * isotropic_smoothness(problem.differences), watch=watch
    ).solution


def _poisson(problem: _Problem, watch: Watch) -> Array:
    """Robust Poisson reconstruction (Eq. 6)."""
    quadratic = problem.smoothness * isotropic_smoothness(problem.differences)
    return minimize(problem.rows, problem.target, problem.l1(), quadratic, watch=watch).solution


def _ridge_aware(problem: _Problem, watch: Watch) -> Array:
    """The second solve, with the smoothness of ridge candidates turned along the ridge (Eq. 12)."""
    first = _poisson(problem, watch.part(0, 0.5))
    curvature = principal_curvature(problem.grid, first)
    candidates = ridge_candidates(curvature, problem.settings.ridge_curvature)
    quadratic = problem.smoothness * ridge_smoothness(
        problem.grid.size,
        problem.differences,
        curvature.nodes[candidates],
        curvature.direction[candidates],
        problem.settings.ridge_emphasis,
    )
    second = minimize(problem.rows, problem.target, problem.l1(), quadratic, start=first, watch=watch.part(0.5, 1))
    return second.solution


_OUTER_ITERATIONS = 8
_INNER_ITERATIONS = 3


def _developable(problem: _Problem, watch: Watch) -> Array:
    """Stiffen the surface along its own rulings, which are taken anew from each surface so found."""
    solution = _poisson(problem, watch.part(0, 0.3))
    loss = Loss("cauchy", _CAUCHY_SCALE * problem.noise)
    for outer in range(_OUTER_ITERATIONS):
        watch.step(0.3 + 0.7 * outer / _OUTER_ITERATIONS, "Bending the surface along its rulings")
        prior = developable_smoothness(problem.grid, principal_curvature(problem.grid, solution))
        solution = minimize(
            problem.rows,
            problem.target,
            loss,
            _DEVELOPABLE_SHARE * problem.smoothness * prior,
            start=solution,
            max_iterations=_INNER_ITERATIONS,
        ).solution
    return solution


_SOLVERS = {
    "poisson_l2": _poisson_l2,
    "poisson": _poisson,
    "ridge_aware": _ridge_aware,
    "developable": _developable,
}
