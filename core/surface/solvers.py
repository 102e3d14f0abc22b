"""The solvers of a surface's problem: the paper's (Eq. 1-9, 12), and the developable prior that succeeds them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from ..arrays import Array
from ..numeric.robust import Loss, minimize
from ..watch import Watch
from .curvature import principal_curvature, ridge_candidates, ruled_along_hinges
from .hinges import Hinges
from .smoothness import developable_smoothness, isotropic_smoothness, ridge_smoothness
from .surface_problem import SurfaceProblem

# Values without a figure are choices; no measurement of them is recorded.
# The developable prior needs this share of the smoothness: most of its stiffness is along the rulings.
_DEVELOPABLE_SHARE = 1 / 30
# Largest movement of a hinge between two solves, in grid steps.
_HINGE_MOVE = 0.5
# Solves with new rulings, and rounds of reweighting in each.
_OUTER_ITERATIONS = 8
_INNER_ITERATIONS = 3


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
    problem: SurfaceProblem,
    start: Array,
    hand: sparse.csr_array | None = None,
    linear: Array | None = None,
    loss: Loss | None = None,
) -> Array:
    """The surface that is stiff along the rulings of ``start``.

    ``hand`` and ``linear`` are as in `SurfaceProblem.hand`; without a ``loss`` of the points it is Cauchy's.
    """
    quadratic, cauchy = quadratic_near(problem, start)
    return minimize(
        problem.rows,
        problem.target,
        loss or cauchy,
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
    return quadratic, problem.cauchy()


def _with_moved_hinges(problem: SurfaceProblem, start: Array, drawn: Hinges) -> tuple[SurfaceProblem, Array]:
    """One solve in which the hinges may move off their lines, and the problem with the hinges in their new places."""
    movable = problem.with_hinges(replace(problem.grid.hinges, movable=True))
    nodes, known = problem.grid.size, problem.grid.unknowns
    hand, linear = movable.hand(drawn, start[nodes:])
    lifts = np.zeros(movable.grid.unknowns - known)
    solution = stiffened(movable, np.concatenate([start, lifts]), hand, linear)
    hinges = movable.grid.hinges.moved(solution[nodes:], _HINGE_MOVE * problem.grid.step)
    return problem.with_hinges(replace(hinges, movable=False)), solution[:known]


SOLVERS = {
    "poisson_l2": _poisson_l2,
    "poisson": poisson,
    "ridge_aware": _ridge_aware,
    "developable": _developable,
}
