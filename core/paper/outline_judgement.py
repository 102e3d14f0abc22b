"""Which of several followed outlines is the sheet's, how probably it is right, and what makes it doubtful."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from ..arrays import Array
from ..numeric.polygon import filled_polygon
from .followed_edge import FollowedEdge
from .sheet_search import FoundSheet

# Values without a figure are choices; no measurement of them is recorded.
# Two outlines are one when they share this part of their union.
SAME = 0.97
# The weight of others at which what they say counts half.
_UNKNOWN = 0.1
# Logarithm of the odds that an outline shares 0.98 of its union with the sheet: a constant, and what each sign adds.
# Fitted (logistic regression) to 230 outlines that were followed from the sheet and its rivals in two photos of 24
# generated scenes (seeds 1000 to 1023). With scenes left out of the fit in turn, of 48 photos the most probable outline
# is wrong in two, with probabilities of .21 and .36; the right ones have .78 and more. With the first outline and
# hand-made doubts three were wrong, two of them without a warning, and three right ones had one. Hardly any of these
# photos cuts the sheet off: "at frame" is the largest weight of several fits (-6.7 to -9.7), chosen after a
# scene of the benchmark (5) was wrong with the smallest.
# "Continued" is as heavy as "notch", a choice: of 47 generated scenes (1000 to 1040, 202, 206 to 216) outlines that end
# inside the sheet have shares of .13 to .35; right ones have none, but beside paper of the same colour .13, and in
# books, before the facing page, .2 to .34.
_CONSTANT = -0.2
_WEIGHTS = {
    "open": -4.3,
    "ragged": -20.4,
    "at_frame": -9.7,
    "continued": -9.0,
    "support": 8.3,
    "agreement": 0.15,
    "notch": -9.0,
}
# An outline that is open or ragged speaks less against others: by this share of what that adds to its own odds. With 0
# an outline that was right beside poor rivals was in doubt, with 1 a wrong one had a probability of .8.
_CREDIT = 0.5
# A region that fewer hypotheses agree with counts as if this many did.
_LEAST_AGREEMENT = 1e-3
# Logarithm of the odds by which another outline must be better than the one from where the sheet is expected. With
# less, a book's page with a faint gutter was given up for a worse outline (scene 12 of the benchmark); where another
# was right, it was 5 better. It counts in each of two photos: lines of print that look like the paper's edge do so in
# both (seed 140 of the generated scenes).
_CLEARLY = 2.0
# Shares of points that two photos' outlines have in common, from which on they are one and up to which they differ, and
# what that adds to the odds of a pair, or takes from them and from those of each.
_SAME_POINTS, _AGREE = (0.97, 0.9), 2.0
# From this probability of the sheet on its place is not in doubt.
_SURE_OF_SHEET = 0.75
# Below this probability a sentence says why.
_SURE = 0.5
# Shares of the outline at the border of the photo from which on a sentence says so, and says that it is all.
_AT_BORDER, _ALL_AT_BORDER = 0.01, 0.9

_REASONS = {
    "open": "Along {open:.0%} of its outline the paper hardly differs from what is beside it; look at the outline "
    "there.",
    "ragged": "The outline is ragged along {ragged:.0%} of its length, perhaps because it follows print instead of the "
    "paper's edge; look at the outline there.",
    "continued": "Along {continued:.0%} of its outline the paper seems to go on, in shade or under print; look at the "
    "outline there.",
    "notch": "The outline has a sharp inward corner, as where one paper lies upon another or a hand covers it; look at "
    "the outline there.",
    "support": "The paper may end elsewhere: other lines in the photo may be its edge, within the outline or outside; "
    "look at the outline, and give it by hand if it is wrong (--outline, or Edit Outline in Blender).",
}
_NOT_THERE = (
    "It is uncertain which part of the photos is the sheet; look at the outline, and give it by hand if it is wrong "
    "(--outline, or Edit Outline in Blender)."
)
_ELSEWHERE = (
    "Another photo shows the paper's edge elsewhere; look at the outline, and give it by hand if it is wrong "
    "(--outline, or Edit Outline in Blender)."
)
_DOUBTED = (
    "Another photo shows the same outline less clearly: it may follow print, a fold or a shadow; look at the outline, "
    "and give it by hand if it is wrong (--outline, or Edit Outline in Blender)."
)


@dataclass(frozen=True)
class Judgement:
    """How far an outline can be trusted.

    Attributes
    ----------
    confidence : float
        The probability that it is right, 0 to 1.
    notes : tuple of str
        A sentence for each thing that is unsure.
    """

    confidence: float
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Signs:
    """What speaks for and against a followed outline, each 0 to 1.

    Attributes
    ----------
    open, ragged, at_frame, continued : float
        Shares of its length, see `FollowedEdge`.
    support : float
        How far the other outlines agree with it; 0.5 where there are none.
    agreement : float
        `FoundSheet.agreement` of the region that it was followed from.
    notch : float
        See `FollowedEdge`.
    place : float
        The probability that the sheet is there: the highest `FoundSheet.probability` of the regions that lead to the
        outline. It says nothing about the outline itself.
    """

    open: float
    ragged: float
    at_frame: float
    continued: float
    support: float
    agreement: float
    notch: float
    place: float

    def figures(self) -> dict[str, float]:
        """Each sign as the probability depends on it: the first few places of an outline say most."""
        shares = {name: float(np.sqrt(getattr(self, name))) for name in ("open", "ragged", "at_frame", "continued")}
        agreement = float(np.log(max(self.agreement, _LEAST_AGREEMENT)))
        return shares | {"support": self.support, "agreement": agreement, "notch": self.notch}

    def odds(self) -> float:
        """Logarithm of the odds that an outline with these signs is right."""
        figures = self.figures()
        return _CONSTANT + sum(_WEIGHTS[name] * figures[name] for name in _WEIGHTS)

    def credit(self) -> float:
        """How much the outline says of others, 0 to 1."""
        figures = self.figures()
        own = ("open", "ragged", "at_frame", "continued", "notch")
        return float(np.exp(_CREDIT * sum(_WEIGHTS[name] * figures[name] for name in own)))

    def worst(self) -> str:
        """The sign that costs most against an outline of which nothing is doubtful."""
        cost = {name: _WEIGHTS[name] * (figure - (name == "support")) for name, figure in self.figures().items()}
        return min(cost, key=lambda name: cost[name])


@dataclass(frozen=True)
class OtherPhoto:
    """The likeliest outline in another photo.

    Attributes
    ----------
    signs : Signs
    agrees : float
        How far it is about the same paper, see `agreement_of_photos`.
    """

    signs: Signs
    agrees: float

    def adds(self, signs: Signs) -> float:
        """What it adds to the odds of an outline, logarithm.

        Two photos of one line of print agree on it, and are not two witnesses: where they agree, the mean of their odds
        counts. That the other photo cuts the sheet off says nothing against the rest.
        """
        if self.agrees <= 0:
            return self.agrees
        odds = replace(self.signs, at_frame=0.0).odds()
        return self.agrees / _AGREE * 0.5 * (odds - signs.odds())


def signs_of(
    followed: Sequence[FollowedEdge], regions: Sequence[FoundSheet], shape: tuple[int, ...], factor: int
) -> list[Signs]:
    """The signs of the outlines that were followed in a photo from the sheet and its rivals.

    Parameters
    ----------
    followed : sequence of FollowedEdge
    regions : sequence of FoundSheet
        The region that each was followed from.
    shape : tuple of int
        Rows and columns of the reduced photo, in which outlines are compared.
    factor : int
        Pixels along the side of one of its pixels.
    """
    same = _same([edge.points / factor for edge in followed], shape)
    probability = np.array([region.probability for region in regions])
    place = np.where(same, probability, 0.0).max(axis=1)
    alone = [
        Signs(
            open=float(edge.open.mean()),
            ragged=edge.ragged,
            at_frame=float(edge.at_frame.mean()),
            continued=float(edge.continued.mean()),
            support=0.5,
            agreement=region.agreement,
            notch=edge.notch,
            place=float(there),
        )
        for edge, region, there in zip(followed, regions, place, strict=True)
    ]
    weight = np.array([np.sqrt(signs.agreement) * signs.credit() for signs in alone])
    support = _support(same, weight)
    return [replace(signs, support=float(share)) for signs, share in zip(alone, support, strict=True)]


def _same(outlines: Sequence[Array], shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Which outlines (K, 2) of a photo are one, (K, K)."""
    masks = np.array([filled_polygon(outline, shape).ravel() for outline in outlines])
    union = (masks[:, None] | masks).sum(axis=2)
    one = (masks[:, None] & masks).sum(axis=2) > SAME * union
    return np.asarray(one | np.eye(len(masks), dtype=bool))


