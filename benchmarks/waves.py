"""How far straight lines of the original are from straight on a page."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..core.arrays import Array

# A line counts if this share of it is known. Its largest departure is this percentile.
_LEAST_KNOWN = 0.7
_LARGEST = 99.0


@dataclass(frozen=True)
class Waves:
    """Departure of lines from their own best straight lines.

    Attributes
    ----------
    lines : int
        How many lines count; without any, the figures are NaN.
    rms : float
        Over all places of all lines.
    worst : float
        The largest on the worst line.
    """

    lines: int
    rms: float
    worst: float


def waves(lines: Iterable[Array]) -> Waves:
    """Waves of lines, each given by its displacement (N,) across it at even distances; NaN where it is not known."""
    departures = []
    for line in lines:
        known = np.isfinite(line)
        if len(line) < 3 or known.mean() < _LEAST_KNOWN:
            continue
        along = np.linspace(-1, 1, len(line))[known]
        departures.append(line[known] - np.polynomial.Polynomial.fit(along, line[known], 1)(along))
    if not departures:
        return Waves(0, np.nan, np.nan)
    worst = max(np.percentile(np.abs(departure), _LARGEST) for departure in departures)
    return Waves(len(departures), float(np.sqrt((np.concatenate(departures) ** 2).mean())), float(worst))
