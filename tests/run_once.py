"""The whole run that tests share."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class FinishedRun:
    """The folder of a run's results, and how it ended."""

    out: Path
    exit_code: int
