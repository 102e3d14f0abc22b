"""Straight crease lines from the ridge candidates of a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..numeric.peaks import peak_offset
from .curvature import PrincipalCurvature, ridge_candidates
from .depth_grid import DepthGrid
from .surface import Surface

Flags = NDArray[np.bool_]

# A prototype with 4 times the median, gaps of 4 steps and lengths from .2 found 14 of 18 creases on 14 synthetic sheets
# (those that it missed were halves of crossing ones), and two false ones. What has no figure is a choice.
# At a ridge the paper turns at least this much within two grid steps, and bends this much more than in the middle.
_MINIMUM_TURN = np.radians(12.0)
_OVER_MEDIAN = 4.0
# The curvature of a crease is this many times that of the paper beside it, this many grid steps away.
_CONTRAST = 2.0
_BESIDE = 4.0
# In grid steps: the largest distance of a crest from its line, and the longest gap between crests.
_TOLERANCE = 1.0
_GAP = 4.0
# In page lengths.
_MINIMUM_LENGTH = 0.2
# A ridge is straight in space within this many page lengths; a line that only looks straight from the camera is two
# creases.
_BEND_IN_SPACE = 0.006
# Between a crest's own direction and the line.
_MAXIMUM_TURN = np.radians(15.0)
# Random lines that are tried for each ridge. A choice.
_TRIALS = 400


@dataclass(frozen=True)
class Ridge:
    """A straight crease.

    Attributes
    ----------
    ends : (2, 2) array
        Plane coordinates of the surface's frame.
    curvature : float
        Median of kappa_2 along it, 1 / page length; its sign distinguishes mountain and valley.
    """

    ends: Array
    curvature: float


@dataclass(frozen=True)
class _Crests:
    """Places where the curvature has its maximum across the ruling: position, ruling and signed curvature."""

    position: Array
    direction: Array
    curvature: Array

    def take(self, keep: Flags) -> _Crests:
        return _Crests(self.position[keep], self.direction[keep], self.curvature[keep])


def find_ridges(surface: Surface, *, seed: int = 0) -> tuple[Ridge, ...]:
    """Crease lines, the longest first; they are straight as seen from the camera.

    Parameters
    ----------
    surface : Surface
    seed : int
        For the random trials of lines.
    """
    crests = _crests(surface.grid, surface.curvature)
    generator = np.random.default_rng(seed)
    ridges = []
    while len(crests.position) >= 2:
        best = _best_line(crests, surface.grid.step, generator)
        if best is None:
            break
        ridge, members = best
        ridges.append(ridge)
        crests = crests.take(~members)
    return tuple(sorted(ridges, key=lambda ridge: -float(np.linalg.norm(ridge.ends[1] - ridge.ends[0]))))


def straight_in_space(surface: Surface, ends: Array) -> list[Array]:
    """Split a crease where it bends along the line of sight; pieces too short to differ from noise are dropped.

    Parameters
    ----------
    surface : Surface
    ends : (2, 2) array
        Plane coordinates of the surface's frame.

    Returns
    -------
    list of (2, 2) arrays
    """
    span = ends[1] - ends[0]
    along = np.linspace(0, 1, max(int(np.linalg.norm(span) / surface.grid.step), 3))[:, None]
    line = ends[0] + along * span
    space = surface.at(line) / surface.grid.frame.unit
    chord = (space[-1] - space[0]) / np.linalg.norm(space[-1] - space[0])
    offset = space - space[0]
    bend = np.linalg.norm(offset - (offset @ chord)[:, None] * chord, axis=1)
    worst = int(np.argmax(bend))
    if bend[worst] < _BEND_IN_SPACE:
        return [ends]
    halves = (np.stack([line[0], line[worst]]), np.stack([line[worst], line[-1]]))
    long = [half for half in halves if np.linalg.norm(half[1] - half[0]) >= _MINIMUM_LENGTH / 2]
    return [piece for half in long for piece in straight_in_space(surface, half)]


def _crests(grid: DepthGrid, curvature: PrincipalCurvature) -> _Crests:
    """Maxima of |kappa_2| across the ruling, to a fraction of a step by the parabola through three values."""
    size = np.abs(curvature.across)
    everywhere = np.zeros(grid.size)
    everywhere[curvature.nodes] = size
    image = np.nan_to_num(grid.to_image(everywhere))
    row, column = np.nonzero(grid.index >= 0)
    place = np.stack([row, column], axis=1)[curvature.nodes]
    across = np.stack([curvature.direction[:, 0], -curvature.direction[:, 1]], axis=1)
    before, after, left, right = (
        ndimage.map_coordinates(image, (place + steps * across).T, order=1, mode="nearest")
        for steps in (-1, 1, -_BESIDE, _BESIDE)
    )
    threshold = max(_MINIMUM_TURN / (2 * grid.step), _OVER_MEDIAN * float(np.median(size)))
    crest = ridge_candidates(curvature, threshold) & (size >= before) & (size >= after)
    crest &= size > _CONTRAST * (left + right) / 2
    offset = np.clip(peak_offset(before, size, after), -0.5, 0.5)
    position = grid.origin + grid.step * (place + offset[:, None] * across)[:, ::-1]
    return _Crests(position[crest], curvature.direction[crest], curvature.across[crest])


def _best_line(crests: _Crests, step: float, generator: np.random.Generator) -> tuple[Ridge, Flags] | None:
    """The line through two crests with the longest unbroken run of crests, refitted to them."""
    count = len(crests.position)
    pairs = generator.integers(0, count, (_TRIALS, 2))
    best, longest = None, _MINIMUM_LENGTH
    for one, other in pairs:
        direction = crests.position[other] - crests.position[one]
        length = np.linalg.norm(direction)
        if length < _GAP * step or crests.curvature[one] * crests.curvature[other] < 0:
            continue
        members = _run(crests, crests.position[one], direction / length, one, step)
        if not members.any():
            continue
        extent = np.ptp(crests.position[members] @ (direction / length))
        if extent > longest:
            best, longest = members, extent
    if best is None:
        return None
    ridge, members = _refit(crests, best, step)
    return ridge, members | best


def _run(crests: _Crests, origin: Array, direction: Array, sign_of: int, step: float) -> Flags:
    """Crests on a line that bend the same way and are in the longest run without a gap."""
    offset = crests.position - origin
    across = np.abs(offset @ np.array([-direction[1], direction[0]]))
    aligned = np.abs(crests.direction @ direction) > np.cos(_MAXIMUM_TURN)
    same = crests.curvature * crests.curvature[sign_of] > 0
    on = np.flatnonzero((across < _TOLERANCE * step) & aligned & same)
    members = np.zeros(len(crests.position), bool)
    if len(on) == 0:
        return members
    order = on[np.argsort(offset[on] @ direction)]
    along = offset[order] @ direction
    runs = np.split(np.arange(len(order)), np.flatnonzero(np.diff(along) > _GAP * step) + 1)
    members[order[max(runs, key=lambda run: along[run[-1]] - along[run[0]])]] = True
    return members


def _refit(crests: _Crests, members: Flags, step: float) -> tuple[Ridge, Flags]:
    """Total least squares through the members, weighted by curvature, and the run on that line."""
    for _ in range(3):
        weight = np.abs(crests.curvature[members])
        position = crests.position[members]
        centre = weight @ position / weight.sum()
        spread = (position - centre).T @ ((position - centre) * weight[:, None])
        direction = np.linalg.eigh(spread)[1][:, 1]
        refreshed = _run(crests, centre, direction, int(np.flatnonzero(members)[0]), step)
        if refreshed.sum() < 2:
            break
        members = refreshed
    along = (crests.position[members] - centre) @ direction
    ends = centre + np.array([along.min(), along.max()])[:, None] * direction
    return Ridge(ends, float(np.median(crests.curvature[members]))), members
