"""From points to a depth grid: the paper's section 3.1 (Eq. 1-9, 12) and the developable prior that succeeds it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ..arrays import Array
from ..camera import Camera
from ..creases.crease_ends import cut_to_outline
from ..creases.drawn_creases import crease_lines
from ..errors import StepFailed
from ..numeric.robust import Loss, minimize
from ..setting import Choice, setting
from ..watch import SILENT, Watch
from .curvature import PrincipalCurvature, principal_curvature, ridge_candidates, ruled_along_hinges
from .depth_grid import DepthGrid, SecondDifferences, ViewFrame, frame_for, grid_over
from .edge_points import EdgePoints
from .hinges import Hinges
from .noise import point_noise
from .smoothness import developable_smoothness, isotropic_smoothness, ridge_smoothness

SurfaceMethod = Literal["developable", "ridge_aware", "poisson", "poisson_l2"]

# Values without a figure are choices; no measurement of them is recorded.
# Smoothness that suits 1200 points with noise of 0.2 % of the page length, on grids of 50 to 140 rows alike (six kinds
# of synthetic sheets); that it scales with noise / sqrt(points) is an assumption, which the stiffness then corrects.
_BASE_SMOOTHNESS = 3e-5
_BASE_NOISE = 2e-3
_BASE_POINTS = 1200
# The developable prior needs this share of it: most of its stiffness is along the rulings.
_DEVELOPABLE_SHARE = 1 / 30
# Scales at which the l1 loss becomes quadratic and Cauchy's turns over, in noise levels. On a synthetic sheet with two
# creases and 15 % wrong points, l1 from .25 to .5 and then Cauchy at 2 left a tenth less error within the page, and a
# quarter less on all of it, than l1 alone.
_L1_SCALE = 0.25
_CAUCHY_SCALE = 2.0
# Four times the minimum for a plane: 24 points of a flat sheet on a clipboard give a page whose squares are square.
_MINIMUM_POINTS = 12
# Accuracy of a hand-drawn end of a crease, as a share of the page length.
_HAND = 2e-3
# Largest movement of a hinge between two solves, in grid steps.
_HINGE_MOVE = 0.5
# Cost of a hinge's turn, as a share of its cost without a hinge: it determines hinges where there are no points.
_HINGE_STIFFNESS = 1e-5
# The place of a hinge that hardly turns is determined as if it turned by this.
_LEAST_TURN = 0.05


@dataclass(frozen=True)
class SurfaceSettings:
    """How the surface is reconstructed.

    ``poisson_l2`` is plain Poisson, ``poisson`` has the l1 data term (Eq. 6), and ``ridge_aware`` is the paper's second
    solve (Eq. 12); ``ridge_curvature`` is its kappa_th and ``ridge_emphasis`` its beta. The smoothness is a factor on
    the value derived from the noise and the number of points, or, for the developable surface of
    `reconstruct_with_creases`, on the value chosen for the sheet.
    """

    method: SurfaceMethod = setting(
        "developable",
        "how the surface is fitted to the points",
        label="Surface",
        option="--surface",
        choices={
            "developable": Choice(
                "Developable",
                "smooth along straight lines, free to bend across them as paper does, sharp along creases",
            ),
            "ridge_aware": Choice("Ridge-Aware", "the published method, smooth everywhere except across the creases"),
            "poisson": Choice("Poisson", "only the first solve of the published method"),
            "poisson_l2": Choice("Poisson, Least Squares", "the same solve without robustness against wrong points"),
        },
    )
    grid_rows: int = setting(
        85,
        "nodes of the surface along the page's long side; 120 suits narrow folds",
        label="Grid Rows",
        option="--grid-rows N",
        least=20,
        most=400,
    )
    smoothness: float = setting(
        1.0,
        "factor on the smoothness derived from the points: above 1 gives fewer waves, below 1 finer bends",
        label="Smoothness",
        option="--smoothness X",
        least=1e-4,
        most=1e4,
        usual=(0.1, 10),
    )
    ridge_curvature: float = setting(
        4.0,
        "curvature above which the ridge-aware surface treats a place as a crease, per page length",
        label="Ridge Curvature",
        least=1e-3,
        most=1e4,
        only_with=("method", "ridge_aware"),
    )
    ridge_emphasis: float = setting(
        10.0,
        "how much less smooth the ridge-aware surface is across a crease than along it",
        label="Ridge Emphasis",
        least=1.001,
        most=1e6,
        usual=(None, 100),
        only_with=("method", "ridge_aware"),
    )


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
    problem, inverse_depth = _SOLVERS[settings.method](problem, watch)
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
    problem, solution = problem_of(replace(surface, edge=edge), points, settings), surface.inverse_depth
    for _ in range(_EDGE_ITERATIONS):
        solution = stiffened(problem, solution)
    curvature = principal_curvature(surface.grid, solution)
    residuals = (problem.target - problem.rows @ solution)[: len(surface.residuals)]
    return replace(surface, inverse_depth=solution, curvature=curvature, residuals=residuals, edge=edge)


def problem_of(surface: Surface, points: Array, settings: SurfaceSettings) -> SurfaceProblem:
    """The problem of a developable surface, as fitted to ``points`` (N, 3) and to its edge with these settings."""
    stiff = replace(settings, smoothness=surface.stiffness * settings.smoothness)
    problem = SurfaceProblem.of(points, surface.grid.frame, surface.grid, stiff)
    return problem if surface.edge is None else problem.with_edge(surface.edge)


def problem_over(
    points: Array, reference: Camera, polygon: Array, settings: SurfaceSettings, creases: Array | None = None
) -> SurfaceProblem:
    """The problem that `reconstruct` solves; parameters and errors are the same."""
    if len(points) < _MINIMUM_POINTS:
        raise StepFailed(
            f"Only {len(points)} points were found on the sheet; {_MINIMUM_POINTS} are needed. "
            "Take sharper photos from nearer, or use a sheet with more print."
        )
    frame = frame_for(points, reference, polygon)
    edge = frame.from_pixels(polygon)
    grid = grid_over(frame, edge, settings.grid_rows)
    if creases is not None:
        grid = replace(grid, hinges=Hinges(crease_lines(frame.from_pixels(creases), edge, grid.step)))
    return SurfaceProblem.of(points, frame, grid, settings)


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
        if inside.sum() < _MINIMUM_POINTS:
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


def _poisson_l2(problem: SurfaceProblem, watch: Watch) -> tuple[SurfaceProblem, Array]:
    loss = Loss("squared", problem.noise)
    quadratic = problem.settled(problem.smoothness * isotropic_smoothness(problem.differences))
    return problem, minimize(problem.rows, problem.target, loss, quadratic, watch=watch).solution


def poisson(problem: SurfaceProblem, watch: Watch) -> tuple[SurfaceProblem, Array]:
    """Robust Poisson reconstruction (Eq. 6)."""
    quadratic = problem.settled(problem.smoothness * isotropic_smoothness(problem.differences))
    return problem, minimize(problem.rows, problem.target, problem.l1(), quadratic, watch=watch).solution


def _ridge_aware(problem: SurfaceProblem, watch: Watch) -> tuple[SurfaceProblem, Array]:
    """The second solve, with the smoothness of ridge candidates turned along the ridge (Eq. 12)."""
    _, first = poisson(problem, watch.part(0, 0.5))
    curvature = principal_curvature(problem.grid, first)
    candidates = ridge_candidates(curvature, problem.settings.ridge_curvature)
    quadratic = problem.smoothness * ridge_smoothness(
        problem.grid.size,
        problem.differences,
        curvature.nodes[candidates],
        curvature.direction[candidates],
        problem.settings.ridge_emphasis,
    )
    quadratic = problem.settled(quadratic)
    second = minimize(problem.rows, problem.target, problem.l1(), quadratic, start=first, watch=watch.part(0.5, 1))
    return problem, second.solution


# Solves with new rulings, and rounds of reweighting in each. Choices.
_OUTER_ITERATIONS = 8
_INNER_ITERATIONS = 3
# Solves with new rulings once points of the edge are added. A choice.
_EDGE_ITERATIONS = 4


def _developable(problem: SurfaceProblem, watch: Watch) -> tuple[SurfaceProblem, Array]:
    """Stiffen the surface along its own rulings, which are recomputed from each new surface.

    After each solve except the last, hinges move to where the points show them, within a hand's error.
    """
    drawn = problem.grid.hinges
    _, solution = poisson(problem, watch.part(0, 0.3))
    for outer in range(_OUTER_ITERATIONS):
        watch.step(0.3 + 0.7 * outer / _OUTER_ITERATIONS, "Bending the surface along its rulings")
        if len(drawn) and outer < _OUTER_ITERATIONS - 1:
            problem, solution = _with_moved_hinges(problem, solution, drawn)
        else:
            solution = stiffened(problem, solution)
    return problem, solution


def stiffened(
    problem: SurfaceProblem, start: Array, hand: sparse.csr_array | None = None, linear: Array | None = None
) -> Array:
    """The surface that is stiff along the rulings of ``start``; ``hand``, ``linear`` as in `SurfaceProblem.hand`."""
    quadratic, loss = quadratic_near(problem, start)
    return minimize(
        problem.rows,
        problem.target,
        loss,
        quadratic if hand is None else quadratic + hand,
        start=start,
        linear=linear,
        max_iterations=_INNER_ITERATIONS,
    ).solution


def quadratic_near(problem: SurfaceProblem, surface: Array) -> tuple[sparse.csr_array, Loss]:
    """The prior of the developable surface with the rulings of ``surface`` (unknowns,), and the loss of the points."""
    curvature = ruled_along_hinges(problem.grid, principal_curvature(problem.grid, surface))
    prior = developable_smoothness(problem.grid, curvature)
    quadratic = problem.settled(_DEVELOPABLE_SHARE * problem.smoothness * prior)
    return quadratic, Loss("cauchy", _CAUCHY_SCALE * problem.noise)


def _with_moved_hinges(problem: SurfaceProblem, start: Array, drawn: Hinges) -> tuple[SurfaceProblem, Array]:
    """One solve in which the hinges may move off their lines, and the problem with the hinges in their new places."""
    movable = problem.with_hinges(replace(problem.grid.hinges, movable=True))
    nodes, known = problem.grid.size, problem.grid.unknowns
    hand, linear = movable.hand(drawn, start[nodes:])
    lifts = np.zeros(movable.grid.unknowns - known)
    solution = stiffened(movable, np.concatenate([start, lifts]), hand, linear)
    hinges = movable.grid.hinges.moved(solution[nodes:], _HINGE_MOVE * problem.grid.step)
    return problem.with_hinges(replace(hinges, movable=False)), solution[:known]


_SOLVERS = {
    "poisson_l2": _poisson_l2,
    "poisson": poisson,
    "ridge_aware": _ridge_aware,
    "developable": _developable,
}
