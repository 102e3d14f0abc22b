"""Iteratively reweighted least squares: the loop for both l1 problems of the paper (Eq. 6-9 and 18-19).

The paper computes its weights (Eq. 9) from residuals that already include the weight, which never converges. Here the
weight comes from the true residual and majorises a stated loss, so the objective falls at every iteration.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

from ..arrays import Array
from ..errors import StepFailed
from ..watch import SILENT, Watch

# Ratio of the standard deviation of a normal distribution to its median absolute deviation.
MAD_TO_SIGMA = 1.4826
# Where an observation counts half, and from where on it is dropped, in standard deviations: those of the prototype of
# the tracks (`tracks/dense_tracks.py`).
_HALF_WEIGHT, GATE = 2.5, 4.0
# Share of the mean diagonal added for numerical stability (the paper's alpha, made relative).
_DIAGONAL_SHARE = 1e-13


@dataclass(frozen=True)
class Loss:
    """A robust loss of a residual.

    Attributes
    ----------
    kind : {"squared", "l1", "cauchy"}
        ``l1`` is the absolute value, quadratic below ``scale`` (Huber's function).
    scale : float
        The residual above which the loss is no longer quadratic.
    """

    kind: Literal["squared", "l1", "cauchy"]
    scale: float = 1.0

    def value(self, residual: Array) -> Array:
        """The loss of each residual; all kinds grow like ``r**2 / (2 scale)`` near zero."""
        size = np.abs(residual)
        if self.kind == "squared":
            return size**2 / (2 * self.scale)
        if self.kind == "l1":
            return np.where(size < self.scale, size**2 / (2 * self.scale), size - self.scale / 2)
        return self.scale / 2 * np.log1p((size / self.scale) ** 2)

    def weight(self, residual: Array) -> Array:
        """Derivative of the loss divided by the residual: the diagonal of the paper's W'W."""
        if self.kind == "squared":
            return np.full(residual.shape, 1 / self.scale)
        if self.kind == "l1":
            return 1 / np.maximum(np.abs(residual), self.scale)
        return 1 / (self.scale * (1 + (residual / self.scale) ** 2))


def observation_weight(length: Array, deviation: float) -> Array:
    """Cauchy's weight of observations that lie this far off, 1 where they are exact."""
    scale = _HALF_WEIGHT * deviation
    return scale * Loss("cauchy", scale).weight(length)


@dataclass(frozen=True)
class Fit:
    """Result of `minimize`.

    Attributes
    ----------
    solution : (n,) array
    objective : tuple of float
        The objective before the first and after each iteration; it never rises.
    """

    solution: Array
    objective: tuple[float, ...]


def minimize(
    rows: sparse.csr_array,
    target: Array,
    loss: Loss,
    quadratic: sparse.csr_array,
    *,
    start: Array | None = None,
    linear: Array | None = None,
    tolerance: float = 1e-5,
    max_iterations: int = 50,
    watch: Watch = SILENT,
) -> Fit:
    """Minimise ``sum(loss(rows @ x - target)) + x' quadratic x - 2 linear' x``.

    Parameters
    ----------
    rows : (m, n) sparse array
    target : (m,) array
    loss : Loss
    quadratic : (n, n) sparse array
        Symmetric, positive semi-definite.
    start : (n,) array, optional
        The start; without it, the first weights are those of zero residuals.
    linear : (n,) array, optional
    tolerance : float
        Stop once no unknown changes by more than this.
    max_iterations : int
    watch : Watch

    Raises
    ------
    StepFailed
        If the equations leave some unknown undetermined.
    """
    linear = np.zeros(rows.shape[1]) if linear is None else linear
    weight = np.full(len(target), 1 / loss.scale) if start is None else loss.weight(rows @ start - target)
    x = start
    history = [] if start is None else [_objective(rows @ start - target, loss, quadratic, linear, start)]
    for iteration in range(max_iterations):
        watch.step(iteration / max_iterations, "Solving with new weights")
        weighted = rows.multiply(weight[:, None] / 2).tocsr()
        update = solve_symmetric((rows.T @ weighted + quadratic).tocsc(), weighted.T @ target + linear)
        residual = rows @ update - target
        history.append(_objective(residual, loss, quadratic, linear, update))
        change = np.inf if x is None else float(np.abs(update - x).max())
        x, weight = update, loss.weight(residual)
        if change < tolerance or loss.kind == "squared":
            break
    assert x is not None
    return Fit(x, tuple(history))


def _objective(residual: Array, loss: Loss, quadratic: sparse.csr_array, linear: Array, x: Array) -> float:
    return float(loss.value(residual).sum() + x @ (quadratic @ x) - 2 * linear @ x)


def solve_symmetric(matrix: sparse.csc_array, right: Array) -> Array:
    """Solve a sparse symmetric positive definite system.

    Raises
    ------
    StepFailed
        If the matrix is singular.
    """
    return factorize(matrix).solve(right)


def factorize(matrix: sparse.csc_array) -> SuperLU:
    """Factor a sparse symmetric positive definite matrix; the result has ``solve(right)``."""
    diagonal = matrix.diagonal()
    stabilised = matrix + sparse.diags_array(np.full(len(diagonal), _DIAGONAL_SHARE * diagonal.mean()), format="csc")
    try:
        return splu(stabilised, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:
        raise StepFailed(
            "The equations of the sheet have no single solution: parts of it are hardly tied to the rest. "
            "Check the outline, take nearer photos of the whole sheet, or use fewer grid rows."
        ) from error
