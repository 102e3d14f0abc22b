"""Shapes of a sheet on its way from folded to flat: all bends open together, and hardly any length changes.

A straight blend between the two would shorten the paper: by 29 % half-way through a fold of 90 degrees. So the turn of
the paper from each triangle to the next is scaled instead (as Winkler et al. 2010 do with dihedral angles), the
triangles' rotations are those that agree best with all turns, and the vertices those that agree best with the
rotations. Where folds cross, turns scaled alike do not close around the crossing, and a few rounds of
as-rigid-as-possible spread what is left.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse
from scipy.spatial.transform import Rotation

from ..arrays import Array, Indices
from ..numeric.triangles import areas, gradient_rows, triangle_pairs
from ..watch import SILENT, Watch
from .pins import HeldSystem

# The most rounds in which the rotations come to agree, which end once no triangle turns by more than this, in radians.
_TURN_ROUNDS = 20
_TOLERANCE = 1e-4
# Rounds of as-rigid-as-possible: on four folds that cross, 5 rounds took the largest stretch from .056 to .017 %.
_RIGID_ROUNDS = 5
# Smallest area of a triangle whose place is sought, as a share of what its sides would span: avoids a division by zero.
_THIN = 1e-9
# Any one triangle and vertex, held while the others are found.
_HELD = np.zeros(1, np.int64)


def unfolded(folded: Array, flat: Array, triangles: Indices, shares: Sequence[float], watch: Watch = SILENT) -> Array:
    """The sheet, opened by each of some shares.

    Parameters
    ----------
    folded : (V, 3) array
        On the ground, which is z = 0: its lowest vertex has this height.
    flat : (V, 3) array
        The same sheet flat on the ground, in the same unit, as near to ``folded`` as a rigid motion brings it.
    triangles : (F, 3) int array
        Counter-clockwise as seen from the printed side, which is up in ``flat``; one part, none without area.
    shares : sequence of K floats
        0 is folded, 1 is flat.
    watch : Watch

    Returns
    -------
    (K, V, 3) array
        Each as near as a rigid motion brings it to the straight blend of ``folded`` and ``flat``, on the ground.
    """
    along = gradient_rows(folded, triangles)
    frames, _ = _frames(along, folded)
    flat_frames, flat_stretch = _frames(along, flat)
    turns = _Turns(frames @ flat_frames.swapaxes(1, 2), folded, triangles)
    positions = _Positions(along, areas(folded, triangles))
    shapes = np.empty((len(shares), *folded.shape))
    rotations = np.broadcast_to(np.eye(3), frames.shape)
    for step, index in enumerate(np.argsort(shares)[::-1]):  # from the flat sheet, whose triangles are not turned
        watch.step(step / len(shares), "Unfolding the sheet")
        share = shares[index]
        rotations = turns.rotations(1 - share, rotations)
        stretch = (1 - share) * np.eye(2) + share * flat_stretch
        shape = positions.of(rotations @ flat_frames, stretch)
        for _ in range(_RIGID_ROUNDS):
            shape = positions.of(_frames(along, shape)[0], stretch)
        shapes[index] = _placed(shape, (1 - share) * folded + share * flat)
    return shapes


class _Turns:
    """How the paper turns from each triangle to the next.

    Parameters
    ----------
    rotations : (F, 3, 3) array
        From each triangle on the flat page to the same on the folded sheet.
    folded : (V, 3) array
    triangles : (F, 3) int array
    """

    def __init__(self, rotations: Array, folded: Array, triangles: Indices) -> None:
        edges, self._pairs = triangle_pairs(triangles)
        one, other = self._pairs.T
        self._turns = Rotation.from_matrix(rotations[one].swapaxes(1, 2) @ rotations[other]).as_rotvec()
        # A bend costs as much over long edges as over many short ones, and the less the farther apart the middles.
        ends, middles = folded[edges], folded[triangles].mean(axis=1)
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        weight = length / np.linalg.norm(middles[other] - middles[one], axis=1)
        rows = np.arange(len(edges))
        ones = np.ones(len(edges))
        shape = (len(edges), len(triangles))
        across = sparse.csr_array((ones, (rows, other)), shape) - sparse.csr_array((ones, (rows, one)), shape)
        self._weighted = across.multiply(weight[:, None]).tocsr()
        self._system = HeldSystem((across.T @ self._weighted).tocsr(), _HELD)

    def rotations(self, share: float, start: Array) -> Array:
        """The rotations (F, 3, 3) that agree best with a share of all turns, from a start near them."""
        one, other = self._pairs.T
        turns = Rotation.from_rotvec(share * self._turns).as_matrix()
        rotations = start
        for _ in range(_TURN_ROUNDS):
            missing = Rotation.from_matrix(rotations[one] @ turns @ rotations[other].swapaxes(1, 2)).as_rotvec()
            more = self._system.solve(self._weighted.T @ missing, np.zeros((1, 3)))
            rotations = Rotation.from_rotvec(more).as_matrix() @ rotations
            if np.abs(more).max() < _TOLERANCE:
                break
        return rotations


class _Positions:
    """The vertices that agree best with where their triangles face.

    Parameters
    ----------
    along : tuple of two (F, V) sparse arrays
        As from `gradient_rows`.
    area : (F,) array
        Of each triangle.
    """

    def __init__(self, along: tuple[sparse.csr_array, sparse.csr_array], area: Array) -> None:
        gradient = sparse.vstack(along, format="csr")
        self._weighted = gradient.multiply(np.tile(area, 2)[:, None]).tocsr()
        self._system = HeldSystem((gradient.T @ self._weighted).tocsr(), _HELD)

    def of(self, frames: Array, stretch: Array) -> Array:
        """Vertices (V, 3) for the triangles' frames (F, 3, 3) and stretches in their own plane (F, 2, 2)."""
        sides = frames[:, :, :2] @ stretch
        return self._system.solve(self._weighted.T @ np.concatenate([sides[:, :, 0], sides[:, :, 1]]), np.zeros((1, 3)))


def _frames(along: tuple[sparse.csr_array, sparse.csr_array], vertices: Array) -> tuple[Array, Array]:
    """Where each triangle's own axes and normal point (F, 3, 3), and its stretch along these axes (F, 2, 2)."""
    sides = np.stack([rows @ vertices for rows in along], axis=2)
    # The square root of a symmetric two by two matrix in closed form: an SVD of each triangle took most of the time.
    square = sides.swapaxes(1, 2) @ sides
    trace = square[:, 0, 0] + square[:, 1, 1]
    area = np.sqrt(np.maximum(np.linalg.det(square), (_THIN * trace) ** 2))
    stretch = (square + area[:, None, None] * np.eye(2)) / np.sqrt(trace + 2 * area)[:, None, None]
    plane = sides @ np.linalg.inv(stretch)
    normal = np.cross(plane[:, :, 0], plane[:, :, 1])
    return np.concatenate([plane, normal[:, :, None]], axis=2), stretch


def _placed(shape: Array, beside: Array) -> Array:
    """A shape moved rigidly as near as possible to another (V, 3), and then up or down onto the ground."""
    middle, target = shape.mean(axis=0), beside.mean(axis=0)
    rotation, _ = Rotation.align_vectors(beside - target, shape - middle)
    placed = (shape - middle) @ rotation.as_matrix().T + target
    placed[:, 2] -= placed[:, 2].min()
    return np.asarray(placed)
