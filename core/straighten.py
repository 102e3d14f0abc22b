"""Straight sides for the page.

Outside the outermost print no point holds the surface, so the margins of a flat map wave. A sheet with four corners is
a rectangle of paper: its edge is moved onto one, and the correction fades out within the margin.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from .camera import Array
from .pins import HeldSystem
from .sheet import Indices, Sheet
from .sides import sides
from .triangles import areas, gradient_rows

# Over this distance, in page lengths, the correction fades to a third: as wide as common margins.
_FADE = 0.03
# A side nine tenths of which do not keep to this (page lengths) is torn, or no side at all, and stays as it is; a
# corner may flare by more.
_MOST_WAVE = 0.02


def straighten_sides(sheet: Sheet, uv: Array) -> Array:
    """Move the four sides onto lines along the axes, and the paper near them along with them.

    Parameters
    ----------
    sheet : Sheet
    uv : (V, 2) array
        Flat coordinates with the sides lying roughly along the axes.

    Returns
    -------
    (V, 2) array
        The same map where the sheet does not show four fairly straight sides.
    """
    runs = sides(sheet)
    length = float(np.ptp(uv, axis=0).max())
    fixed: tuple[list[Indices], list[Indices]] = ([], [])
    moves: tuple[list[Array], list[Array]] = ([], [])
    for run in runs:
        axis = 0 if np.ptp(uv[run, 1]) > np.ptp(uv[run, 0]) else 1
        move = np.median(uv[run, axis]) - uv[run, axis]
        if np.percentile(np.abs(move), 90) > _MOST_WAVE * length:
            return uv
        fixed[axis].append(run)
        moves[axis].append(move)
    if [len(lines) for lines in fixed] != [2, 2]:
        return uv
    stiffness = _fading(sheet, uv, _FADE * length)
    correction = [
        _spread(stiffness, np.concatenate(fixed[axis]), np.concatenate(moves[axis]), len(uv)) for axis in (0, 1)
    ]
    return uv + np.stack(correction, axis=1)


def _fading(sheet: Sheet, uv: Array, distance: float) -> sparse.csr_array:
    """Quadratic form of ``|grad f|^2 + f^2 / distance^2`` over the flat map."""
    flat = np.column_stack([uv, np.zeros(len(uv))])
    area = areas(flat, sheet.triangles)
    gradient = sparse.vstack(gradient_rows(flat, sheet.triangles), format="csr")
    mass = np.bincount(sheet.triangles.ravel(), weights=area.repeat(3) / 3, minlength=len(uv))
    stretch = gradient.T @ gradient.multiply(np.concatenate([area, area])[:, None])
    return (stretch + sparse.diags_array(mass / distance**2)).tocsr()


def _spread(form: sparse.csr_array, fixed: Indices, values: Array, count: int) -> Array:
    """The function with given values at some vertices that makes a quadratic form least."""
    fixed, first = np.unique(fixed, return_index=True)
    return HeldSystem(form, fixed).solve(np.zeros(count), values[first])
