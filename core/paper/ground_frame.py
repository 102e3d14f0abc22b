"""The plane near the sheet onto which the scene is mapped, seen from straight above."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..sparse_model import SparseModel

# The values below are choices; no measurement of them is recorded.
# Random planes that are tried: with a third of the weight on the plane, 400 miss it once in three million times.
_TRIALS = 400
# Lengths relative to the points' median distance from their middle: points further off are left out; three points whose
# triangle has less than this area (twice, squared length) define no plane; and the distance from the plane that counts
# as on it. A point counts less until it is this many times as far off, in the search and in each round of refinement.
_FARTHEST, _LEAST_TRIANGLE, _TOLERANCE = 4, 1e-3, 0.01
_FOUND_WITHIN, _REFINED_WITHIN, _ROUNDS = 3, 4, 5
# If the cameras' rights cancel out to less than this for each, as of photos turned in a circle, any direction will do.
_NO_RIGHT = 1e-6


@dataclass(frozen=True)
class GroundFrame:
    """A plane near the sheet, with axes aligned with the photos.

    Attributes
    ----------
    origin : (3,) array
        World frame.
    axes : (3, 3) array
        Rows: right, down, and up off the plane towards the cameras; world frame, orthonormal.
    size : float
        Median distance of the photos' main points from the origin, world units.
    """

    origin: Array
    axes: Array
    size: float

    def from_world(self, points: Array) -> Array:
        """World points (..., 3) as right, down, height (..., 3)."""
        return (points - self.origin) @ self.axes.T

    def to_world(self, local: Array) -> Array:
        """Right, down, height (..., 3) as world points (..., 3)."""
        return local @ self.axes + self.origin


def ground_frame(model: SparseModel, weight: Array) -> GroundFrame:
    """The plane of most of the main points: that of the sheet, of its table, or the mean plane of a bent sheet."""
    used = weight > 0
    points, weight = model.points[used], weight[used] ** 2
    middle = np.array([_weighted_median(points[:, axis], weight) for axis in range(3)])
    size = _weighted_median(np.linalg.norm(points - middle, axis=1), weight)
    near = np.linalg.norm(points - middle, axis=1) < _FARTHEST * size
    points, weight = points[near], weight[near]
    tolerance = _TOLERANCE * size
    random = np.random.default_rng(0)
    chance = weight / weight.sum()
    running = np.cumsum(chance)
    origin, normal, most = middle, _normal(points - middle, chance), -1.0
    for _ in range(_TRIALS):
        first, second, third = points[np.searchsorted(running, random.random(3) * running[-1])]
        across = np.cross(second - first, third - first)
        length = float(np.linalg.norm(across))
        if length < _LEAST_TRIANGLE * size**2:
            continue
        off = (points - first) @ across / length
        on_plane = float(chance @ np.maximum(1 - (off / (_FOUND_WITHIN * tolerance)) ** 2, 0))
        if on_plane > most:
            origin, normal, most = first, across / length, on_plane
    for _ in range(_ROUNDS):
        off = (points - origin) @ normal
        trust = chance * np.maximum(1 - (off / (_REFINED_WITHIN * tolerance)) ** 2, 0) ** 2
        if (trust > 0).sum() < 3:
            break
        origin = trust @ points / trust.sum()
        normal = _normal(points - origin, trust)
    # the map's middle is where the photos are aimed, not where the table's grain happens to be rich
    origin = middle - ((middle - origin) @ normal) * normal
    towards = np.mean([camera.center for camera in model.cameras], axis=0) - origin
    normal = normal * np.sign(normal @ towards)
    right = sum(camera.rotation[0] for camera in model.cameras)
    right = right - (right @ normal) * normal
    if np.linalg.norm(right) < _NO_RIGHT * len(model.cameras):
        right = np.linalg.svd(normal[None])[2][1]
    right = right / np.linalg.norm(right)
    return GroundFrame(origin, np.stack([right, np.cross(right, normal), normal]), size)


def _normal(offsets: Array, weight: Array) -> Array:
    """The normal of the plane through the origin nearest to weighted points (N, 3)."""
    return np.asarray(np.linalg.svd(offsets * np.sqrt(weight)[:, None], full_matrices=False)[2][2])


def _weighted_median(values: Array, weight: Array) -> float:
    order = np.argsort(values)
    running = np.cumsum(weight[order])
    return float(values[order][np.searchsorted(running, 0.5 * running[-1])])


def footprint(camera: Camera, frame: GroundFrame) -> float:
    """Length that the photo's long side covers in the plane at the frame's origin, world units."""
    return float(np.linalg.norm(frame.origin - camera.center)) / camera.focal_length * max(camera.width, camera.height)
