"""A possible cause of photos that cannot be placed, and what is said of the likeliest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

# A second cause is named if its likelihood is at least this share of the first one's.
_NEAR = 0.5
# No measurement makes a cause likelier than this: they are of different kinds, and none is proof.
MOST_LIKELY = 4.0


@dataclass(frozen=True)
class Cause:
    """A possible cause of photos that cannot be placed.

    Attributes
    ----------
    claim : str
        What is wrong and what was measured: the start of a sentence, without its full stop.
    remedy : str
        What to do about it, the rest of that sentence.
    likelihood : float
        The measurement relative to the limit above which it points to the cause.
    evidence : dict
        The figures, for the log.
    explains_few_points : bool
        Whether this cause alone explains why a model has no depth.
    """

    claim: str
    remedy: str
    likelihood: float
    evidence: dict[str, Any] = field(default_factory=dict)
    explains_few_points: bool = False


def ranked(causes: Sequence[Cause | None]) -> list[Cause]:
    """The causes that have evidence, the likeliest first."""
    found = (cause for cause in causes if cause is not None and cause.likelihood > 0)
    return sorted(found, key=lambda cause: -cause.likelihood)


def sentence(causes: Sequence[Cause]) -> str:
    """The first cause with its remedy, and the second if it is nearly as likely.

    Parameters
    ----------
    causes : sequence of Cause
        Ranked; at least one.
    """
    first, *others = causes
    text = f"{first.claim}: {first.remedy}."
    if others and others[0].likelihood >= _NEAR * first.likelihood:
        text += f" Or {others[0].claim[:1].lower()}{others[0].claim[1:]}: then {others[0].remedy}."
    return text
