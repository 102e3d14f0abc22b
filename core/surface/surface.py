"""From points to a depth grid: the paper's section 3.1 and the developable surface that succeeds it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..creases.crease_ends import cut_to_outline
from ..creases.drawn_creases import crease_lines
from ..errors import StepFailed
from ..watch import SILENT, Watch
from .curvature import PrincipalCurvature, principal_curvature
from .depth_grid import DepthGrid, frame_for, grid_over
from .edge_points import EdgePoints
from .hinges import Hinges
from .solvers import SOLVERS, stiffened
from .surface_problem import MINIMUM_POINTS, SurfaceProblem
from .surface_settings import SurfaceSettings

# Solves with new rulings once points of the edge are added. A choice.
_EDGE_ITERATIONS = 4
# A surface is far from a place of the edge beyond so many of the place's deviations. If that is so for more than this
# part of the edge, it is first drawn towards the edge in so many solves, with a loss that does not take what is far off
# for wrong: on a rendered page of a book whose paper is 8 mm below the surface at the gutter, the loss of the points
# leaves the surface where it is.
_FAR, _FAR_OFF, _DRAWN_ITERATIONS = 10.0, 0.005, 3


@dataclass(frozen=True)
class Surface:
    """The sheet's surface over the reference view.

    Attributes
    ----------
    grid : DepthGrid
    inverse_depth : (unknowns,) array
        Scaled inverse depth at the nodes in use, then the turns of the hinges.
    curvature : PrincipalCurvature
    noise : float
        Standard deviation of the points along the ray, page lengths.
    residuals : (M,) array
        Point minus surface, page lengths, for the points over the grid.
    creases : tuple of (2, 2) arrays
        The given or detected creases on the paper: in plane coordinates, moved to where the points show them, ending
        where they meet and at the paper's edge.
    stiffness : float
        The factor on the rule's smoothness that was chosen for the sheet.
    confidence : tuple of float
        The confidence of each crease, see `left_out.Assessment`; empty if not estimated.
    edge : EdgePoints or None
        The points of the paper's edge to which it was fitted too.
    """

    grid: DepthGrid
    inverse_depth: Array
    curvature: PrincipalCurvature
    noise: float
    residuals: Array
    creases: tuple[Array, ...] = ()
    stiffness: float = 1.0
    confidence: tuple[float, ...] = ()
    edge: EdgePoints | None = None

    def at(self, plane: Array) -> Array:
        """World points (N, 3) of the surface at plane coordinates (N, 2), which must be over the grid."""
        return self.grid.frame.to_world(plane, self.grid.interpolate(self.inverse_depth, plane))

    @property
    def missed_edge(self) -> float:
        """The share of the places of its edge that the surface is far from; 0 without an edge."""
        if self.edge is None:
            return 0.0
        rows, inside = self.grid.sampling_rows(self.edge.plane)
        off = np.abs(self.edge.inverse_depth[inside] - rows @ self.inverse_depth)
        far = off > _FAR * np.maximum(self.edge.deviation[inside], self.noise)
        return float(far.mean()) if len(far) else 0.0


def reconstruct(
    points: Array,
    reference: Camera,
    polygon: Array,
    settings: SurfaceSettings | None = None,
    watch: Watch = SILENT,
    creases: Array | None = None,
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
    creases : (K, 2, 2) array, optional
        Ends of known straight creases, distorted pixels: the surface turns there at no cost.

    Raises
    ------
    StepFailed
        If there are too few points.
    """
    settings = settings or SurfaceSettings()
    problem = problem_over(points, reference, polygon, settings, creases)
    edge = problem.grid.frame.from_pixels(polygon)
    problem, inverse_depth = SOLVERS[settings.method](problem, watch)
    grid = problem.grid
    residuals = problem.target - problem.rows @ inverse_depth
    curvature = principal_curvature(grid, inverse_depth)
    lines = tuple(piece for ends in grid.hinges.ends for piece in cut_to_outline(ends, edge))
    return Surface(grid, inverse_depth, curvature, problem.noise, residuals, lines)


def fitted_to_edge(surface: Surface, points: Array, settings: SurfaceSettings, edge: EdgePoints) -> Surface:
    """The developable surface through points of the paper's edge as well, with the creases and the stiffness it has.

    Parameters
    ----------
    surface : Surface
        Fitted to ``points`` (N, 3) with these settings.
    points, settings
    edge : EdgePoints
    """
    surface = replace(surface, edge=edge)
    problem, solution = problem_of(surface, points, settings), surface.inverse_depth
    if surface.missed_edge > _FAR_OFF:
        for _ in range(_DRAWN_ITERATIONS):
            solution = stiffened(problem, solution, loss=problem.l1())
    for _ in range(_EDGE_ITERATIONS):
        solution = stiffened(problem, solution)
    curvature = principal_curvature(surface.grid, solution)
    residuals = (problem.target - problem.rows @ solution)[: len(surface.residuals)]
    return replace(surface, inverse_depth=solution, curvature=curvature, residuals=residuals)


def problem_of(surface: Surface, points: Array, settings: SurfaceSettings) -> SurfaceProblem:
    """The problem of a developable surface, as fitted to ``points`` (N, 3) and to its edge with these settings."""
    stiff = replace(settings, smoothness=surface.stiffness * settings.smoothness)
    problem = SurfaceProblem.of(points, surface.grid.frame, surface.grid, stiff)
    return problem if surface.edge is None else problem.with_edge(surface.edge)


def problem_over(
    points: Array, reference: Camera, polygon: Array, settings: SurfaceSettings, creases: Array | None = None
) -> SurfaceProblem:
    """The problem that `reconstruct` solves; parameters and errors are the same."""
    if len(points) < MINIMUM_POINTS:
        raise StepFailed(
            f"Only {len(points)} points were found on the sheet; {MINIMUM_POINTS} are needed. "
            "Take sharper photos from nearer, or use a sheet with more print."
        )
    frame = frame_for(points, reference, polygon)
    edge = frame.from_pixels(polygon)
    grid = grid_over(frame, edge, settings.grid_rows)
    if creases is not None:
        grid = replace(grid, hinges=Hinges(crease_lines(frame.from_pixels(creases), edge, grid.step)))
    return SurfaceProblem.of(points, frame, grid, settings)
