"""The displacement between the print of two pictures that differ by a few pixels at most."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..numeric.image import gaussian_mean

Picture = NDArray[np.float32]

FARTHEST = 0.008  # of the page's longer side: print displaced farther is different print

_DETAIL = 1.2  # pixels: noise below this is ignored
_LIGHT = 12.0  # pixels: wider variations are light, not print
_WINDOW = 16.0  # pixels over which the displacement counts as constant
_ROUNDS = 5  # of least squares; a choice
_LARGEST_STEP = 2  # pixels in one round, within which print is about linear
_WEAK_PRINT = 1e-2  # of the mean squared gradient: with less, the displacement around counts more
_LEAST_CONTRAST = 0.02  # logarithm of brightness: fainter print is not strengthened to the others' contrast
_LEAST_KNOWN = 1e-3  # share of the surroundings above which their mean counts


def displacement(
    fixed: Picture, moving: Picture, known: NDArray[np.bool_], limit: float, rounds: int = _ROUNDS
) -> Picture:
    """Find the smooth displacement that aligns one picture's print with another's.

    The method is Lucas' and Kanade's least squares in Gaussian windows, repeated. Where there is no print, the
    displacement is that of the surrounding print.

    Parameters
    ----------
    fixed, moving : (H, W) arrays
        Logarithm of brightness of the same page; values where not ``known`` do not matter.
    known : (H, W) bool array
        Where both show the page.
    limit : float
        The largest credible displacement, in pixels; beyond it the pictures are left as they are.
    rounds : int
        Number of repetitions; one is enough to measure how well the pictures are aligned already.

    Returns
    -------
    (H, W, 2) float32 array
        ``moving`` at ``(x, y) + displacement`` (x first) shows what ``fixed`` does at ``(x, y)``.
    """
    fixed, moving = _print(fixed, known), _print(moving, known)
    gradient = np.stack([np.gradient(fixed, axis=1), np.gradient(fixed, axis=0)])
    inside = ndimage.binary_erosion(known, iterations=int(_DETAIL * 3))
    xx, xy, yy = (
        ndimage.gaussian_filter(a * b * inside, _WINDOW)
        for a, b in ((gradient[0], gradient[0]), (gradient[0], gradient[1]), (gradient[1], gradient[1]))
    )
    weak = _WEAK_PRINT * float(np.mean(xx + yy)) + 1e-12
    determinant = (xx + weak) * (yy + weak) - xy**2
    trust = np.clip((xx * yy - xy**2) / determinant, 0, 1)
    rows, columns = np.indices(fixed.shape, dtype=np.float32)
    moved = np.zeros((2, *fixed.shape), np.float32)
    for _ in range(rounds):
        there = ndimage.map_coordinates(moving, [rows + moved[1], columns + moved[0]], order=1, mode="nearest")
        difference = (fixed - there) * inside
        x, y = (ndimage.gaussian_filter(part * difference, _WINDOW) for part in gradient)
        step = np.stack([((yy + weak) * x - xy * y), ((xx + weak) * y - xy * x)]) / determinant
        moved = _spread(moved + np.clip(step, -_LARGEST_STEP, _LARGEST_STEP), trust)
    far = np.hypot(*moved) > limit
    moved[:, far] = 0
    return np.moveaxis(ndimage.gaussian_filter(moved, (0, _WINDOW / 2, _WINDOW / 2)), 0, -1)


def _print(picture: Picture, known: NDArray[np.bool_]) -> Picture:
    """The picture without its light and with the same contrast everywhere."""
    light, share = gaussian_mean(picture, known, _LIGHT, _LEAST_KNOWN)
    detail = np.where(known, ndimage.gaussian_filter(np.where(known, picture, 0), _DETAIL) - light, 0)
    contrast = np.sqrt(ndimage.gaussian_filter(detail**2, 2 * _LIGHT) / np.maximum(share, _LEAST_KNOWN))
    return detail / (contrast + _LEAST_CONTRAST)


def _spread(moved: Picture, trust: Picture) -> Picture:
    """The displacement where it can be trusted, and its mean over the surroundings elsewhere."""
    around, _ = gaussian_mean(np.moveaxis(moved, 0, -1), trust, _WINDOW, _LEAST_KNOWN)
    return trust * moved + (1 - trust) * np.moveaxis(around, -1, 0)
