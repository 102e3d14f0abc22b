"""Which of several followed outlines is taken, and what is said of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from origami.core.numeric.polygon import resample
from origami.core.paper.followed_edge import FollowedEdge
from origami.core.paper.outline_judgement import (
    OtherPhoto,
    Signs,
    agreement_of_photos,
    judge,
    likeliest,
    likeliest_pair,
    signs_of,
)
from origami.core.paper.sheet_search import FoundSheet
from scipy.special import logit

SHAPE = (120, 160)
FACTOR = 2


def edge(left: float = 20, right: float = 120, *, is_open: float = 0, ragged: float = 0, at_frame: float = 0):
    """A clear edge around a rectangle, pixels of the reduced photo; the shares are of its places."""
    corners = np.array([[left, 20], [right, 20], [right, 100], [left, 100]])
    points = resample(corners * FACTOR, 2.0)
    place = np.arange(len(points)) / len(points)
    near = place < at_frame
    is_open = (place < at_frame + is_open) & ~near
    return FollowedEdge(points, np.full(len(points), 20.0), near, is_open, np.zeros(len(points), bool), ragged, 0.0)


def judged(*followed, agreement=(0.9, 0.05, 0.04, 0.01), probability=(1.0, 1.0, 1.0, 1.0)):
    nothing = np.zeros((0, 3)), np.zeros(0, bool)
    regions = [FoundSheet(*nothing, *each) for each in zip(probability, agreement, strict=False)]
    signs = signs_of(followed, regions[: len(followed)], SHAPE, FACTOR)
    best = likeliest(signs)
    return followed[best], judge(signs[best])


def test_an_outline_that_all_lead_to_is_sure():
    taken, judgement = judged(edge(), edge(20.2), edge(19.9))
    assert judgement.confidence > 0.95
    assert judgement.notes == ()
    assert taken.points[:, 0].min() == 40


def test_an_outline_that_the_rivals_lead_to_beats_the_first():
    taken, judgement = judged(edge(is_open=0.2), edge(10, 140), edge(10, 140.3), edge(10.2, 140))
    assert taken.points[:, 0].max() > 270
    assert judgement.notes == ()


def test_an_outline_that_only_unlikely_regions_lead_to_is_in_doubt():
    """A box of text on a poster: its edge is clearer than the poster's, which all that is known of it speaks for."""
    followed = edge(0, 150, is_open=0.02, ragged=0.01), edge(), edge(20.2)
    taken, judgement = judged(*followed, agreement=(0.7, 0.2, 0.1, 0), probability=(0.7, 0.3, 0.3, 0))
    assert taken.points[:, 0].min() > 30
    assert judgement.confidence < 0.5
    assert [note for note in judgement.notes if note.startswith("It is uncertain which part")]


def test_an_outline_that_a_likely_region_leads_to_as_well_is_not():
    _, judgement = judged(edge(), edge(20.2), edge(10, 140), probability=(0.2, 0.9, 0.1, 0.1))
    assert judgement.notes == ()


def test_rivals_that_lead_elsewhere_are_mentioned():
    sides = (20, 120), (10, 140), (40, 100), (20, 80)
    _, judgement = judged(*(edge(*each, is_open=0.05) for each in sides), agreement=(0.5, 0.3, 0.15, 0.05))
    assert judgement.confidence < 0.5
    assert [note for note in judgement.notes if "may end elsewhere" in note]


def test_the_reason_that_weighs_most_is_mentioned():
    _, ragged = judged(edge(ragged=0.1), agreement=(1.0,))
    assert "ragged along 10%" in " ".join(ragged.notes)
    _, faint = judged(edge(is_open=1.0), agreement=(1.0,))
    assert "hardly differs" in " ".join(faint.notes)


def test_a_rival_that_follows_no_edge_is_not_taken():
    guess = FollowedEdge.guess(edge(10, 140).points, np.array([320.0, 240.0]))
    assert guess.guessed
    taken, _ = judged(edge(is_open=0.1), guess)
    assert not taken.guessed


@pytest.mark.parametrize(("at_frame", "text"), [(0.2, "reaches the border"), (0.95, "whole photo was taken")])
def test_a_sheet_that_leaves_the_photo_is_mentioned_however_sure(at_frame, text):
    _, judgement = judged(edge(at_frame=at_frame), edge(at_frame=at_frame))
    assert text in " ".join(judgement.notes)


