"""Which of several followed outlines is the sheet's, how probably it is right, and what makes it doubtful."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from ..arrays import Array
from ..numeric.polygon import filled_polygon
from .followed_edge import FollowedEdge

# Two outlines are one when they share this part of their union.
_SAME = 0.97
# The rivals' weight at which what they say counts half.
_UNKNOWN = 0.3
# Logarithm of the odds that an outline shares 0.98 of its union with the sheet. Fitted (logistic regression) to 210
# outlines that were followed from the sheet and its rivals in two photos of 22 generated scenes (seeds 1000 to 1021).
# With scenes left out of the fit in turn, of 44 photos the outline taken is wrong in two, with probabilities of .05 and
# .08; the right ones have .68 and more. Before, three were wrong, two of them without a warning, and three right ones
# had one.
_CONSTANT, _WEIGHTS = -0.2, {"open": -4.7, "ragged": -24.4, "at_frame": -8.9, "support": 7.9}
# By how much another outline must be more probable than the one where the sheet is expected.
_CLEARLY = 0.02
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
    "support": "The paper may end elsewhere: other lines in the photo may be its edge, within the outline or outside; "
    "look at the outline, and give it by hand if it is wrong (--outline, or Edit Outline in Blender).",
}
_NOT_THERE = (
    "It is uncertain which part of the photos is the sheet; look at the outline, and give it by hand if it is wrong "
    "(--outline, or Edit Outline in Blender)."
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
    open, ragged, at_frame : float
        Shares of its length, see `FollowedEdge`.
    support : float
        How far the other outlines agree with it; 0.5 where there are none.
    """

    open: float
    ragged: float
    at_frame: float
    support: float

    def figures(self) -> dict[str, float]:
        """Each sign as the probability depends on it: the first few places say most."""
        return {name: getattr(self, name) ** (1 if name == "support" else 0.5) for name in _WEIGHTS}

    def probability(self) -> float:
        """That an outline with these signs is right."""
        figures = self.figures()
        return float(expit(_CONSTANT + sum(_WEIGHTS[name] * figures[name] for name in _WEIGHTS)))

    def worst(self) -> str:
        """The sign that costs most against an outline of which nothing is doubtful."""
        cost = {name: _WEIGHTS[name] * (figure - (name == "support")) for name, figure in self.figures().items()}
        return min(cost, key=lambda name: cost[name])


def signs_of(
    followed: Sequence[FollowedEdge], agreement: Sequence[float], shape: tuple[int, ...], factor: int
) -> list[Signs]:
    """The signs of the outlines that were followed in a photo from the sheet and its rivals.

    Parameters
    ----------
    followed : sequence of FollowedEdge
    agreement : sequence of float
        `FoundSheet.agreement` of the region that each was followed from.
    shape : tuple of int
        Rows and columns of the reduced photo, in which outlines are compared.
    factor : int
        Pixels along the side of one of its pixels.
    """
    support = _support([edge.points / factor for edge in followed], np.sqrt(agreement), shape)
    return [
        Signs(float(edge.open.mean()), edge.ragged, float(edge.at_frame.mean()), float(share))
        for edge, share in zip(followed, support, strict=True)
    ]


def _support(outlines: Sequence[Array], weight: Array, shape: tuple[int, ...]) -> Array:
    """How far the others lead to each outline (K,), 0 to 1, 0.5 where there are none."""
    masks = np.array([filled_polygon(outline, shape).ravel() for outline in outlines])
    union = (masks[:, None] | masks).sum(axis=2)
    same = (masks[:, None] & masks).sum(axis=2) > _SAME * union
    others = weight * ~np.eye(len(masks), dtype=bool)
    return np.asarray(((others * same).sum(axis=1) + _UNKNOWN / 2) / (others.sum(axis=1) + _UNKNOWN))


def likeliest(signs: Sequence[Signs]) -> int:
    """Index of the outline that is most probably right; the first is where the sheet is expected."""
    probability = [each.probability() for each in signs]
    return int(np.argmax(probability)) if max(probability) > probability[0] + _CLEARLY else 0


def judge(signs: Signs, probability: float) -> Judgement:
    """How far an outline with these signs can be trusted, if the sheet is there at all with this probability."""
    right, there = signs.probability(), min(probability / _SURE_OF_SHEET, 1.0)
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
        reason = signs.worst()
        if there < right:
            notes.append(_NOT_THERE)
        elif reason in _REASONS:
            notes.append(_REASONS[reason].format(open=signs.open, ragged=signs.ragged))
    return Judgement(there * right, tuple(notes))