def _support(same: NDArray[np.bool_], weight: Array) -> Array:
    """How far the others lead to each outline (K,), 0 to 1, 0.5 where there are none."""
    others = weight * ~np.eye(len(same), dtype=bool)
    return np.asarray(((others * same).sum(axis=1) + _UNKNOWN / 2) / (others.sum(axis=1) + _UNKNOWN))


def likeliest(signs: Sequence[Signs]) -> int:
    """Index of the outline that is most probably right; the first is where the sheet is expected."""
    return int(np.argmax(_odds_with_place(signs)))


def likeliest_pair(first: Sequence[Signs], second: Sequence[Signs], shared: Array) -> tuple[int, int]:
    """Which outline in each of two photos is right: they must be about the same paper.

    Parameters
    ----------
    first, second : sequences of Signs
        Of the outlines in each photo.
    shared : (K, L) array
        What each outline of the first photo and each of the second have in common, see `agreement_of_photos`.
    """
    odds = _odds_with_place(first)[:, None] + _odds_with_place(second) + agreement_of_photos(shared)
    one, other = np.unravel_index(int(odds.argmax()), odds.shape)
    return int(one), int(other)


def agreement_of_photos(shared: Array) -> Array:
    """What two photos' outlines add to each other's odds, logarithm, by the share of points that both have within.

    Parameters
    ----------
    shared : array
        Points of the sparse model within both outlines, as a part of those within either; NaN if that says nothing.
    """
    same, other = _SAME_POINTS
    return np.nan_to_num(_AGREE * np.clip(2 * (shared - other) / (same - other) - 1, -1, 1))


