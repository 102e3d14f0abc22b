"""The exposures of the photos, made equal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Cells = NDArray[np.bool_]
Values = NDArray[np.float32]

_ROUNDS = 20  # of reweighting; a choice
_LEVEL = 1e-4  # weight of a level surface, in samples of all: it decides where few cells are seen; a choice
# Difference of logarithms of light beyond which a cell says little about the exposure. With 0.2 a shadow of -0.3 on a
# third of the page appeared as -0.06, with 0.08 it appears as -0.14 to -0.2.
_USUAL_DIFFERENCE = 0.08
# Cells between samples: the exposure has only six unknowns.
_STEP = 3


def even_exposure(color: Values, visible: Cells, reference: int) -> Values:
    """Bring all photos to the reference's exposure.

    It is modelled as a quadratic surface over the page for each photo and channel: a lamp's light falls off slowly, a
    lens's towards the photo's corners. Larger differences have little weight, so a shadow on a third of the page does
    not change it.

    Parameters
    ----------
    color : (n, h, w, 3) array
        Logarithm of linear light.
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
