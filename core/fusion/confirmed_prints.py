"""Which photos' print others confirm: an edge that one photo alone shows belongs to something that passes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..numeric.image import gaussian_mean
from .agreed_light import median_of_known

Values = NDArray[np.float32]

# Values without a figure are choices; no measurement of them is recorded.
_FEWEST = 3  # photos that must show a cell to say what most of them have
_AROUND = 2.0  # cells, standard deviation of the window in which prints are compared
_LEAST_KNOWN = 1e-3  # share of that window
# Variance of a cell's mean print: with the first there is nothing to confirm, from the second on there is. Noise on
# blank paper has less than 0.01, a line of text 0.3, the edge of a hand nearly as bright as the paper 0.1.
_BLANK, _PRINTED = 0.02, 0.08
# Correlation with the print of most photos. Cells hold no letters, only lines of text, so a sharp photo among blurred
# ones has 0.6 at least.
_UNLIKE, _LIKE = 0.1, 0.5


def confirmed_prints(prints: Values, known: NDArray[np.bool_]) -> Values:
    """How far most photos confirm each photo's print, 0 to 1.

    Parameters
    ----------
    prints : (n, h, w) array
        Mean print of each cell in each photo, laid on the others.
    known : (n, h, w) bool array
        Which cells each photo shows.

    Returns
    -------
    (n, h, w) float32 array
        1 where fewer than three photos show the cell, and where a photo has no print.
    """
    count = known.sum(axis=0)
    common = median_of_known(prints[..., None], known)[..., 0]
    common_variance, _ = gaussian_mean(common**2, count > 0, _AROUND, _LEAST_KNOWN)
    confirmed = np.ones(prints.shape, np.float32)
    for index, (print_, own) in enumerate(zip(prints, known, strict=True)):
        variance, _ = gaussian_mean(print_**2, own, _AROUND, _LEAST_KNOWN)
        both, _ = gaussian_mean(print_ * common, own, _AROUND, _LEAST_KNOWN)
        correlation = both / np.sqrt(np.maximum(variance, _BLANK) * np.maximum(common_variance, _BLANK))
        like = np.clip((correlation - _UNLIKE) / (_LIKE - _UNLIKE), 0, 1)
        printed = np.clip((variance - _BLANK) / (_PRINTED - _BLANK), 0, 1)
        confirmed[index] = 1 - printed * (1 - like)
    confirmed[:, count < _FEWEST] = 1
    return confirmed
