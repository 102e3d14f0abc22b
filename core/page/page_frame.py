"""The rotation between a sheet in space and its flat page."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from ..arrays import Array
from ..sheet import FlatMap, Sheet


def rotation_to_page(sheet: Sheet, flat: FlatMap) -> Array:
    """The rotation (3, 3) that brings the sheet as close to its flat page as a rigid motion can.

    It leads from the world frame to the page's: u along x, v against y, z up from the printed side.
    """
    target = np.column_stack([flat.uv * (1, -1), np.zeros(len(flat.uv))])
    rotation, _ = Rotation.align_vectors(target - target.mean(axis=0), sheet.vertices - sheet.vertices.mean(axis=0))
    return np.asarray(rotation.as_matrix())
