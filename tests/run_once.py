"""What tests know of the one whole run that they share."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class FinishedRun:
    """Where a run's results lie, and how it ended."""

    out: Path
    exit_code: int
