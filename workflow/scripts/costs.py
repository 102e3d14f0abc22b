"""What the documents of a batch cost, added up, and what a collection of such documents would cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import stdtrit

# How sure the range of a mean is.
_SURE = 0.95
_EXAMPLE = 1000  # documents
_HOUR = 3600.0


@dataclass(frozen=True)
class Mean:
    """The mean of a cost per document, and the range in which that of many such documents lies (95 %)."""

    value: float
    least: float
    most: float

    def times(self, number: float) -> Mean:
        """The sum over a number of such documents."""
        return Mean(self.value * number, self.least * number, self.most * number)


@dataclass(frozen=True)
class Prediction:
    """What a document costs.

    Attributes
    ----------
    documents : int
        From how many documents this is known.
    seconds, cpu_seconds, results_bytes : Mean
        Of one document: from its start to its end, of processors, of the files that stay.
    memory_mb : float
        That of the largest process of any document.
    total : dict of str to float
        The sums over the documents.
    """

    documents: int
    seconds: Mean
    cpu_seconds: Mean
    results_bytes: Mean
    memory_mb: float
    total: dict[str, float]

    def sentence(self) -> str:
        """For the terminal."""
        hours, size = self.seconds.times(_EXAMPLE / _HOUR), self.results_bytes.times(_EXAMPLE)
        return (
            f"A document took {self.seconds.value:.0f} s ({self.cpu_seconds.value:.0f} s of a processor) on average of "
            f"{self.documents}; {_EXAMPLE} such documents would take {hours.value:.1f} hours one after the other "
            f"({hours.least:.1f} to {hours.most:.1f}), divided by as many as run at once, {size_of(size.value)} of "
            f"disk for the results, and {self.memory_mb:.0f} MB of memory for each that runs."
        )


def predict(costs: Sequence[Mapping[str, Any]]) -> Prediction | None:
    """What a document costs, from those that ran, failed ones included; None if none has.

    The range assumes that the documents to come are like these.
    """
    if not costs:
        return None
    known = {name: np.array([each.get(name) or 0 for each in costs], float) for name in _NAMES}
    means = {name: _mean(known[name]) for name in ("seconds", "cpu_seconds", "results_bytes")}
    total = {name: float(values.sum()) for name, values in known.items() if name != "peak_memory_mb"}
    return Prediction(len(costs), **means, memory_mb=float(known["peak_memory_mb"].max()), total=total)


_NAMES = ("seconds", "cpu_seconds", "results_bytes", "peak_memory_mb", "read_bytes", "written_bytes")


def _mean(values: np.ndarray) -> Mean:
    mean, count = float(values.mean()), len(values)
    if count < 2:
        return Mean(mean, 0.0, float("inf"))
    reach = float(stdtrit(count - 1, (1 + _SURE) / 2) * values.std(ddof=1) / count**0.5)
    return Mean(mean, max(mean - reach, 0.0), mean + reach)


def size_of(number: float) -> str:
    """A number of bytes for people."""
    for unit in ("bytes", "kB", "MB", "GB"):
        if number < 1000:
            return f"{number:.3g} {unit}"
        number /= 1000
    return f"{number:.3g} TB"
