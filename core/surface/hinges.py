"""Known creases: straight lines across which a surface over the plane may turn at no cost.

A straight crease is a ruling of the paper on both sides, so each side has one tangent plane all along it. The
difference of the two planes is a linear function with its zeros on the crease: one number, the turn, describes it. Two
more, the lifts, are its values at the drawn ends; non-zero lifts show how far the line is from its true place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ..arrays import Array

# Values without a figure are choices; no measurement of them is recorded.
# A place on a hinge, or where several meet, counts as this far off it, always in the same direction.
_NUDGE = 1e-9 * np.array([0.7390851332, 0.6736120292])
# How strongly ends shared by several hinges stay where nothing pulls them.
_JOINT_INERTIA = 0.05
_INERTIA = 1e-9  # of an end of its own, which is only not pulled along its hinge
# Below this turn a hinge bends too little to determine its own place.
_LEAST_TURN = 0.05


@dataclass(frozen=True)
class Hinges:
    """Straight lines across which a surface may turn.

    Their unknowns follow those of the grid's nodes: the turns of all hinges (jumps of the slope, positive where the
    surface bends towards larger values), then, if they are movable, the lifts at all first ends and at all last ends.

    Attributes
    ----------
    ends : (K, 2, 2) array
        Plane coordinates. Hinges that meet have exactly the same end there.
    movable : bool
        Whether the hinges may be a little beside their lines, which adds the lifts to the unknowns.
    """

    ends: Array
    movable: bool = False

    def __len__(self) -> int:
        return len(self.ends)

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""
        return len(self) * (3 if self.movable else 1)

    @property
    def lengths(self) -> Array:
        """Length of each hinge (K,)."""
        return np.linalg.norm(self.ends[:, 1] - self.ends[:, 0], axis=1)

    @property
    def directions(self) -> Array:
        """Unit vector along each hinge (K, 2)."""
        return (self.ends[:, 1] - self.ends[:, 0]) / self.lengths[:, None]

    @property
    def normals(self) -> Array:
        """Unit vector across each hinge (K, 2)."""
        along = self.directions
        return np.stack([-along[:, 1], along[:, 0]], axis=1)

    def columns(self, places: Array, nodes: Array, weights: Array) -> sparse.csr_array:
        """Corrections to weighted sums of node values, valid for the surface as continued from given places.

        On the straight way from a place to a node the surface turns at each hinge in between; subtracting the turns
        from the node's value continues the place's own side to the node.

        Parameters
        ----------
        places : (N, 2) array
        nodes : (N, M, 2) array
            Positions of the nodes in each sum.
        weights : (N, M) array

        Returns
        -------
        (N, unknowns) sparse array
        """
        places = places + _NUDGE
        reach = np.linalg.norm(nodes - places[:, None], axis=2).max(initial=0.0)
        entries: list[tuple[NDArray[np.int64], int, Array]] = []
        for number, (first, along, normal, length) in enumerate(
            zip(self.ends[:, 0], self.directions, self.normals, self.lengths, strict=True)
        ):
            beside, onward = (places - first) @ normal, (places - first) @ along
            near = np.flatnonzero((np.abs(beside) <= reach) & (onward >= -reach) & (onward <= length + reach))
            p, a = beside[near, None], onward[near, None]
            q, b = (nodes[near] - first) @ normal, (nodes[near] - first) @ along
            crosses = (p > 0) != (q > 0)
            meeting = a + np.where(crosses, p, 0.0) / np.where(crosses, p - q, 1.0) * (b - a)
            weight = np.where(crosses & (meeting >= 0) & (meeting <= length), weights[near], 0.0)
            entries.append((near, number, -(weight * np.abs(q)).sum(1)))
            if self.movable:
                share, side = b / length, np.sign(p[:, 0])
                entries.append((near, number + len(self), -side * (weight * (1 - share)).sum(1)))
                entries.append((near, number + 2 * len(self), -side * (weight * share).sum(1)))
        rows = np.concatenate([near for near, _, _ in entries])
        columns = np.concatenate([np.full(len(near), column) for near, column, _ in entries])
        values = np.concatenate([value for _, _, value in entries])
        used = values != 0
        return sparse.csr_array((values[used], (rows[used], columns[used])), shape=(len(places), self.unknowns))

    def nearest(self, positions: Array) -> tuple[NDArray[np.int64], Array]:
        """The hinge nearest to each position (N, 2), and its distance (N,)."""
        offset = positions[:, None] - self.ends[None, :, 0]
        onward = np.clip((offset * self.directions).sum(2), 0, self.lengths)
        distance = np.linalg.norm(offset - onward[..., None] * self.directions, axis=2)
        nearest = distance.argmin(1)
        return nearest, distance[np.arange(len(positions)), nearest]

    def moved(self, values: Array, limit: float) -> Hinges:
        """The hinges at the places given by their lifts; shared ends stay shared.

        Parameters
        ----------
        values : (unknowns,) array
            Of movable hinges.
        limit : float
            No end moves further.
        """
        turn, *lifts = values.reshape(3, -1)
        steady = np.where(np.abs(turn) < _LEAST_TURN, np.inf, turn)
        offset = np.stack([lift / steady for lift in lifts], axis=1).ravel()
        normal = np.repeat(self.normals, 2, axis=0)
        places, joint = np.unique(self.ends.reshape(-1, 2), axis=0, return_inverse=True)
        ends = places[joint.ravel()]
        for number in range(len(places)):
            here = np.flatnonzero(joint.ravel() == number)
            across = normal[here]
            inertia = _JOINT_INERTIA if len(here) > 1 else _INERTIA
            move = np.linalg.solve(across.T @ across + inertia * np.eye(2), across.T @ offset[here])
            ends[here] += move * min(1.0, limit / max(float(np.linalg.norm(move)), 1e-300))
        return Hinges(ends.reshape(-1, 2, 2), self.movable)

    def displacement(self, drawn: Hinges) -> Array:
        """Distance (2, K) of the first and last ends from those of the drawn hinges."""
        return ((self.ends - drawn.ends) * self.normals[:, None]).sum(2).T


NO_HINGES = Hinges(np.zeros((0, 2, 2)))
