"""Which sheets lie in view: hypotheses from the orthophoto, weighed by one sum of evidence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .camera import Array
from .errors import StepFailed
from .orthophoto import Orthophoto, orthophoto
from .polygon import filled_polygon, inside_polygon, resample, smallest_rectangle
from .reference_view import prominence
from .sheet_evidence import Evidence, Surroundings
from .sheet_hypotheses import COARSE, Hypothesis, sheet_hypotheses
from .sheets_in_view import likely_sheets
from .sides_search import polished_quadrilateral
from .sparse_model import SparseModel

_FEWEST_POINTS = 20
_FEWEST_POINTS_OF_A_SURFACE = 12
_OUTLINE_SPACING = 3.0
# So many of the likeliest hypotheses are straightened.
_STRAIGHTENED = 12


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
    """

    outline: Array
    points: NDArray[np.bool_]
    probability: float


def find_sheets(model: SparseModel, photos: list[NDArray[np.float32]]) -> tuple[FoundSheet, ...]:
    """The sheets in view, the one that the photos are most likely of first.

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
    weighed = weigh_all(ortho, model)
    if not weighed:
        raise StepFailed(
            "Nothing in the photos has an edge like a sheet's; give the outline by hand (--outline, or Edit Outline in "
            "Blender)."
        )
    return tuple(_as_found(ortho, model, *choice) for choice in likely_sheets(weighed, ortho, model))


def weigh_all(ortho: Orthophoto, model: SparseModel) -> list[tuple[Hypothesis, Evidence]]:
    """All regions of the orthophoto that may be the sheet, with what speaks for each."""
    surroundings = Surroundings(ortho, model)
    weighed = _weigh(sheet_hypotheses(ortho, surroundings.photo_side), surroundings)
    return weighed + _weigh(_straightened(weighed[:_STRAIGHTENED], surroundings), surroundings)


def _weigh(hypotheses: list[Hypothesis], surroundings: Surroundings) -> list[tuple[Hypothesis, Evidence]]:
    """Those that can be judged, the likeliest first."""
    weighed = [(hypothesis, surroundings.evidence(hypothesis)) for hypothesis in hypotheses]
    judged = [(hypothesis, evidence) for hypothesis, evidence in weighed if evidence is not None]
    return sorted(judged, key=lambda item: -item[1].score())


def _straightened(weighed: list[tuple[Hypothesis, Evidence]], surroundings: Surroundings) -> list[Hypothesis]:
    """Of each hypothesis the quadrilateral whose sides follow edges best: most sheets have straight sides."""
    result = []
    for hypothesis, _ in weighed:
        corners = polished_quadrilateral(surroundings.color, smallest_rectangle(hypothesis.polygon))
        mask = filled_polygon(corners / COARSE, hypothesis.mask.shape)
        if mask.any():
            result.append(Hypothesis(corners, mask))
    return result


def _as_found(ortho: Orthophoto, model: SparseModel, hypothesis: Hypothesis, probability: float) -> FoundSheet:
    """The hypothesis on the surface of its own points, not on one that leads down to the table around it."""
    positions = ortho.from_world(model.points)
    points = inside_polygon(positions, hypothesis.polygon) & (prominence(model) > 0)
    if points.sum() >= _FEWEST_POINTS_OF_A_SURFACE:
        ortho = ortho.on_sheet(model.points[points])
    return FoundSheet(ortho.to_world(resample(hypothesis.polygon, _OUTLINE_SPACING)), points, probability)
