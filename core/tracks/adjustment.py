"""Cameras adjusted to tracks: the pose of each, and a change of lens that all share.

Bundle adjustment (B. Triggs et al., "Bundle adjustment - a modern synthesis", 2000): Gauss and Newton's method on the
cameras alone, each point having been eliminated, with Cauchy's weights.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..numeric.robust import observation_weight
from .equations import LENS, POSE, Equations, expected_lens, linearized, moved
from .triangulation import linear_points, scatter

_ROUNDS = 10  # of linearising and reweighting; a choice
# Added to the diagonal, as a share of it: so little that it only decides how poses move and grow all together.
_DAMPING = 1e-7


def adjust(cameras: Sequence[Camera], observed: Array) -> tuple[Camera, ...]:
    """The cameras that suit the tracks best.

    One lens for all photos: on real photos each photo's own freedom bends the page (set IV: 1.07 px off, .70 with one
    change of lens for all, .92 with the poses alone).

    Parameters
    ----------
    cameras : sequence of Camera
        To begin with.
    observed : (N, C, 2) array
        Distorted pixels of the tracks; NaN where a photo does not show one.
    """
    cameras = tuple(cameras)
    seen = np.isfinite(observed[..., 0])
    points = linear_points(cameras, observed)
    lens = np.zeros(LENS)
    deviation = 1.0
    for round_ in range(_ROUNDS):
        off, by_camera, by_point = linearized(cameras, points, observed)
        off[~seen] = 0
        length = np.linalg.norm(off, axis=2)
        if round_:
            deviation = scatter(length[seen])
        equations = Equations.of(by_camera, by_point, seen * observation_weight(length, deviation))
        of_points, right = equations.right(off)
        # in the unit of the observations' weights, which leave out their deviation
        expected, system = expected_lens(deviation), equations.system.copy()
        system[range(LENS), range(LENS)] += expected
        right[:LENS] += expected * lens
        # poses can move and grow all together at no cost
        system[range(len(system)), range(len(system))] *= 1 + _DAMPING
        step = -np.linalg.solve(system, right)
        lens += step[:LENS]
        points = points + equations.of_points(of_points, step)
        poses = step[LENS:].reshape(-1, POSE)
        cameras = tuple(moved(camera, step[:LENS], pose) for camera, pose in zip(cameras, poses, strict=True))
    return cameras


def resect(camera: Camera, points: Array, observed: Array) -> Camera:
    """The camera that suits points that are known best: its pose, and a change of its lens as for `adjust`.

    Parameters
    ----------
    camera : Camera
        To begin with.
    points : (N, 3) array
    observed : (N, 2) array
        Where it sees them, distorted pixels.
    """
    lens, deviation = np.zeros(LENS), 1.0
    for round_ in range(_ROUNDS):
        off, by_camera, _ = linearized([camera], points, observed[:, None])
        length = np.linalg.norm(off, axis=2)
        if round_:
            deviation = scatter(length)
        slopes = by_camera.reshape(-1, LENS + POSE)
        weighted = slopes * np.repeat(observation_weight(length, deviation), 2)[:, None]
        system, right = weighted.T @ slopes, weighted.T @ off.ravel()
        expected = expected_lens(deviation)
        system[range(LENS), range(LENS)] += expected
        right[:LENS] += expected * lens
        system[range(len(system)), range(len(system))] *= 1 + _DAMPING
        step = -np.linalg.solve(system, right)
        lens += step[:LENS]
        camera = moved(camera, step[:LENS], step[LENS:])
    return camera
