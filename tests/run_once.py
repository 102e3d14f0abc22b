"""The whole run that tests share."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class FinishedRun:
    """The photos of a run, the folder of its results, and how it ended."""

    photos: Path
    out: Path
    exit_code: int
