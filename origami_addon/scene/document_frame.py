"""Where a document lies in Blender's space: the frame of its sheet, and of its sparse model until there is a sheet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.arrays import Array
from ...core.camera import Camera
from ...core.flat.distortion import measure_strain
from ...core.page.page_frame import rotation_to_page
from ...core.sheet import FlatMap, Sheet
from ...core.sparse_model import SparseModel
from .page_object import page_unit
from .sheet_mesh import transform

_NO_RIGHT = 1e-3  # length of the photos' mean direction to the right below which it has none


def document_frame(sheet: Sheet, flat: FlatMap) -> Array:
    """The similarity (4, 4) from the sparse model's frame to Blender's, in metres.

    It moves the sheet as close to its flat page as a rigid motion can: u along x, v against y, the printed side up, the
    page's middle over the origin and the sheet's lowest point on the ground.
    """
    target = on_ground(flat)
    unit = flat.world_scale or measure_strain(sheet.vertices, sheet.triangles, flat.uv).scale
    frame = np.eye(4)
    frame[:3, :3] = unit * page_unit(flat) * rotation_to_page(sheet, flat)
    frame[:3, 3] = target.mean(axis=0) - frame[:3, :3] @ sheet.vertices.mean(axis=0)
    frame[2, 3] -= transform(frame, sheet.vertices)[:, 2].min()
    return frame


def on_ground(flat: FlatMap) -> Array:
    """The flat sheet's vertices (V, 3) in Blender's frame: u along x, v against y, the page's middle at the origin."""
    across = (flat.uv - np.array([flat.width, flat.height]) / 2) * (1, -1)
    return np.column_stack([across, np.zeros(len(across))]) * page_unit(flat)


def first_frame(model: SparseModel) -> Array:
    """A similarity (4, 4) to Blender's frame while only the sparse model is known.

    The plane through the points is the ground, their middle is over the origin and the cameras are above; most of the
    points are within one unit.
    """
    middle = np.median(model.points, axis=0)
    near = model.points - middle
    distance = np.linalg.norm(near, axis=1)
    near = near[distance <= np.percentile(distance, 90)]
    axes = np.linalg.svd(near, full_matrices=False)[2]
    above = np.mean([camera.center for camera in model.cameras], axis=0) - middle
    up = axes[2] * np.sign(axes[2] @ above or 1)
    right = _across(model.cameras, up, axes[0])
    rotation = np.stack([right, np.cross(up, right), up])
    scale = 1 / np.ptp(near @ rotation.T, axis=0)[:2].max()
    frame = np.eye(4)
    frame[:3, :3] = scale * rotation
    frame[:3, 3] = -frame[:3, :3] @ middle
    return frame


def _across(cameras: Sequence[Camera], up: Array, otherwise: Array) -> Array:
    """Unit vector perpendicular to ``up`` that points right in most photos."""
    right = np.mean([camera.rotation[0] for camera in cameras], axis=0)
    right = right - (right @ up) * up
    if np.linalg.norm(right) < _NO_RIGHT:
        right = otherwise - (otherwise @ up) * up
    return right / np.linalg.norm(right)
