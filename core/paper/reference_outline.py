"""Choose the reference photo and find the paper's edge: the best photo, or the next best if the edge is clearer."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..errors import StepFailed
from ..numeric.image import Image
from ..numeric.polygon import inside_polygon, signed_area
from ..sparse_model import FEWEST_VIEWS, SparseModel
from ..watch import SILENT, Watch
from .followed_edge import FollowedEdge
from .outline import FollowedOutlines, Outline, follow_outlines, settled
from .outline_judgement import OtherPhoto, Signs, agreement_of_photos, judge, likeliest, likeliest_pair
from .reference_view import rank_references
from .sheet_search import FoundSheet

# Values without a figure are choices; no measurement of them is recorded.
# Below this confidence the next best reference photo is tried as well; the edges that agree best are taken, and of
# these two the clearer one.
_CLEAR_OUTLINE = 0.9
_REFERENCES_TRIED = 2  # each takes seconds
_FEWEST_POINTS = 50  # within outlines of two photos that are compared by them


@dataclass(frozen=True)
class ReferenceOutline:
    """The paper's edge in the reference photo.

    Attributes
    ----------
    reference : int
        Index of the reference photo.
    outline : Outline
    tried : mapping of int to float
        How clear the edge is in each photo that was tried, in their order: the confidence by the photo's index.
    """

    reference: int
    outline: Outline
    tried: Mapping[int, float]


def find_reference_outline(
    model: SparseModel,
    photos: Sequence[Image],
    small: Sequence[NDArray[np.float32]],
    sheet: FoundSheet,
    *,
    reference: int | None = None,
    without: Container[int] = (),
    threads: int = 1,
    watch: Watch = SILENT,
) -> ReferenceOutline:
    """Choose the reference photo and find the paper's edge in it.

    Parameters
    ----------
    model : SparseModel
    photos : sequence of (h, w, 3) uint8 or uint16 arrays
        One for each camera of the model; those that are tried are read one by one.
    small : sequence of (h, w, 3) float32 arrays
        The same, as `image.reduced` gives them; unused if the reference photo is given.
    sheet : FoundSheet
    reference : int, optional
        Index of the reference photo, if it is not to be chosen.
    without : container of int
        Photos that must not be chosen.
    threads : int
        As for `follow_outlines`.
    watch : Watch

    Raises
    ------
    Cancelled
    StepFailed
        If no photo is left to choose, or the sheet does not show in the best of them.
    """
    watch.step(0, "Choosing the reference photo")
    if reference is None:
        ranked = rank_references(model, small, sheet.outline, sheet.points).tolist()
        references = [index for index in ranked if index not in without]
        if not references:
            raise StepFailed("No other photo can be the reference.")
    else:
        references = [reference]
    tried: dict[int, FollowedOutlines] = {}
    for index in references[:_REFERENCES_TRIED]:
        watch.step(0.25, f"Following the paper's edge in {model.cameras[index].name}")
        try:
            photo = photos[index]
            tried[index] = follow_outlines(photo, model.cameras[index], sheet, threads)
        except StepFailed:
            # a photo that does not show the sheet must not lose the outline found in a better one
            if not tried:
                raise
            break
        signs = tried[index].signs
        if judge(signs[likeliest(signs)]).confidence >= _CLEAR_OUTLINE:
            break
    taken = _right_ones(model, tried)
    judged = {each: judge(best.signs, best.other) for each, best in taken.items()}
    clearest = max(taken, key=lambda each: taken[each].signs.odds())
    if clearest != index:
        photo = photos[clearest]  # of two large photos, one is in memory
    outline = settled(photo, taken[clearest].edge, judged[clearest])
    return ReferenceOutline(clearest, outline, {each: judgement.confidence for each, judgement in judged.items()})


class _Taken(NamedTuple):
    """The likeliest outline in a photo: its edge, its signs, and the likeliest in the other photo that was tried."""

    edge: FollowedEdge
    signs: Signs
    other: OtherPhoto | None = None


def _right_ones(model: SparseModel, tried: Mapping[int, FollowedOutlines]) -> dict[int, _Taken]:
    """Which outline is the likeliest in each photo."""
    if len(tried) == 1:
        ((index, only),) = tried.items()
        best = likeliest(only.signs)
        return {index: _Taken(only.edges[best], only.signs[best])}
    (one, first), (other, second) = tried.items()
    shared = _shared_points(model, (one, first), (other, second))
    in_one, in_other = pair = likeliest_pair(first.signs, second.signs, shared)
    agrees = float(agreement_of_photos(shared[pair]))
    return {
        one: _Taken(first.edges[in_one], first.signs[in_one], OtherPhoto(second.signs[in_other], agrees)),
        other: _Taken(second.edges[in_other], second.signs[in_other], OtherPhoto(first.signs[in_one], agrees)),
    }


def _shared_points(model: SparseModel, *followed: tuple[int, FollowedOutlines]) -> Array:
    """The points within an outline of one photo and within one of another, as a part of those within either (K, L).

    NaN where they are too few to say anything.
    """
    points = model.points[model.views_per_point() >= FEWEST_VIEWS]
    pixels = [model.cameras[index].project(points) for index, _ in followed]
    shown = np.isfinite(np.hstack(pixels)).all(axis=1)
    first, second = (
        np.array([inside_polygon(each[shown], edge.points) for edge in outlines.edges])
        for each, (_, outlines) in zip(pixels, followed, strict=True)
    )
    both, either = ((op(first[:, None], second)).sum(axis=2) for op in (np.logical_and, np.logical_or))
    return np.where(either >= _FEWEST_POINTS, both / np.maximum(either, 1), np.nan)


def given_outline(corners: Array) -> Outline:
    """An outline given by hand, which is certain; corners (K, 2) in either direction, in pixels of the photo."""
    return Outline(corners if signed_area(corners) > 0 else corners[::-1], 1.0, ())
