"""Vertices with given places on the flat map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..arrays import Array, Indices
from ..numeric.robust import factorize
from ..numeric.triangles import areas, signed_areas
from ..sheet import FlatMap, Sheet


@dataclass(frozen=True)
class Pins:
    """Where vertices are held.

    Attributes
    ----------
    vertices : (P,) int array
        No vertex twice.
    uv : (P, 2) array
        In the frame and unit of their map.
    """

    vertices: Indices
    uv: Array


def pinned_on_page(sheet: Sheet, flat: FlatMap, vertices: Indices) -> tuple[Pins, float]:
    """Pins that hold vertices where they are on the page, and the page's unit for each of the sheet's."""
    areas_on_page = np.abs(signed_areas(flat.uv, sheet.triangles)).sum()
    scale = flat.world_scale or float(np.sqrt(areas_on_page / areas(sheet.vertices, sheet.triangles).sum()))
    return Pins(vertices, flat.uv[vertices] / scale), scale


class HeldSystem:
    """A sparse symmetric system with some given unknowns, factored once.

    Parameters
    ----------
    matrix : (n, n) sparse array
        Symmetric, positive semi-definite.
    held : (h,) int array
        The given unknowns, none twice.

    Raises
    ------
    StepFailed
        If the rest of the matrix is singular.
    """

    def __init__(self, matrix: sparse.csr_array, held: Indices) -> None:
        self._held = held
        self._free = np.setdiff1d(np.arange(matrix.shape[0]), held)
        rows = matrix.tocsr()[self._free]
        self._coupling = rows[:, held]
        self._solver = factorize(rows[:, self._free].tocsc()) if len(self._free) else None

    def solve(self, right: Array, values: Array) -> Array:
        """The unknowns (n,) or (n, k) for a right-hand side of that shape and the given ``values`` (h,) or (h, k)."""
        result = np.empty(right.shape, order="F")
        result[self._held] = values
        if self._solver is not None:
            result[self._free] = self._solver.solve(right[self._free] - self._coupling @ values)
        return result
