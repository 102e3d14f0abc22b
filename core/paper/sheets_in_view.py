"""Decide which regions are the photographed sheets: one region that is likely a sheet, or several together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..numeric.polygon import inside_polygon, signed_area
from ..sparse_model import SparseModel
from .joined_parts import lie_flush
from .orthophoto import Orthophoto
from .sheet_evidence import WEIGHTS, Evidence, off_aim
from .sheet_hypotheses import Hypothesis

# Values without a figure are choices; no measurement of them is recorded.
# Two regions are of one sheet, or of one and its parts, when they share this part of the smaller.
SAME_PLACE = 0.5
# Regions that share more than this part of the smaller cannot both be sheets.
_OVERLAP = 0.02
# This many of the regions most like a sheet are tried together.
_TOGETHER = 40
# By how much, in logarithms of the odds, several regions must explain the photos better than one, and another one more
# than those without it. Of 40 generated scenes with two sheets (seeds 2000 to 2044, the cameras aimed at both) both are
# found in 21 at 0 to 2, in 19 at 3 and in 16 at 4; in 28 they are among the hypotheses at all. Of 63 scenes with one
# sheet, 2 are said to have several at 0, and 1 at 0.5 to 4. Before, with each region judged by itself, both were found
# in 1 of 28.
_BETTER = 2.0

Weighed = Sequence[tuple[Hypothesis, Evidence]]


def likely_sheets(weighed: Weighed, ortho: Orthophoto, model: SparseModel) -> list[tuple[Hypothesis, float]]:
    """The photographed sheets, the likeliest first, each with the probability that it is a sheet.

    A photographer aims at everything that is to be in the photos. So several regions count as sheets if all of them
    look like one, even the faintest, and the photos are aimed at their common middle: squares of a cloth and parts of a
    print score lower than the sheet that they surround or are part of.

    Parameters
    ----------
    weighed : sequence of (Hypothesis, Evidence)
        At least one.
    ortho : Orthophoto
    model : SparseModel

    Returns
    -------
    list of (Hypothesis, float)
    """
    score = np.array([evidence.score() for _, evidence in weighed])
    first = int(score.argmax())
    masks = np.array([hypothesis.mask.ravel() for hypothesis, _ in weighed], np.float32)
    shared = masks @ masks.T
    area = shared.diagonal()
    same = shared > SAME_PLACE * np.minimum(area[:, None], area)
    apart = shared <= _OVERLAP * np.minimum(area[:, None], area)
    sets = _Sets(weighed, ortho, model)
    like = np.argsort(-sets.sheet_score, kind="stable")[:_TOGETHER]
    apart[np.ix_(like, like)] &= ~lie_flush([weighed[index][0] for index in like])
    one, other = np.triu_indices(len(like), 1)
    pairs = np.stack([like[one], like[other]], axis=1)
    pairs = pairs[apart[pairs[:, 0], pairs[:, 1]]]
    of_pairs = sets.score(pairs)
    if not len(pairs) or of_pairs.max() <= score[first] + _BETTER:
        chance = np.exp(score - score[first])
        return [(weighed[first][0], float(chance[same[first]].sum() / chance.sum()))]
    best, chosen = float(of_pairs.max()), pairs[of_pairs.argmax()]
    while len(further := like[apart[like][:, chosen].all(axis=1)]):
        larger = np.column_stack([np.tile(chosen, (len(further), 1)), further])
        of_larger = sets.score(larger)
        if of_larger.max() <= best + _BETTER:
            break
        best, chosen = float(of_larger.max()), larger[of_larger.argmax()]
    every, alone = np.exp(of_pairs - of_pairs.max()), np.exp(score - of_pairs.max())
    total = every.sum() + alone.sum()
    found = sorted(chosen, key=lambda index: -score[index])
    return [
        (weighed[index][0], float((every[same[index][pairs].any(axis=1)].sum() + alone[same[index]].sum()) / total))
        for index in found
    ]


class _Sets:
    """Scores of several regions taken together."""

    def __init__(self, weighed: Weighed, ortho: Orthophoto, model: SparseModel) -> None:
        self.cameras = model.cameras
        self.sheet_score = np.array([evidence.sheet_score() for _, evidence in weighed])
        self.middle = np.array([ortho.to_world(h.polygon.mean(axis=0)[None])[0] for h, _ in weighed])
        self.area = np.exp([2 * evidence.size for _, evidence in weighed])
        self.points = np.array([evidence.points_inside for _, evidence in weighed])

    def score(self, sets: NDArray[np.int64]) -> Array:
        """Score sets of regions (M, K): by the least sheet-like region of each, and by how well it fits the aim."""
        size = 0.5 * np.log(self.area[sets].sum(axis=1))
        return (
            self.sheet_score[sets].min(axis=1)
            + WEIGHTS.off_aim * off_aim(self.middle[sets].mean(axis=1), self.cameras)
            + WEIGHTS.size * size
            + WEIGHTS.size_squared * size**2
            + WEIGHTS.points_inside * self.points[sets].sum(axis=1)
        )


def sheet_under(outlines: Sequence[Array], place: Array) -> int | None:
    """The sheet at a place of a picture; if there are several, the smallest.

    Parameters
    ----------
    outlines : sequence of (K, 2) arrays
        The sheets' outlines in the picture. Outlines with points that are not finite, such as those behind the camera,
        are left out.
    place : (2,) array
        In the same unit.

    Returns
    -------
    int or None
        Index of the outline; None if there is no sheet.
    """
    around = [
        index
        for index, outline in enumerate(outlines)
        if np.isfinite(outline).all() and inside_polygon(np.asarray(place, float)[None], outline)[0]
    ]
    return min(around, key=lambda index: abs(signed_area(outlines[index])), default=None)
