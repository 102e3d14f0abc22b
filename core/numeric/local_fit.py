"""Robust local fits: a curve or surface through the neighbours of each place, thousands of small fits at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array


def local_fits(
    basis: Array, values: Array, weight: Array, reweigh: Callable[[Array], Array], rounds: int, ridge: float
) -> tuple[Array, Array]:
    """Fit each place's neighbours by least squares, reweighted by the residuals of the last fit.

    Parameters
    ----------
    basis : (N, K, M) or (K, M) array
        The M terms of the fit at the K neighbours of each place; those of one place if all are the same.
    values : (N, K, D) array
        The values to fit, at the neighbours.
    weight : (N, K) array
        Of the first round.
    reweigh : callable
        Maps residuals (N, K), as lengths, to the weights of the next round.
    rounds : int
    ridge : float
        Added to the diagonal of the normal equations, which keeps every term determined if the neighbours are on a
        line.

    Returns
    -------
    coefficients : (N, M, D) array
    residual : (N, K) array

    Examples
    --------
    >>> at = np.arange(5.0)
    >>> line, off = local_fits(
    ...     np.stack([np.ones(5), at], axis=1), np.array([[0, 1, 2, 3, 9.0]])[..., None], np.ones((1, 5)),
    ...     lambda residual: 1 / np.maximum(residual, 1e-6), rounds=20, ridge=1e-12,
    ... )
    >>> line[0, :, 0].round(3)
    array([0., 1.])
    """
    terms = basis.shape[-1]
    alike = basis.ndim == 2
    products = (basis[:, :, None] * basis[:, None, :]).reshape(-1, terms**2) if alike else None
    held = ridge * np.eye(terms)
    for _ in range(rounds):
        if products is not None:
            normal = (weight @ products).reshape(-1, terms, terms)
            right = basis.T @ (weight[..., None] * values)
        else:
            weighted = basis * weight[..., None]
            normal = np.einsum("nki,nkj->nij", weighted, basis)
            right = np.einsum("nki,nkd->nid", weighted, values)
        coefficients = np.linalg.solve(normal + held, right)
        fitted = basis @ coefficients if alike else np.einsum("nki,nid->nkd", basis, coefficients)
        residual = np.linalg.norm(values - fitted, axis=2)
        weight = reweigh(residual)
    return coefficients, residual
