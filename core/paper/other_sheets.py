"""Other regions of the scene that may be the sheet, if the likeliest one turned out not to be."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..numeric.polygon import filled_polygon, resample
from ..sparse_model import SparseModel
from .orthophoto import orthophoto
from .sheet_evidence import Surroundings
from .sheet_hypotheses import COARSE
from .sheet_search import OUTLINE_SPACING, SAME_SHEET, FoundSheet, in_common, points_within, weigh_all


def other_sheets(
    model: SparseModel, photos: list[NDArray[np.float32]], taken: Sequence[Array], most: int
) -> tuple[FoundSheet, ...]:
    """The likeliest distinct regions other than the sheets taken.

    Parameters
    ----------
    model : SparseModel
    photos : list of (h, w, 3) float32 arrays
        One for each camera of the model, as `image.reduced` gives it.
    taken : sequence of (K, 3) arrays
        World points along the edges of sheets.
    most : int
        The largest number of regions.
    """
    ortho = orthophoto(model, photos)
    weighed = weigh_all(Surroundings(ortho, model))
    if not weighed:
        return ()
    shape = weighed[0][0].mask.shape
    known = [filled_polygon(ortho.from_world(edge) / COARSE, shape) for edge in taken]
    scores = np.array([evidence.score() for _, evidence in weighed])
    chance = np.exp(scores - scores.max()) / np.exp(scores - scores.max()).sum()
    found: list[FoundSheet] = []
    for index in np.argsort(-scores, kind="stable"):
        region = weighed[index][0]
        if any(in_common(region.mask, mask) > SAME_SHEET for mask in known):
            continue
        known.append(region.mask)
        points = points_within(ortho, region, model)
        edge = ortho.to_world(resample(region.polygon, OUTLINE_SPACING))
        found.append(FoundSheet(edge, points, float(chance[index]), 0.0))
        if len(found) == most:
            break
    return tuple(found)
