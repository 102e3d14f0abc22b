"""The map of a sheet that is as rigid as possible (Liu et al. 2008)."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..arrays import Array, Indices
from ..numeric.triangles import areas, gradient_rows
from ..sheet import Sheet
from ..watch import SILENT, Watch
from .pins import HeldSystem, Pins
from .settle import settle
from .straight_lines import collinearity_rows

_MOST_ITERATIONS = 60  # a choice; they end earlier once the map has settled


def as_rigid_as_possible(
    sheet: Sheet, start: Array, lines: list[Indices], watch: Watch = SILENT, *, pins: Pins | None = None
) -> Array:
    """Minimise ``sum_t area_t |J_t - R_t|^2`` over maps J and rotations R (Liu et al. 2008).

    Parameters
    ----------
    sheet : Sheet
        Of about unit area.
    start : (V, 2) array
        A flat map without flips.
    lines : list of int arrays
        Runs of vertices that should become straight.
    watch : Watch
    pins : Pins, optional
        Two or more, u right, v up.

    Returns
    -------
    flat : (V, 2) array
        u right, v up.
    """
    area = areas(sheet.vertices, sheet.triangles)
    along_x, along_y = gradient_rows(sheet.vertices, sheet.triangles)
    gradient = sparse.vstack([along_x, along_y], format="csr")
    weight = np.concatenate([area, area]) / area.mean()
    stiffness = gradient.T @ gradient.multiply(weight[:, None])
    straight = collinearity_rows(start, lines)
    matrix = sparse.block_diag([stiffness, stiffness]) + straight.T @ straight
    held = np.zeros(0, np.int64) if pins is None else np.concatenate([pins.vertices, pins.vertices + len(start)])
    values = np.zeros(0) if pins is None else pins.uv.T.ravel()
    system = HeldSystem(matrix, held)

    def turn(flat: Array) -> Array:
        rotation = _nearest_rotations(along_x @ flat, along_y @ flat)
        right = (gradient.T @ (weight[:, None] * rotation)).T.ravel()
        return system.solve(right, values).reshape(2, -1).T

    return settle(start, turn, _MOST_ITERATIONS, watch, centred=pins is None)


def _nearest_rotations(along_x: Array, along_y: Array) -> Array:
    """Closest rotation to each Jacobian, stacked like its rows: images of the x axes, then of the y axes (2F, 2)."""
    cosine = along_x[:, 0] + along_y[:, 1]
    sine = along_x[:, 1] - along_y[:, 0]
    length = np.hypot(cosine, sine) + 1e-300
    cosine, sine = cosine / length, sine / length
    return np.concatenate([np.stack([cosine, sine], 1), np.stack([-sine, cosine], 1)])
