"""Determines how stiff a sheet is and which creases it has, by leaving out patches of points.

A surface that is too limp bulges where there are no points, and one that is too stiff cuts corners. Near neighbours
predict a single left-out point; a whole patch has none, like blank paper. A fold whose angle depends on which patches
are left out is caused by noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from ..arrays import Array
from ..camera import Camera
from ..numeric.threads import in_threads
from ..watch import SILENT, Watch
from .solvers import poisson, stiffened
from .surface import problem_over
from .surface_problem import SurfaceProblem
from .surface_settings import SurfaceSettings

# Values without a figure are choices; no measurement of them is recorded.
# The choices: factors on the smoothness that follows from the noise and the number of points. The smallest suits the
# most irregular sheet measured; plain sheets with dense tracks take the largest.
STIFFNESS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
# A fold by less than this (degrees) is not a crease: hinges on one smooth sheet turn by 1 to 7, true folds by 14 and
# more.
LEAST_FOLD = 8.0
# The choice is made on a grid with this many nodes along the page.
_ROWS = 50
# Side of a patch in page lengths: wider than the gaps in print that bulge, but small enough for dozens on a page.
_PATCH = 0.1
# Patches are left out in this many rounds; neighbouring patches, even at corners, never in the same one.
_TURNS = 5
# Solves with new rulings: from scratch, and from the next limper surface.
_FIRST_SOLVES = 6
_NEXT_SOLVES = 3
# The same once patches are left out, with at least this many points and with fewer. The first of these solves still
# bends where the left-out points did, as if it knew them: of a flat sheet's 70 points, the limpest surface loses .45
# and the stiffest .63 after two, .59 and .62 after five, .71 and .62 after twelve. Of 9000 points it hardly matters
# (1.52 and 1.67 after two and ten), and two solves take a third of the time.
_MANY_POINTS = 1000
_LEFT_OUT_SOLVES, _LEFT_OUT_SOLVES_OF_FEW = 2, 5
# No stiffer surface is tried once the loss is this many times the least.
_HOPELESS = 1.3
# A surface is clearly worse beyond this many standard errors of the difference of losses. With one, as in the book, set
# XII is taken for ten times as stiff as is best, and its page is .78 px off instead of .57; with .5 the pages of 30
# generated sheets are .0925 % of their height off on average, with one .0946, with none .0895.
_CLEARLY = 0.5
# Fewer patches are not enough for a choice.
_FEWEST_PATCHES = 5
# Page lengths within which the assessed pieces of a crease belong to it. A choice.
_ASSESSED_WITHIN = 0.01
# Distance from a hinge at which its tangent planes are measured, in grid steps.
_BESIDE = 1.5


@dataclass(frozen=True)
class Assessment:
    """What left-out patches reveal about a sheet.

    Attributes
    ----------
    stiffness : float
        The member of `STIFFNESS` that suits it.
    creases : (K, 2, 2) array
        The pieces of its creases between crossings, plane coordinates.
    confidence : (K,) array
        The probability that the paper is folded there by more than `LEAST_FOLD`, estimated from the scatter of the
        angle when other patches are left out.
    """

    stiffness: float
    creases: Array
    confidence: Array

    def confidence_of(self, ends: Array) -> float:
        """The confidence of a crease (2, 2), plane coordinates: the highest among its assessed pieces."""
        if not len(self.creases):
            return 0.0
        span = ends[1] - ends[0]
        length = float(np.linalg.norm(span))
        offset = self.creases.mean(1) - ends[0]
        onward = offset @ span / length
        across = np.abs(offset @ np.array([-span[1], span[0]])) / length
        beyond = np.maximum(np.maximum(-onward, onward - length), 0)
        distance = np.hypot(across, beyond)
        return float(self.confidence[distance <= max(float(distance.min()), _ASSESSED_WITHIN)].max())


def assess(
    points: Array,
    reference: Camera,
    polygon: Array,
    settings: SurfaceSettings,
    creases: Array | None = None,
    threads: int = 1,
    watch: Watch = SILENT,
) -> Assessment:
    """Choose the stiffness of the developable surface, and estimate the confidence of each crease.

    Parameters
    ----------
    points, reference, polygon, settings, creases, watch
        As for `surface.reconstruct`; the settings' own smoothness does not count.
    threads : int
        How many surfaces without patches are fitted at once.

    Raises
    ------
    Cancelled, StepFailed
    """
    rule = replace(settings, method="developable", smoothness=1.0, grid_rows=_ROWS)
    problem = problem_over(points, reference, polygon, rule, creases)
    patches = _Patches.of(problem.plane)
    start = _solved(problem, poisson(problem, SILENT)[1], _FIRST_SOLVES)
    tried: list[_LeftOut] = []
    for number, stiffness in enumerate(STIFFNESS if patches.count >= _FEWEST_PATCHES else STIFFNESS[:1]):
        watch.step(number / len(STIFFNESS), "Choosing how stiff the paper is")
        stiffer = replace(problem, smoothness=stiffness * problem.smoothness)
        start = _solved(stiffer, start, _NEXT_SOLVES)
        tried.append(_LeftOut.of(stiffer, patches, start, threads))
        if tried[-1].losses.mean() > _HOPELESS * min(each.losses.mean() for each in tried):
            break
    chosen = stiffest([each.losses for each in tried])
    return Assessment(STIFFNESS[chosen], problem.grid.hinges.ends, tried[chosen].confidence())


def stiffest(losses: Sequence[Array]) -> int:
    """The stiffest surface, by its place in ``losses``, that is not clearly worse than the best.

    Paper is stiff where nothing says otherwise: a limper surface needs patches (N,) whose losses say so beyond their
    own scatter. This is the rule of one standard error (Breiman et al., Classification and Regression Trees, 1984,
    section 3.4.3), with the error of the difference in the same patches.
    """
    best = min(losses, key=np.mean)
    worse = [each - best for each in losses]
    allowed = [_CLEARLY * np.std(each) / np.sqrt(len(each)) for each in worse]
    return max(number for number, each in enumerate(worse) if each.mean() <= allowed[number])


@dataclass(frozen=True)
class _Patches:
    """The patch of each point (M,), and the round in which it is left out."""

    patch: NDArray[np.int64]
    turn: NDArray[np.int64]

    @classmethod
    def of(cls, plane: Array) -> _Patches:
        column, row = np.floor((plane - plane.min(0)) / _PATCH).astype(int).T
        number = np.unique(column * (row.max() + 1) + row, return_inverse=True)[1].ravel()
        return cls(number, (column + 2 * row) % _TURNS)

    @property
    def count(self) -> int:
        return int(self.patch.max()) + 1

    def median(self, values: Array) -> Array:
        """Median of the points' values in each patch."""
        order = np.argsort(self.patch, kind="stable")
        stops = np.cumsum(np.bincount(self.patch))[:-1]
        return np.array([np.median(own) for own in np.split(values[order], stops)])