def test_poor_outlines_say_little_against_a_clear_one():
    """A receipt with a barcode at its end: from elsewhere ragged outlines end at the barcode."""
    ragged = [edge(20, 110, ragged=0.05), edge(20, 109, ragged=0.1), edge(20, 112, is_open=0.1, ragged=0.03)]
    taken, judgement = judged(edge(is_open=0.01), *ragged)
    assert taken.points[:, 0].max() > 239
    assert judgement.confidence > 0.8


@pytest.mark.parametrize("sign", ["open", "ragged", "at_frame", "continued", "support", "agreement", "notch"])
def test_whatever_makes_an_outline_unsure_is_put_into_words(sign):
    nothing = Signs(
        open=0.0, ragged=0.0, at_frame=0.0, continued=0.0, support=0.1, agreement=0.01, notch=0.0, place=1.0
    )
    signs = replace(nothing, **{sign: {"support": 0.0, "agreement": 0.0}.get(sign, 0.5)})
    judgement = judge(signs)
    assert judgement.confidence < 0.5
    assert judgement.notes


def test_a_sheet_that_may_not_be_there_is_never_sure():
    _, judgement = judged(edge(), edge(), probability=(0.2, 0.2, 0.2, 0.2))
    assert judgement.confidence < 0.3
    assert "uncertain which part" in " ".join(judgement.notes)


def signs(support: float) -> Signs:
    shares = {"open": 0.0, "ragged": 0.0, "at_frame": 0.0, "continued": 0.0, "notch": 0.0}
    return Signs(**shares, support=support, agreement=1.0, place=1.0)


def test_outlines_of_two_photos_that_agree_are_taken_though_one_has_a_likelier_one():
    first, second = [signs(0.5), signs(0.45)], [signs(0.55), signs(0.5)]
    assert (likeliest(first), likeliest(second)) == (0, 0)
    assert likeliest_pair(first, second, np.array([[0.6, 0.99], [0.65, 0.7]])) == (0, 1)
    assert likeliest_pair(first, second, np.full((2, 2), np.nan)) == (0, 0)


def test_where_both_photos_show_the_sheet_as_expected_rivals_that_agree_too_are_not_taken():
    first, second = [signs(0.2), signs(0.4)], [signs(0.2), signs(0.4)]
    assert likeliest_pair(first, second, np.array([[0.99, 0.7], [0.7, 0.99]])) == (0, 0)


def test_photos_agree_by_the_points_that_both_outlines_share():
    added = agreement_of_photos(np.array([1.0, 0.97, 0.935, 0.9, 0.2, np.nan]))
    np.testing.assert_allclose(added, [2, 2, 0, -2, -2, 0], atol=1e-9)


def test_a_photo_that_agrees_counts_as_much_as_the_outline_itself_and_one_that_differs_against_it():
    alone = judge(signs(0.1)).confidence
    poor, sure, differs = (
        judge(signs(0.1), OtherPhoto(signs(support), agreement)).confidence
        for support, agreement in ((0.0, 2.0), (0.9, 2.0), (0.9, -2.0))
    )
    assert poor < alone < sure
    assert differs < alone
    between = logit(judge(signs(0.1)).confidence) + logit(judge(signs(0.3)).confidence)
    agreed = judge(signs(0.1), OtherPhoto(signs(0.3), 2.0)).confidence
    assert logit(agreed) == pytest.approx(between / 2)


def test_two_photos_of_one_doubtful_line_do_not_make_it_sure():
    judgement = judge(signs(0.05), OtherPhoto(replace(signs(0.0), ragged=0.05), 2.0))
    assert judgement.confidence < 0.4
    assert judgement.notes
    assert "elsewhere; look" not in " ".join(judgement.notes)
    assert "Another photo shows the same outline less clearly" in " ".join(judgement.notes)


def test_that_another_photo_cuts_the_sheet_off_says_nothing_against_its_edge_in_this_one():
    cut_off = OtherPhoto(replace(signs(0.3), at_frame=0.25), 2.0)
    assert judge(signs(0.3), cut_off).confidence == pytest.approx(judge(signs(0.3)).confidence)


def test_an_edge_that_another_photo_shows_elsewhere_is_mentioned():
    judgement = judge(signs(0.15), OtherPhoto(signs(0.15), -2.0))
    assert "Another photo shows the paper's edge elsewhere" in " ".join(judgement.notes)
