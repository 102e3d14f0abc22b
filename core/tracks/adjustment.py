"""Cameras and points adjusted together to dense tracks: poses, and a lens with a little freedom for each photo.

Bundle adjustment as B. Triggs et al., "Bundle adjustment - a modern synthesis" (2000): Gauss and Newton's method on the
cameras alone, each point having been eliminated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..arrays import Array
from ..camera import Camera
from .triangulation import HALF_WEIGHT, MEDIAN_LENGTH, linear_points

_ROUNDS = 10
_LEAST_DEVIATION = 0.02
_DAMPING = 1e-7
_POSE, _LENS = 6, 5
_OF_CAMERA = _LENS + _POSE + _LENS


@dataclass(frozen=True)
class LensFreedom:
    """Standard deviations of what a lens may differ by, of all photos together and of each photo besides.

    Attributes
    ----------
    shared, own : (5,) tuples
        Of the focal length and the principal point's x and y (in parts of the focal length), k1 and k2; 0 holds it.
    observations : float
        So many observations count as one: neighbours share what moved them.
    """

    shared: tuple[float, ...] = (0.02, 0.01, 0.01, 0.1, 0.2)
    own: tuple[float, ...] = (0.001, 0.002, 0.002, 0.002, 0.004)
    observations: float = 30.0


@dataclass(frozen=True)
class Adjusted:
    cameras: tuple[Camera, ...]
    points: Array
    deviation: float


def adjust(cameras: Sequence[Camera], observed: Array, freedom: LensFreedom, points: Array | None = None) -> Adjusted:
    cameras = tuple(cameras)
    seen = np.isfinite(observed[..., 0])
    if points is None:
        points = linear_points(cameras, observed)
    count = len(cameras)
    merge = _merged(count)
    prior = np.concatenate([_precision(freedom.shared), *[np.concatenate([np.zeros(_POSE), _precision(freedom.own)])] * count])
    free = prior < np.inf
    at = np.zeros(len(prior))
    deviation = 1.0
    for round_ in range(_ROUNDS):
        off, by_camera, by_point = _linearized(cameras, points, observed)
        off[~seen] = 0
        length = np.linalg.norm(off, axis=2)
        if round_:
            deviation = max(float(np.median(length[seen])) / MEDIAN_LENGTH, _LEAST_DEVIATION)
        weight = seen / (1 + (length / (HALF_WEIGHT * deviation)) ** 2) / deviation**2 / freedom.observations
        point = np.einsum("nkri,nk,nkrj->nij", by_point, weight, by_point, optimize=True)
        point += 1e-9 * np.trace(point, axis1=1, axis2=2)[:, None, None] * np.eye(3) + 1e-30 * np.eye(3)
        right_point = np.einsum("nkri,nk,nkr->ni", by_point, weight, off, optimize=True)
        cross = np.einsum("nkrc,nk,nkrj->nkcj", by_camera, weight, by_point, optimize=True).reshape(len(points), -1, 3)
        inverse = np.linalg.inv(point)
        solved = cross @ inverse
        whole = np.zeros((count * _OF_CAMERA,) * 2)
        right = np.zeros(count * _OF_CAMERA)
        for k in range(count):
            own = slice(k * _OF_CAMERA, (k + 1) * _OF_CAMERA)
            slope = by_camera[:, k].reshape(-1, _OF_CAMERA)
            scaled = slope * np.repeat(weight[:, k], 2)[:, None]
            whole[own, own] = scaled.T @ slope
            right[own] = scaled.T @ off[:, k].ravel()
        columns = cross.transpose(1, 0, 2).reshape(count * _OF_CAMERA, -1)
        whole -= solved.transpose(1, 0, 2).reshape(count * _OF_CAMERA, -1) @ columns.T
        right -= np.einsum("nci,ni->c", solved, right_point)
        system = merge.T @ whole @ merge
        target = merge.T @ right + np.where(free, prior, 0) * at
        system += np.diag(np.where(free, prior, 0) + _DAMPING * system.diagonal() + 1e-12)
        step = np.zeros(len(prior))
        step[free] = -np.linalg.solve(system[np.ix_(free, free)], target[free])
        at += step
        change = (merge @ step).reshape(count, _OF_CAMERA)
        points = points - np.einsum(
            "nij,nj->ni", inverse, right_point + np.einsum("ncj,c->nj", cross, change.ravel())
        )
        cameras = tuple(_moved(camera, each) for camera, each in zip(cameras, change, strict=True))
    return Adjusted(cameras, points, deviation)


def _precision(deviations: Sequence[float]) -> Array:
    with np.errstate(divide="ignore"):
        return np.asarray(1 / np.asarray(deviations) ** 2)


def _merged(count: int) -> Array:
    """From the unknowns (shared lens, then pose and own lens of each camera) to each camera's sixteen."""
    own = _POSE + _LENS
    merge = np.zeros((count, _OF_CAMERA, _LENS + count * own))
    for k in range(count):
        merge[k, :_LENS, :_LENS] = np.eye(_LENS)
        merge[k, _LENS:, _LENS + k * own : _LENS + (k + 1) * own] = np.eye(own)
    return merge.reshape(count * _OF_CAMERA, -1)


