"""Find the sheets in view: hypotheses from the orthophoto, scored by one sum of evidence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..errors import StepFailed
from ..numeric.morphology import Mask
from ..numeric.polygon import filled_polygon, inside_polygon, resample, smallest_rectangle
from ..sparse_model import SparseModel
from .joined_parts import joined, lie_flush
from .orthophoto import Orthophoto, orthophoto
from .parallel_edges import quadrilaterals_on_parallel_edges
from .reference_view import prominence
from .sheet_evidence import Evidence, Surroundings
from .sheet_hypotheses import COARSE, Hypothesis, sheet_hypotheses
from .sheets_in_view import SAME_PLACE, likely_sheets
from .sides_search import polished_quadrilateral

# Values without a figure are choices; no measurement of them is recorded.
# With fewer points seen in three photos, the ground that they define may be a coincidence.
_FEWEST_POINTS = 20
OUTLINE_SPACING = 3.0  # cells of the map, between points of the outline of a sheet that was found
# This many of the likeliest hypotheses are straightened.
_STRAIGHTENED = 12
# Of this many regions, those most like sheets, two may be the parts of one.
_MAY_BE_PARTS = 40
# In each of this many rounds, of this many hypotheses that differ, the sides are moved to this many sets of other
# edges; two quadrilaterals are one where all their corners are within this many cells.
_ROUNDS, _BASES, _MOVED = 2, 2, 12
_APART = 3.0
# Two regions are one sheet, and have one outline, when they share this part of their union: the second allows a strip
# of 2 % of the sheet's side all around it.
SAME_SHEET = 0.7
_SAME_OUTLINE = 0.92
# This many other regions at the sheet's place are kept, if their odds against it are at least these. The edge is
# followed from each, which takes seconds.
_RIVALS, _LEAST_ODDS = 4, np.exp(-8.0)

Weighed = list[tuple[Hypothesis, Evidence]]


@dataclass(frozen=True)
class FoundSheet:
    """A sheet that was found in the orthophoto.

    Attributes
    ----------
    outline : (K, 3) array
        World points along its edge, about right.
    points : (N,) bool array
        Which points of the sparse model lie within its outline, seen from above.
    probability : float
        That this is the sheet the photos are of, 0 to 1, among all hypotheses.
    agreement : float
        Probability of the hypotheses that agree with the outline closely, 0 to 1: how exact it is.
    rivals : tuple of FoundSheet
        Other regions at its place that may be the sheet instead, the likeliest first: parts of it, or more than it.
    """

    outline: Array
    points: NDArray[np.bool_]
    probability: float
    agreement: float
    rivals: tuple[FoundSheet, ...] = ()


def find_sheets(model: SparseModel, photos: list[NDArray[np.float32]]) -> tuple[FoundSheet, ...]:
    """The sheets in view, the most likely one first.

    Parameters
    ----------
    model : SparseModel
    photos : list of (h, w, 3) float32 arrays
        One for each camera of the model, as `image.reduced` gives it.

    Raises
    ------
    StepFailed
        If hardly any point was seen in three photos, or nothing in view may be a sheet.
    """
    if (prominence(model) > 0).sum() < _FEWEST_POINTS:
        raise StepFailed(
            f"Fewer than {_FEWEST_POINTS} points were seen in three photos or more, too few to find a sheet; "
            "take sharper photos that overlap more."
        )
    ortho = orthophoto(model, photos)
    weighed = weigh_all(Surroundings(ortho, model))
    if not weighed:
        raise StepFailed(
            "Nothing in the photos has an edge like a sheet's; give the outline by hand (--outline, or Edit Outline in "
            "Blender)."
        )
    chosen = likely_sheets(weighed, ortho, model)
    alone = len(chosen) == 1
    return tuple(
        _found(ortho, weighed, hypothesis, probability, model, alone=alone) for hypothesis, probability in chosen
    )


def weigh_all(surroundings: Surroundings) -> Weighed:
    """All regions of the orthophoto that may be the sheet, each with its evidence, the likeliest first."""
    weighed = _weigh(sheet_hypotheses(surroundings.ortho, surroundings.photo_side), surroundings)
    weighed.sort(key=_score)
    weighed += _weigh(_straightened(weighed[:_STRAIGHTENED], surroundings), surroundings)
    weighed += _weigh(_joined(weighed), surroundings)
    tried: list[Mask] = []
    for _ in range(_ROUNDS):
        weighed.sort(key=_score)
        bases = _not_tried([hypothesis for hypothesis, _ in weighed], tried)
        weighed += _weigh(_with_moved_sides(bases, surroundings), surroundings)
    return sorted(weighed, key=_score)


def _weigh(hypotheses: list[Hypothesis], surroundings: Surroundings) -> Weighed:
    """Those that can be judged."""
    weighed = [(hypothesis, surroundings.evidence(hypothesis)) for hypothesis in hypotheses]
    return [(hypothesis, evidence) for hypothesis, evidence in weighed if evidence is not None]


def _score(weighed: tuple[Hypothesis, Evidence]) -> float:
    """To sort by: the likeliest first."""
    return -weighed[1].score()


def _not_tried(hypotheses: Sequence[Hypothesis], tried: list[Mask]) -> list[Hypothesis]:
    """The first few of them that are about none of the regions ``tried``, which they join."""
    chosen = []
    for hypothesis in hypotheses:
        if all(in_common(hypothesis.mask, other) < _SAME_OUTLINE for other in tried):
            tried.append(hypothesis.mask)
            chosen.append(hypothesis)
            if len(chosen) == _BASES:
                break
    return chosen


def _with_moved_sides(bases: Sequence[Hypothesis], surroundings: Surroundings) -> list[Hypothesis]:
    """Quadrilaterals that have other sides than the hypotheses have: the edge of the sheet beside that of its print."""
    result: list[Hypothesis] = []
    for base in bases:
        corners = base.polygon if len(base.polygon) == 4 else smallest_rectangle(base.polygon)
        for moved in quadrilaterals_on_parallel_edges(surroundings.color, corners, _MOVED):
            polished = polished_quadrilateral(surroundings.color, moved)
            mask = filled_polygon(polished / COARSE, base.mask.shape)
            if mask.any() and all(np.abs(polished - other.polygon).max() > _APART for other in result):
                result.append(Hypothesis(polished, mask))
    return result


def _joined(weighed: Weighed) -> list[Hypothesis]:
    """The sheets whose parts two of the regions most like sheets may be."""
    like = sorted(weighed, key=lambda each: -each[1].sheet_score())[:_MAY_BE_PARTS]
    parts = [hypothesis for hypothesis, _ in like]
    result: list[Hypothesis] = []
    for first, second in np.argwhere(np.triu(lie_flush(parts))):
        whole = joined(parts[first], parts[second])
        if all(in_common(whole.mask, other.mask) < _SAME_OUTLINE for other in result):
            result.append(whole)
    return result


def _straightened(weighed: list[tuple[Hypothesis, Evidence]], surroundings: Surroundings) -> list[Hypothesis]:
    """Of each hypothesis the quadrilateral whose sides follow edges best: most sheets have straight sides."""
    result = []
    for hypothesis, _ in weighed:
        corners = polished_quadrilateral(surroundings.color, smallest_rectangle(hypothesis.polygon))
        mask = filled_polygon(corners / COARSE, hypothesis.mask.shape)
        if mask.any():
            result.append(Hypothesis(corners, mask))
    return result


def _found(
    ortho: Orthophoto,
    weighed: Weighed,
    hypothesis: Hypothesis,
    probability: float,
    model: SparseModel,
    *,
    alone: bool,
) -> FoundSheet:
    """The sheet that a hypothesis is about, whether or not it is ``alone`` in view."""
    here = _AtOnePlace.of(weighed, hypothesis, alone=alone)

    def found(region: Hypothesis, rivals: tuple[FoundSheet, ...] = ()) -> FoundSheet:
        about_right, exact = here.certainty(region)
        outline = ortho.on_sheet(region.polygon).to_world(resample(region.polygon, OUTLINE_SPACING))
        return FoundSheet(outline, points_within(ortho, region, model), probability * about_right, exact, rivals)

    return found(hypothesis, tuple(found(rival) for rival in here.rivals(hypothesis)))


@dataclass(frozen=True)
class _AtOnePlace:
    """The hypotheses of one place, the likeliest first, and the probability of each (K,) among them."""

    hypotheses: list[Hypothesis]
    chance: Array

    @classmethod
    def of(cls, weighed: Weighed, hypothesis: Hypothesis, *, alone: bool) -> _AtOnePlace:
        """Those of the place of a hypothesis; the photos are aimed at a sheet that is ``alone``."""
        here = [each for each in weighed if _shared(each[0].mask, hypothesis.mask) > SAME_PLACE]
        score = np.array([evidence.score() if alone else evidence.score_wherever() for _, evidence in here])
        chance = np.exp(score - score.max())
        order = np.argsort(-score, kind="stable")
        return cls([here[index][0] for index in order], chance[order] / chance.sum())

    def certainty(self, hypothesis: Hypothesis) -> tuple[float, float]:
        """The probabilities that a hypothesis is about right and that it is exact."""
        alike = np.array([in_common(hypothesis.mask, other.mask) for other in self.hypotheses])
        return float(self.chance[alike > SAME_SHEET].sum()), float(self.chance[alike > _SAME_OUTLINE].sum())

    def rivals(self, hypothesis: Hypothesis) -> list[Hypothesis]:
        """The likeliest others, no two of them alike."""
        found = [hypothesis]
        for other, chance in zip(self.hypotheses, self.chance, strict=True):
            if len(found) > _RIVALS or chance < _LEAST_ODDS * self.chance[0]:
                break
            if all(in_common(other.mask, taken.mask) < _SAME_OUTLINE for taken in found):
                found.append(other)
        return found[1:]


def points_within(ortho: Orthophoto, hypothesis: Hypothesis, model: SparseModel) -> NDArray[np.bool_]:
    """Which points (N,) of the model lie within a region, seen from above, of those that three photos saw."""
    return inside_polygon(ortho.from_world(model.points), hypothesis.polygon) & (prominence(model) > 0)


def in_common(first: Mask, second: Mask) -> float:
    """What two regions share, as a part of their union."""
    return float((first & second).sum() / (first | second).sum())


def _shared(first: Mask, second: Mask) -> float:
    """What two regions share, as a part of the smaller; 0 where one is empty."""
    smaller = min(first.sum(), second.sum())
    return float((first & second).sum() / smaller) if smaller else 0.0
