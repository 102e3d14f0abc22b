"""In which photos the edge is looked for, and which one is taken."""

from __future__ import annotations

import numpy as np
import pytest
from flat_scene import model
from origami.core.errors import StepFailed
from origami.core.numeric.polygon import signed_area
from origami.core.paper import reference_outline
from origami.core.paper.outline import Outline
from origami.core.paper.reference_outline import find_reference_outline, given_outline
from origami.core.paper.sheet_search import FoundSheet

SHEET = FoundSheet(np.zeros((4, 3)), np.zeros(0, bool), 0.9, 0.9)
PHOTOS = [np.full((2, 2, 3), index, np.uint8) for index in range(4)]


@pytest.fixture
def find(monkeypatch):
    """Looks for the edge where photo 2 is the best reference, then 0, 1 and 3; ``sure`` is how clear it is in each."""

    def look(sure: dict[int, float | None], **options):
        def find_outline(photo, camera, sheet, threads):
            index = int(photo[0, 0, 0])
            assert camera.name == f"{index}.jpg"
            if sure[index] is None:
                raise StepFailed("The sheet hardly shows.")
            return Outline(np.zeros((4, 2)), sure[index], (f"in {index}",))

        monkeypatch.setattr(reference_outline, "find_outline", find_outline)
        monkeypatch.setattr(reference_outline, "rank_references", lambda *_: np.array([2, 0, 1, 3]))
        return find_reference_outline(model(), PHOTOS, [], SHEET, **options)

    return look


def test_a_clear_edge_in_the_best_photo_is_enough(find):
    found = find({2: 0.95})
    assert found.reference == 2
    assert found.outline.notes == ("in 2",)
    assert found.tried == {2: 0.95}


def test_an_unclear_one_is_looked_for_in_the_next_photo_too(find):
    assert find({2: 0.6, 0: 0.8}).reference == 0
    found = find({2: 0.6, 0: 0.5})
    assert found.reference == 2
    assert dict(found.tried) == {2: 0.6, 0: 0.5}


def test_a_next_photo_without_the_sheet_does_not_matter(find):
    found = find({2: 0.6, 0: None})
    assert (found.reference, dict(found.tried)) == (2, {2: 0.6})


def test_a_best_photo_without_the_sheet_is_reported(find):
    with pytest.raises(StepFailed, match="hardly shows"):
        find({2: None, 0: 0.9})


def test_photos_that_are_left_out(find):
    assert find({0: 0.95}, without={2}).reference == 0
    with pytest.raises(StepFailed, match="No other photo"):
        find({}, without={0, 1, 2, 3})


def test_a_reference_that_is_given_is_the_only_one(find):
    assert dict(find({3: 0.1}, reference=3).tried) == {3: 0.1}


def test_a_given_outline_goes_clockwise_on_screen():
    corners = np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]])
    for given in (corners, corners[::-1]):
        outline = given_outline(given)
        assert signed_area(outline.polygon) == 81
        assert (outline.confidence, outline.notes) == (1.0, ())
