"""The normal equations of cameras and points, with the points eliminated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..arrays import Array
from ..camera import Camera

LENS, POSE = 5, 6  # unknowns
# Standard deviations of the change of lens that is expected: of the focal length and of both coordinates of the
# principal point, in parts of the focal length, and of k1 and k2. The principal points of phones lie 5 to 20 pixels of
# 2700 off the middle, and their k2 is -.08 to -.15, where the lens of structure from motion has none. On sets IV and
# XII the page is .82 and .76 px off without tracks, .87 and .75 with the principal point held, .75 and .60 with .003,
# .70 and .61 with .01.
LENS_CHANGE = np.array([0.02, 0.005, 0.005, 0.1, 0.2])
# This many observations count as one against these: what moves a place moves its neighbours too. A choice.
_SHARED = 30.0
# On the diagonal of a point's own equations, as a share of their trace and at least: a point that no photo sees, or all
# see from one direction, stays where it is.
_POINT_RIDGE, _LEAST_RIDGE = 1e-9, 1e-12


@dataclass(frozen=True)
class Equations:
    """What observations say about a change of the lens that all cameras share, their poses and the points.

    The unknowns of the cameras are the change of the lens (5,) and the change of each pose (6,), in the frame of that
    camera; see `moved`.

    Attributes
    ----------
    by_camera : (N, C, 2, 11) array
        Slopes of the projections by the lens and the camera's own pose.
    by_point : (N, C, 2, 3) array
        Slopes by the point.
    weight : (N, C) array
        0 where a point is not seen.
    inverse : (N, 3, 3) array
        Of each point's own equations.
    cross : (N, U, 3) array
        Between the cameras' unknowns and each point.
    system : (U, U) array
        Of the cameras alone, without what is expected of the lens.
    """

    by_camera: Array
    by_point: Array
    weight: Array
    inverse: Array
    cross: Array
    system: Array

    @classmethod
    def of(cls, by_camera: Array, by_point: Array, weight: Array) -> Equations:
        count, views = weight.shape
        unknowns = LENS + POSE * views
        normal = np.einsum("nkri,nk,nkrj->nij", by_point, weight, by_point, optimize=True)
        inverse = np.linalg.inv(determined(normal))
        system, cross = np.zeros((unknowns, unknowns)), np.zeros((count, unknowns, 3))
        for k in range(views):
            own = own_unknowns(k)
            weighted = by_camera[:, k] * weight[:, k, None, None]
            system[np.ix_(own, own)] += weighted.reshape(-1, len(own)).T @ by_camera[:, k].reshape(-1, len(own))
            cross[:, own] += weighted.transpose(0, 2, 1) @ by_point[:, k]
        eliminated = (cross @ inverse).transpose(1, 0, 2).reshape(unknowns, -1)
        system -= eliminated @ cross.transpose(1, 0, 2).reshape(unknowns, -1).T
        # a photo that shows none of the points stays where it is
        system[range(unknowns), range(unknowns)] += np.diagonal(system) == 0
        return cls(by_camera, by_point, weight, inverse, cross, system)

    def right(self, off: Array) -> tuple[Array, Array]:
        """The right sides for observations that are ``off`` (N, C, 2): of each point (N, 3), of the cameras (U,)."""
        of_points = np.einsum("nkri,nk,nkr->ni", self.by_point, self.weight, off, optimize=True)
        of_cameras = np.zeros(len(self.system))
        for k in range(self.weight.shape[1]):
            weighted = self.by_camera[:, k] * self.weight[:, k, None, None]
            of_cameras[own_unknowns(k)] += np.einsum("nri,nr->i", weighted, off[:, k])
        through_points = np.einsum("nij,nj->ni", self.inverse, of_points)
        return of_points, of_cameras - np.einsum("nui,ni->u", self.cross, through_points, optimize=True)

    def of_points(self, of_points: Array, step: Array) -> Array:
        """The points' steps (N, 3) that go with the cameras' ``step`` (U,)."""
        along = of_points + np.einsum("nui,u->ni", self.cross, step, optimize=True)
        return -np.einsum("nij,nj->ni", self.inverse, along)


def determined(normal: Array) -> Array:
    """Normal equations (N, 3, 3) of points, with so little on their diagonal that each has a solution."""
    size = _POINT_RIDGE * np.trace(normal, axis1=1, axis2=2)[:, None, None]
    return np.asarray(normal + (size * np.eye(3) + _LEAST_RIDGE * np.eye(3)))


def own_unknowns(camera: int) -> Array:
    """The unknowns of one camera: the lens and its pose."""
    return np.r_[:LENS, LENS + camera * POSE : LENS + (camera + 1) * POSE]


def expected_lens(deviation: float) -> Array:
    """Weights (5,) of the lens' changes against observations of weight 1 with this deviation, pixels."""
    return np.asarray(_SHARED * deviation**2 / LENS_CHANGE**2)


def linearized(cameras: Sequence[Camera], points: Array, observed: Array) -> tuple[Array, Array, Array]:
    """How far off the projections are (N, C, 2), their slopes by lens and pose (..., 11), and by the point (..., 3)."""
    shape = len(points), len(cameras), 2
    off, by_camera, by_point = np.empty(shape), np.empty((*shape, LENS + POSE)), np.empty((*shape, 3))
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
        of_lens = np.zeros((len(points), 2, LENS))
        of_lens[:, :, 0] = image * growth[:, None]
        of_lens[:, 0, 1] = of_lens[:, 1, 2] = 1
        of_lens[:, :, 3] = image * r2[:, None]
        of_lens[:, :, 4] = image * r2[:, None] ** 2
        by_camera[:, k] = np.concatenate([focal * of_lens, by_frame @ by_turn, by_frame], axis=2)
    return off, by_camera, by_point


def moved(camera: Camera, lens: Array, pose: Array) -> Camera:
    """The camera with its lens changed, its focal length in parts, and turned and moved in its own frame."""
    return replace(
        camera,
        focal_length=camera.focal_length * (1 + lens[0]),
        principal_point=camera.principal_point + camera.focal_length * lens[1:3],
        distortion=camera.distortion + lens[3:],
        rotation=Rotation.from_rotvec(pose[:3]).as_matrix() @ camera.rotation,
        translation=camera.translation + pose[3:],
    )
