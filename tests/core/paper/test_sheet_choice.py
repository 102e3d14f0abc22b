"""A sheet is taken by its number, or a region that is none of those in view."""

from __future__ import annotations

import numpy as np
import pytest
from flat_scene import model
from origami.core.errors import StepFailed, UsageError
from origami.core.paper import sheet_choice
from origami.core.paper.sheet_choice import choose_sheet
from origami.core.paper.sheet_search import FoundSheet


def sheet(number: int) -> FoundSheet:
    return FoundSheet(np.full((4, 3), float(number)), np.zeros(0, bool), 0.9, 0.9)


SHEETS = [sheet(1), sheet(2)]


def test_the_number_counts_from_one():
    assert choose_sheet(model(), [], SHEETS, 1) is SHEETS[0]
    assert choose_sheet(model(), [], SHEETS, 2) is SHEETS[1]


def test_a_number_too_large_says_how_many_there_are():
    with pytest.raises(UsageError, match=r"There is no sheet 3: 2 sheets are in view"):
        choose_sheet(model(), [], SHEETS, 3)
    with pytest.raises(UsageError, match=r"There is no sheet 2: one sheet is in view"):
        choose_sheet(model(), [], SHEETS[:1], 2)


def test_another_region_is_none_of_the_sheets(monkeypatch):
    asked = []

    def other_sheets(scene, photos, taken, most):
        asked.append([float(edge[0, 0]) for edge in taken])
        return (sheet(7), sheet(8))[:most]

    monkeypatch.setattr(sheet_choice, "other_sheets", other_sheets)
    assert choose_sheet(model(), [], SHEETS, 1, other=2).outline[0, 0] == 8
    assert asked == [[1, 2]]
    with pytest.raises(StepFailed, match="Nothing else"):
        choose_sheet(model(), [], SHEETS, 1, other=3)