def _linearized(cameras: Sequence[Camera], points: Array, observed: Array) -> tuple[Array, Array, Array]:
    """What the cameras see less what was observed (N, C, 2), and its slopes by the cameras and by the points."""
    count = len(points)
    off = np.empty((count, len(cameras), 2))
    by_camera = np.empty((count, len(cameras), 2, _OF_CAMERA))
    by_point = np.empty((count, len(cameras), 2, 3))
    for k, camera in enumerate(cameras):
        turned = points @ camera.rotation.T
        in_camera = turned + camera.translation
        x, y, depth = in_camera.T
        u, v = x / depth, y / depth
        k1, k2 = camera.distortion
        r2 = u * u + v * v
        grow = 1 + k1 * r2 + k2 * r2**2
        f = camera.focal_length
        off[:, k] = np.stack([u, v], 1) * grow[:, None] * f + camera.principal_point - observed[:, k]
        slope = 2 * (k1 + 2 * k2 * r2)
        of_image = f * np.stack([np.stack([grow + u * u * slope, u * v * slope], 1), np.stack([u * v * slope, grow + v * v * slope], 1)], 1)
        of_frame = np.zeros((count, 2, 3))
        of_frame[:, 0, 0] = of_frame[:, 1, 1] = 1 / depth
        of_frame[:, 0, 2], of_frame[:, 1, 2] = -u / depth, -v / depth
        by_frame = of_image @ of_frame
        by_point[:, k] = by_frame @ camera.rotation
        skew = np.zeros((count, 3, 3))
        skew[:, 0, 1], skew[:, 0, 2], skew[:, 1, 2] = turned[:, 2], -turned[:, 1], turned[:, 0]
        skew -= skew.transpose(0, 2, 1)
        lens = np.zeros((count, 2, _LENS))
        image = np.stack([u, v], 1)
        lens[:, :, 0] = image * grow[:, None] * f
        lens[:, 0, 1] = lens[:, 1, 2] = f
        lens[:, :, 3] = image * r2[:, None] * f
        lens[:, :, 4] = image * (r2**2)[:, None] * f
        by_camera[:, k] = np.concatenate([lens, by_frame @ skew, by_frame, lens], axis=2)
    return off, by_camera, by_point


def _moved(camera: Camera, change: Array) -> Camera:
    lens = change[:_LENS] + change[_LENS + _POSE :]
    rotation, translation = change[_LENS : _LENS + 3], change[_LENS + 3 : _LENS + _POSE]
    return replace(
        camera,
        focal_length=camera.focal_length * (1 + lens[0]),
        principal_point=camera.principal_point + camera.focal_length * lens[1:3],
        distortion=camera.distortion + lens[3:],
        rotation=Rotation.from_rotvec(rotation).as_matrix() @ camera.rotation,
        translation=camera.translation + translation,
    )
