"""Edges marked on a mesh, as straight ridges."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..arrays import Array, Indices

# Values without a figure are choices; no measurement of them is recorded.
# A run ends where it turns by more.
_TURN = np.radians(30.0)
# A chain of edges counts as a straight line if it stays this near to one (in edges), because edges can only go where
# the mesh has them; but at least within this share of the line's own length.
_STAIRCASE, _SHORT = 1.0, 0.35


def runs_of_edges(positions: Array, edges: Indices) -> list[Indices]:
    """Marked edges as straight runs of vertices.

    Parameters
    ----------
    positions : (V, 2) or (V, 3) array
        On a flat map of the surface, if there is one, or in space, where straight creases are straight too.
    edges : (E, 2) int array
        Pairs of vertices.

    Returns
    -------
    list of (K,) int arrays
        Vertices along each run, in order. Runs end where more than two marked edges meet and where the line turns by
        more than 30 degrees, apart from the steps that it makes where the mesh has no edge along it.
    """
    return [run for chain in _chains(edges) for run in _straight_runs(positions, chain)]


def _chains(edges: Indices) -> list[Indices]:
    """Edges chained up to where more or fewer than two meet."""
    neighbours: dict[int, list[int]] = {}
    for one, other in np.unique(np.sort(edges.reshape(-1, 2), axis=1), axis=0).tolist():
        neighbours.setdefault(one, []).append(other)
        neighbours.setdefault(other, []).append(one)
    done: set[tuple[int, int]] = set()
    chains = []
    # Rings have no end at which to start and come last.
    for start in sorted(neighbours, key=lambda vertex: (len(neighbours[vertex]) == 2, vertex)):
        for second in neighbours[start]:
            if (start, second) in done:
                continue
            chain = [start, second]
            while len(neighbours[chain[-1]]) == 2 and chain[-1] != start:
                one, other = neighbours[chain[-1]]
                chain.append(other if one == chain[-2] else one)
            done |= {step for a, b in pairwise(chain) for step in ((a, b), (b, a))}
            chains.append(np.array(chain, np.int64))
    return chains


def _straight_runs(positions: Array, chain: Indices) -> list[Indices]:
    points = positions[chain]
    if chain[0] == chain[-1]:  # a ring is opened at its farthest point, which is a corner if it has any
        farthest = int(np.argmax(np.linalg.norm(points[:-1] - points[:-1].mean(0), axis=1)))
        chain = np.concatenate([chain[farthest:-1], chain[: farthest + 1]])
        points = positions[chain]
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    knots = _knots(points, _STAIRCASE * float(np.median(length)))
    leg = np.diff(points[knots], axis=0)
    leg /= np.linalg.norm(leg, axis=1, keepdims=True)
    corner = np.flatnonzero((leg[1:] * leg[:-1]).sum(1) < np.cos(_TURN)) + 1
    ends = [0, *(knots[place] for place in corner), len(chain) - 1]
    return [chain[start : end + 1] for start, end in pairwise(ends)]


def _knots(points: Array, tolerance: float) -> list[int]:
    """Points between which a line of points (K, D) stays near to its chords, including both ends."""
    knots, pending = [0], [len(points) - 1]
    while pending:
        start, end = knots[-1], pending[-1]
        chord = points[end] - points[start]
        span = float(np.linalg.norm(chord))
        apart = _apart(points[start : end + 1], points[start], chord / max(span, 1e-300))
        worst = int(np.argmax(apart))
        if apart[worst] > min(tolerance * (1 + 1e-9), _SHORT * span) and end - start > 1:
            pending.append(start + worst)
        else:
            knots.append(pending.pop())
    return knots


def _apart(points: Array, origin: Array, direction: Array) -> Array:
    """Distance of points (N, D) from a line."""
    offset = points - origin
    return np.linalg.norm(offset - (offset @ direction)[:, None] * direction, axis=1)
