"""In which photos the edge is looked for, and which one is taken."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from flat_scene import model
from origami.core.errors import StepFailed
from origami.core.numeric.polygon import signed_area
from origami.core.paper import reference_outline
from origami.core.paper.followed_edge import FollowedEdge
from origami.core.paper.outline import FollowedOutlines, Outline
from origami.core.paper.outline_judgement import Signs
from origami.core.paper.reference_outline import find_reference_outline, given_outline
from origami.core.paper.sheet_search import FoundSheet
from scipy.special import logit

SHEET = FoundSheet(np.zeros((4, 3)), np.zeros(0, bool), 0.9, 0.9)
PHOTOS = [np.full((2, 2, 3), index, np.uint8) for index in range(4)]


NOWHERE = np.zeros((4, 2))


def signs(sure: float) -> Signs:
    """Signs of an outline that is right with this probability."""
    shares = {"open": 0.0, "ragged": 0.0, "at_frame": 0.0, "continued": 0.0, "support": 0.0, "notch": 0.0}
    nothing = Signs(**shares, agreement=1.0, place=1.0)
    each = replace(nothing, support=1.0).odds() - nothing.odds()
    return replace(nothing, support=(float(logit(sure)) - nothing.odds()) / each)


def followed(*outlines: tuple[float, np.ndarray]) -> FollowedOutlines:
    """Outlines of one photo: how sure each is, and its polygon."""
    edges = [FollowedEdge.guess(polygon, np.array([9.0, 9.0])) for _, polygon in outlines]
    return FollowedOutlines(edges, [signs(sure) for sure, _ in outlines])


@pytest.fixture
def find(monkeypatch):
    """Looks for the edge where photo 2 is the best reference, then 0, 1 and 3; ``shown`` is what each shows.

    That is how sure its edge is, None if it does not show the sheet, or the outlines that were followed.
    """

    def look(shown: dict[int, float | FollowedOutlines | None], **options):
        def follow_outlines(photo, camera, sheet, threads):
            index = int(photo[0, 0, 0])
            assert camera.name == f"{index}.jpg"
            each = shown[index]
            if each is None:
                raise StepFailed("The sheet hardly shows.")
            return each if isinstance(each, FollowedOutlines) else followed((each, NOWHERE))

        def settled(photo, edge, judgement):
            return Outline(edge.points, judgement.confidence, (f"in {photo[0, 0, 0]}",))

        monkeypatch.setattr(reference_outline, "follow_outlines", follow_outlines)
        monkeypatch.setattr(reference_outline, "settled", settled)
        monkeypatch.setattr(reference_outline, "rank_references", lambda *_: np.array([2, 0, 1, 3]))
        return find_reference_outline(model(), PHOTOS, [], SHEET, **options)

    return look


def test_a_clear_edge_in_the_best_photo_is_enough(find):
    found = find({2: 0.95})
    assert found.reference == 2
    assert found.outline.notes == ("in 2",)
    assert found.tried == pytest.approx({2: 0.95})


def test_an_unclear_one_is_looked_for_in_the_next_photo_too(find):
    assert find({2: 0.6, 0: 0.8}).reference == 0
    found = find({2: 0.6, 0: 0.5})
    assert found.reference == 2
    assert found.tried == pytest.approx({2: 0.6, 0: 0.5})


def test_a_next_photo_without_the_sheet_does_not_matter(find):
    found = find({2: 0.6, 0: None})
    assert found.reference == 2
    assert found.tried == pytest.approx({2: 0.6})


def test_a_best_photo_without_the_sheet_is_reported(find):
    with pytest.raises(StepFailed, match="hardly shows"):
        find({2: None, 0: 0.9})


def test_photos_that_are_left_out(find):
    assert find({0: 0.95}, without={2}).reference == 0
    with pytest.raises(StepFailed, match="No other photo"):
        find({}, without={0, 1, 2, 3})


def test_a_reference_that_is_given_is_the_only_one(find):
    assert find({3: 0.1}, reference=3).tried == pytest.approx({3: 0.1})


def test_a_given_outline_goes_clockwise_on_screen():
    corners = np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]])
    for given in (corners, corners[::-1]):
        outline = given_outline(given)
        assert signed_area(outline.polygon) == 81
        assert (outline.confidence, outline.notes) == (1.0, ())


def around(index: int, *, left: bool = False) -> np.ndarray:
    """A rectangle of photo ``index`` around all points of the model, or around their left half."""
    pixels = model().cameras[index].project(model().points)
    (x0, y0), (x1, y1) = pixels.min(axis=0) - 1, pixels.max(axis=0) + 1
    x1 = (x0 + x1) / 2 if left else x1
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])


def test_the_outlines_that_two_photos_agree_on_are_taken(find):
    best = followed((0.4, around(2)), (0.3, around(2, left=True)))
    next_best = followed((0.6, NOWHERE), (0.5, around(0)))
    found = find({2: best, 0: next_best})
    assert found.reference == 0
    np.testing.assert_allclose(found.outline.polygon, around(0))
    assert found.outline.confidence == pytest.approx(0.4, abs=0.06)  # between .3 and .5


def test_outlines_of_two_photos_that_differ_are_in_doubt(find):
    found = find({2: followed((0.7, around(2))), 0: followed((0.6, around(0, left=True)))})
    assert found.reference == 2
    assert found.outline.confidence < 0.5
