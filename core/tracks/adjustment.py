"""Cameras adjusted to tracks: the pose of each, and a change of lens that all share.

Bundle adjustment (B. Triggs et al., "Bundle adjustment - a modern synthesis", 2000): Gauss and Newton's method on the
cameras alone, each point having been eliminated, with Cauchy's weights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..arrays import Array
from ..camera import Camera
from .triangulation import linear_points, observation_weight, scatter

# Standard deviations of the change of lens that is expected: of the focal length and of both coordinates of the
# principal point, in parts of the focal length, and of k1 and k2. The principal points of phones lie 5 to 20 pixels of
# 2700 off the middle, and their k2 is -.08 to -.15, where the lens of structure from motion has none. On sets IV and
# XII the page is .82 and .76 px off without tracks, .87 and .75 with the principal point held, .75 and .60 with .003,
# .70 and .61 with .01.
_LENS_CHANGE = np.array([0.02, 0.005, 0.005, 0.1, 0.2])
# So many observations count as one against these: what moves a place moves its neighbours too.
_SHARED = 30.0
_ROUNDS = 10
_DAMPING = 1e-7
_LENS, _POSE = 5, 6


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
    unknowns = _LENS + _POSE * len(cameras)
    lens = np.zeros(_LENS)
    deviation = 1.0
    for round_ in range(_ROUNDS):
        off, by_camera, by_point = _linearized(cameras, points, observed)
        off[~seen] = 0
        length = np.linalg.norm(off, axis=2)
        if round_:
            deviation = scatter(length[seen])
        weight = seen * observation_weight(length, deviation)
        normal = np.einsum("nkri,nk,nkrj->nij", by_point, weight, by_point, optimize=True)
        normal += 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        inverse = np.linalg.inv(normal)
        of_points = np.einsum("nkri,nk,nkr->ni", by_point, weight, off, optimize=True)
        system, right = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
        cross = np.zeros((len(points), unknowns, 3))
        for k in range(len(cameras)):
            own = np.r_[:_LENS, _LENS + k * _POSE : _LENS + (k + 1) * _POSE]
            weighted = by_camera[:, k] * weight[:, k, None, None]
            flat = weighted.reshape(-1, len(own))
            system[np.ix_(own, own)] += flat.T @ by_camera[:, k].reshape(-1, len(own))
            right[own] += flat.T @ off[:, k].ravel()
            cross[:, own] += weighted.transpose(0, 2, 1) @ by_point[:, k]
        eliminated = (cross @ inverse).transpose(1, 0, 2).reshape(unknowns, -1)
        system -= eliminated @ cross.transpose(1, 0, 2).reshape(unknowns, -1).T
        right -= eliminated @ of_points.ravel()
        # in the unit of the observations' weights, which leave out their deviation
        expected = _SHARED * deviation**2 / _LENS_CHANGE**2
        system[range(_LENS), range(_LENS)] += expected
        right[:_LENS] += expected * lens
        # poses can move and grow all together at no cost
        system[range(unknowns), range(unknowns)] *= 1 + _DAMPING
        step = -np.linalg.solve(system, right)
        lens += step[:_LENS]
        points = points - np.einsum("nij,nj->ni", inverse, of_points + np.einsum("ncj,c->nj", cross, step))
        poses = step[_LENS:].reshape(-1, _POSE)
        cameras = tuple(_moved(camera, step[:_LENS], pose) for camera, pose in zip(cameras, poses, strict=True))
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
    lens, deviation = np.zeros(_LENS), 1.0
    for round_ in range(_ROUNDS):
        off, by_camera, _ = _linearized([camera], points, observed[:, None])
        length = np.linalg.norm(off, axis=2)
        if round_:
            deviation = scatter(length)
        slopes = by_camera.reshape(-1, _LENS + _POSE)
        weighted = slopes * np.repeat(observation_weight(length, deviation), 2)[:, None]
        system, right = weighted.T @ slopes, weighted.T @ off.ravel()
        expected = _SHARED * deviation**2 / _LENS_CHANGE**2
        system[range(_LENS), range(_LENS)] += expected
        right[:_LENS] += expected * lens
        system[range(len(system)), range(len(system))] *= 1 + _DAMPING
        step = -np.linalg.solve(system, right)
        lens += step[:_LENS]
        camera = _moved(camera, step[:_LENS], step[_LENS:])
    return camera


def _linearized(cameras: Sequence[Camera], points: Array, observed: Array) -> tuple[Array, Array, Array]:
    """How far off the projections are (N, C, 2), their slopes by lens and pose (..., 11), and by the point (..., 3)."""
    shape = len(points), len(cameras), 2
    off, by_camera, by_point = np.empty(shape), np.empty((*shape, _LENS + _POSE)), np.empty((*shape, 3))
    for k, camera in enumerate(cameras):
        turned = points @ camera.rotation.T
        in_camera = turned + camera.translation
        depth = in_camera[:, 2]
        image = in_camera[:, :2] / depth[:, None]
        r2 = (image**2).sum(axis=1)
        k1, k2 = camera.distortion
        growth, focal = 1 + k1 * r2 + k2 * r2**2, camera.focal_length
        off[:, k] = image * growth[:, None] * focal + camera.principal_point - observed[:, k]
        by_image = focal * (
            growth[:, None, None] * np.eye(2)
            + 2 * (k1 + 2 * k2 * r2)[:, None, None] * image[:, :, None] * image[:, None, :]
        )
        image_by_frame = np.zeros((len(points), 2, 3))
        image_by_frame[:, 0, 0] = image_by_frame[:, 1, 1] = 1 / depth
        image_by_frame[:, :, 2] = -image / depth[:, None]
        by_frame = by_image @ image_by_frame
        by_point[:, k] = by_frame @ camera.rotation
        x, y, z = turned.T
        zero = np.zeros_like(x)
        by_turn = np.stack([zero, z, -y, -z, zero, x, y, -x, zero], axis=1).reshape(-1, 3, 3)
        of_lens = np.zeros((len(points), 2, _LENS))
        of_lens[:, :, 0] = image * growth[:, None]
        of_lens[:, 0, 1] = of_lens[:, 1, 2] = 1
        of_lens[:, :, 3] = image * r2[:, None]
        of_lens[:, :, 4] = image * r2[:, None] ** 2
        by_camera[:, k] = np.concatenate([focal * of_lens, by_frame @ by_turn, by_frame], axis=2)
    return off, by_camera, by_point


def _moved(camera: Camera, lens: Array, pose: Array) -> Camera:
    """The camera with its lens changed, its focal length in parts, and turned and moved in its own frame."""
    return replace(
        camera,
        focal_length=camera.focal_length * (1 + lens[0]),
        principal_point=camera.principal_point + camera.focal_length * lens[1:3],
        distortion=camera.distortion + lens[3:],
        rotation=Rotation.from_rotvec(pose[:3]).as_matrix() @ camera.rotation,
        translation=camera.translation + pose[3:],
    )