@dataclass(frozen=True)
class _LeftOut:
    """The loss of each patch on a surface fitted without it, and the hinges' angles (rounds, K) on these surfaces."""

    losses: Array
    angles: Array
    whole: Array

    @classmethod
    def of(cls, problem: SurfaceProblem, patches: _Patches, start: Array, threads: int) -> _LeftOut:
        solves = _LEFT_OUT_SOLVES if len(problem.target) >= _MANY_POINTS else _LEFT_OUT_SOLVES_OF_FEW

        def without(out: NDArray[np.bool_]) -> Array:
            return _solved(problem.without(out), start, solves)

        rounds = [out for turn in range(_TURNS) if (out := patches.turn == turn).any() and not out.all()]
        residual, angles = np.zeros(len(problem.target)), []
        for out, solution in zip(rounds, in_threads(without, rounds, threads), strict=True):
            residual[out] = problem.target[out] - problem.rows[out] @ solution
            angles.append(_fold_angles(problem, solution))
        # The offset of the whole surface counts: it is not to blame for the points' own noise or outliers.
        losses = np.log1p((patches.median(residual) / problem.noise) ** 2)
        hinges = len(problem.grid.hinges)
        return cls(losses, np.array(angles).reshape(len(angles), hinges), _fold_angles(problem, start))

    def confidence(self) -> Array:
        """See `Assessment`; the standard error is that of the jackknife with groups left out."""
        groups = len(self.angles)
        if groups < 2:
            return np.zeros(len(self.whole))
        error = np.sqrt((groups - 1) / groups * ((self.angles - self.angles.mean(0)) ** 2).sum(0))
        return ndtr((np.abs(self.whole) - LEAST_FOLD) / np.maximum(error, 1e-9))


def _solved(problem: SurfaceProblem, start: Array, solves: int) -> Array:
    for _ in range(solves):
        start = stiffened(problem, start)
    return start


def _fold_angles(problem: SurfaceProblem, solution: Array) -> Array:
    """Angle (K,), degrees, between the tangent planes on the two sides of each hinge's middle; 0 off the grid."""
    grid = problem.grid
    hinges = grid.hinges
    if not len(hinges):
        return np.zeros(0)
    middle, normal, along, reach = hinges.ends.mean(1), hinges.normals, hinges.directions, _BESIDE * grid.step
    places = np.stack(
        [middle + reach * normal, middle - reach * normal, middle + reach * along, middle - reach * along]
    )
    rows, inside = grid.sampling_rows(places.reshape(-1, 2))
    value = np.full(inside.shape, np.nan)
    value[inside] = rows @ solution
    before, behind, onward, back = value.reshape(4, -1)
    # Inverse depth w over the plane (x, y) is w = a + b x + c y on a plane in space with the normal (b D, c D, a).
    distance = grid.frame.depth / grid.frame.unit
    unit = []
    for side in (0.5, -0.5):
        across = (before - behind) / (2 * reach) + side * solution[grid.size :]
        slope = across[:, None] * normal + ((onward - back) / (2 * reach))[:, None] * along
        at_origin = (before + behind) / 2 - (slope * middle).sum(1)
        planes = np.column_stack([distance * slope, at_origin])
        unit.append(planes / np.linalg.norm(planes, axis=1, keepdims=True))
    angle: Array = np.degrees(np.arccos(np.clip((unit[0] * unit[1]).sum(1), -1, 1))) * np.sign(solution[grid.size :])
    return np.nan_to_num(angle)
