"""Choose the reference photo and find the paper's edge: the best photo, or the next best if the edge is clearer."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..errors import StepFailed
from ..numeric.image import Image
from ..numeric.polygon import signed_area
from ..sparse_model import SparseModel
from ..watch import SILENT, Watch
from .outline import Outline, find_outline
from .reference_view import rank_references
from .sheet_search import FoundSheet

# Values without a figure are choices; no measurement of them is recorded.
# Below this confidence the next best reference photo is tried as well, and the clearest edge taken.
_CLEAR_OUTLINE = 0.9
_REFERENCES_TRIED = 2  # each takes seconds


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
        As for `find_outline`.
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
    tried: dict[int, Outline] = {}
    for index in references[:_REFERENCES_TRIED]:
        watch.step(0.25, f"Following the paper's edge in {model.cameras[index].name}")
        try:
            tried[index] = find_outline(photos[index], model.cameras[index], sheet, threads)
        except StepFailed:
            # a photo that does not show the sheet must not lose the outline found in a better one
            if not tried:
                raise
            break
        if tried[index].confidence >= _CLEAR_OUTLINE:
            break
    clearest = max(tried, key=lambda index: tried[index].confidence)
    confidence = {index: outline.confidence for index, outline in tried.items()}
    return ReferenceOutline(clearest, tried[clearest], confidence)


def given_outline(corners: Array) -> Outline:
    """An outline given by hand, which is certain; corners (K, 2) in either direction, in pixels of the photo."""
    return Outline(corners if signed_area(corners) > 0 else corners[::-1], 1.0, ())
