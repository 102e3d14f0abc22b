"""Choose one of the sheets that were found."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import StepFailed, UsageError
from ..sparse_model import SparseModel
from .other_sheets import other_sheets
from .sheet_search import FoundSheet


def choose_sheet(
    model: SparseModel,
    photos: Sequence[NDArray[np.float32]],
    sheets: Sequence[FoundSheet],
    number: int,
    other: int = 0,
) -> FoundSheet:
    """Take a sheet in view by its number, or a region that is none of them.

    Parameters
    ----------
    model : SparseModel
    photos : sequence of (h, w, 3) float32 arrays
        One for each camera of the model, as `image.reduced` gives it; looked at only for another region.
    sheets : sequence of FoundSheet
        Those in view, in the order of their numbers, as `find_sheets` gives them.
    number : int
        From 1 on.
    other : int
        0 for the sheet of that number, n for the n-th likeliest region that is none of those in view.

    Raises
    ------
    UsageError
        If there is no sheet of that number.
    StepFailed
        If nothing else looks like a sheet.
    """
    if other:
        others = other_sheets(model, list(photos), [sheet.outline for sheet in sheets], other)
        if len(others) < other:
            raise StepFailed("Nothing else in the photos looks like a sheet.")
        return others[other - 1]
    if number > len(sheets):
        counted = "one sheet is" if len(sheets) == 1 else f"{len(sheets)} sheets are"
        raise UsageError(
            f"There is no sheet {number}: {counted} in view. Name one of them, or give its outline by hand (--sheet, "
            "--outline, or Sheet and Edit Outline in Blender)."
        )
    return sheets[number - 1]