def _odds_with_place(signs: Sequence[Signs]) -> Array:
    """Logarithm of the odds of the outlines in a photo; the first is where the sheet is expected."""
    odds = np.array([each.odds() for each in signs])
    odds[0] += _CLEARLY
    return odds


def judge(signs: Signs, other: OtherPhoto | None = None) -> Judgement:
    """How far an outline with these signs can be trusted, and with those in another photo."""
    odds = signs.odds() + (other.adds(signs) if other else 0.0)
    right, there = float(expit(odds)), min(signs.place / _SURE_OF_SHEET, 1.0)
    notes = []
    if signs.at_frame > _ALL_AT_BORDER:
        notes.append(
            "The whole photo was taken for the sheet, because hardly anything at its border differs from the paper; "
            "if the sheet ends within the photo, give the outline by hand."
        )
    elif signs.at_frame > _AT_BORDER:
        notes.append(
            f"The sheet reaches the border of the photo along {signs.at_frame:.0%} of its outline; "
            "a photo that shows all of it is better."
        )
    if there * right < _SURE:
        reason = _NOT_THERE if there < right else _REASONS.get(signs.worst(), _REASONS["support"])
        if other and expit(signs.odds()) >= _SURE > right:
            reason = _ELSEWHERE if other.agrees < 0 else _DOUBTED
        notes.append(reason.format(open=signs.open, ragged=signs.ragged, continued=signs.continued))
    return Judgement(there * right, tuple(notes))
