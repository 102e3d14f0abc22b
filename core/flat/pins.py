"""Vertices with given places on the flat map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..arrays import Array, Indices
from ..numeric.robust import factorize


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
