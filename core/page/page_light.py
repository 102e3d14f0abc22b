"""The light in which photos show a page: equal exposures, one light for all, and light interpolated over gaps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from .page_cells import CELLS, smooth_known

Cells = NDArray[np.bool_]
Values = NDArray[np.float32]

_ROUNDS = 20  # of reweighting; a choice
_LEVEL = 1e-4  # weight of a level surface, in samples of all: it decides where few cells are seen; a choice
_MOST_CHANGE = 1.5  # logarithm, a factor of 4.5: a bound against runaways, not measured
# Difference of logarithms of brightness beyond which a cell says little about the exposure. With 0.1 a shadow of -0.15
# on a third of the page appeared as -0.03, with 0.04 it appears as -0.07 to -0.1.
_USUAL_DIFFERENCE = 0.04
# Cells between samples: the exposure has only six unknowns.
_STEP = 3
_LIGHT_SCALE = 0.015  # of the page's longer side: differences of light wider than this are evened out


def even_exposure(color: Values, visible: Cells, reference: int) -> Values:
    """Bring all photos to the reference's exposure.

    It is modelled as a quadratic surface over the page for each photo and channel: a lamp's light falls off slowly, a
    lens's towards the photo's corners. Larger differences have little weight, so a shadow on a third of the page does
    not change it.

    Parameters
    ----------
    color : (n, h, w, 3) array
        Logarithm of brightness.
    visible : (n, h, w) bool array
    reference : int

    Returns
    -------
    (n, h, w, 3) float32 array
        ``color`` minus each photo's surface.
    """
    y, x = np.indices(color.shape[1:3]) / max(color.shape[1:3]) - 0.5
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    matched = color.copy()
    some = np.s_[_STEP // 2 :: _STEP, _STEP // 2 :: _STEP]
    for index in range(len(color)):
        both = (visible[index] & visible[reference])[some]
        if index == reference or not both.any():
            continue
        known = terms[some][both]
        for channel in range(3):
            difference = (color[index, ..., channel] - color[reference, ..., channel])[some][both].astype(float)
            surface = np.zeros(terms.shape[-1])
            surface[0] = np.median(difference)
            for _ in range(_ROUNDS):
                weight = (1 + ((difference - known @ surface) / _USUAL_DIFFERENCE) ** 2) ** -2
                weighted = (known * weight[:, None]).T
                normal = weighted @ known + _LEVEL * weight.sum() * np.diag([0, 1, 1, 1, 1, 1])
                surface = np.linalg.solve(normal, weighted @ difference)
            matched[index, ..., channel] -= (terms @ surface).astype(np.float32)
    return matched


def even_light(color: Values, visible: Cells, reference: int) -> Values:
    """Find what each photo is multiplied by so that all show the page in the same light.

    That light is the median of the photos at the reference's exposure: a glare or a shadow in one of them is gone.

    Parameters
    ----------
    color : (n, h, w, 3) array
        Logarithm of brightness.
    visible : (n, h, w) bool array
    reference : int

    Returns
    -------
    (n, h, w, 3) float32 array
    """
    sigma = _LIGHT_SCALE * CELLS
    light = np.stack([smooth_known(c, v, sigma) if v.any() else c for c, v in zip(color, visible, strict=True)])
    levelled = np.full_like(light, np.nan)
    for index, seen in enumerate(visible):
        both = seen & visible[reference]
        if seen.any():
            exposure = np.median((light[index] - light[reference])[both if both.any() else seen], axis=0)
            levelled[index] = np.where(seen[..., None], light[index] - exposure, np.nan)
    seen_at_all = visible.any(axis=0)
    target = np.zeros(light.shape[1:], np.float32)
    target[seen_at_all] = np.nanmedian(levelled[:, seen_at_all], axis=0)
    target = smooth_known(target, seen_at_all, sigma / 2)
    return np.exp(np.clip(target - light, -_MOST_CHANGE, _MOST_CHANGE))


def membrane(values: Values, known: Cells) -> Values:
    """Values (h, w, c) where known, elsewhere those of a membrane fixed there: each is the mean of its neighbours."""
    if known.all() or not known.any():
        return values
    number = np.full(known.shape, -1)
    number[~known] = np.arange((~known).sum())
    right = np.zeros((int((~known).sum()), values.shape[2]))
    degree = np.zeros(len(right))
    rows, columns = [], []
    for one, other in (
        (np.s_[:, :-1], np.s_[:, 1:]),
        (np.s_[:-1], np.s_[1:]),
    ):
        for here, there in ((one, other), (other, one)):
            mine, theirs = number[here].ravel(), number[there].ravel()
            open_here = mine >= 0
            np.add.at(degree, mine[open_here], 1)
            free, fixed = open_here & (theirs >= 0), open_here & (theirs < 0)
            rows.append(mine[free])
            columns.append(theirs[free])
            np.add.at(right, mine[fixed], values[there].reshape(-1, values.shape[2])[fixed])
    row, column = np.concatenate(rows), np.concatenate(columns)
    links = sparse.coo_array((np.full(len(row), -1.0), (row, column)), (len(right), len(right)))
    out = values.copy()
    out[~known] = splu((links + sparse.diags_array(degree)).tocsc()).solve(right)
    return out
