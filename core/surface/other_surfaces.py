"""The surfaces that other errors of the points would have given.

The surface answers to a change of its points as a linear system does, with the weights and the rulings of the fit.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU

from ..arrays import Array
from ..camera import Camera
from ..numeric.robust import factorize
from .depth_grid import DepthGrid
from .solvers import quadratic_near
from .surface import Surface, problem_of
from .surface_problem import SurfaceProblem
from .surface_settings import SurfaceSettings

# Distance, in grid steps, at which slopes are measured.
_SLOPE_OVER = 0.25


@dataclass(frozen=True)
class OtherSurfaces:
    """A surface's answer to other points.

    Attributes
    ----------
    problem : SurfaceProblem
    over_grid : (N,) bool array
        Which of the points the problem has, before those of the edge.
    weight : (M,) array
        Of the problem's points, halved as in `minimize`.
    solver : SuperLU
        Of the linear system, with the prior along the rulings of the surface.
    solution : (unknowns,) array
        The surface that solves the linear system.
    """

    problem: SurfaceProblem
    over_grid: NDArray[np.bool_]
    weight: Array
    solver: SuperLU
    solution: Array

    @classmethod
    def of(cls, surface: Surface, points: Array, settings: SurfaceSettings) -> OtherSurfaces:
        """Those around a developable surface that was fitted to points (N, 3) with these settings."""
        grid = surface.grid
        problem = problem_of(surface, points, settings)
        quadratic, loss = quadratic_near(problem, surface.inverse_depth)
        weight = loss.weight(problem.target - problem.rows @ surface.inverse_depth) / 2
        over_grid = grid.sampling_rows(grid.frame.from_world(points)[0])[1]
        weighted = problem.rows.multiply(weight[:, None])
        solver = factorize((problem.rows.T @ weighted + quadratic).tocsc())
        return cls(problem, over_grid, weight, solver, solver.solve(weighted.T @ problem.target))

    @property
    def grid(self) -> DepthGrid:
        return self.problem.grid

    def slopes(self, plane: Array) -> Array:
        """Slopes (N, 2) of the surface at plane coordinates (N, 2); 0 where the grid ends."""
        apart = _SLOPE_OVER * self.grid.step
        slope = np.zeros((len(plane), 2))
        for axis, way in enumerate(np.eye(2)):
            (ahead, there), (behind, here) = (
                self.grid.sampling_rows(plane + sign * apart * way) for sign in (1.0, -1.0)
            )
            value = np.full((2, len(plane)), np.nan)
            value[0, there], value[1, here] = ahead @ self.solution, behind @ self.solution
            slope[:, axis] = np.nan_to_num((value[0] - value[1]) / (2 * apart))
        return slope

    def after(self, moves: Iterator[tuple[Array, Camera]]) -> Iterator[tuple[Array, Camera]]:
        """The surface (unknowns,) for each of several other places of all points (N, 3) and of the reference view."""
        problem, frame = self.problem, self.grid.frame
        count = int(self.over_grid.sum())
        before, depth = problem.plane[:count], problem.target[:count]
        slope = self.slopes(before)
        # the points of the edge, which follow, stay where they are: no track says how they would move
        change = np.zeros(len(problem.target))
        for points, camera in moves:
            plane, inverse_depth = replace(frame, camera=camera).from_world(points[self.over_grid])
            # what is moved along the surface does not move it
            change[:count] = inverse_depth - depth - (slope * (plane - before)).sum(axis=1)
            yield self.solution + self.solver.solve(problem.rows.T @ (self.weight * change)), camera
