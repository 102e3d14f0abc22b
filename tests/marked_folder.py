"""A folder of results as a run that was killed leaves it."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

from origami.origami_addon.files.marker import LOCK, MARKER, claim


def mark(out: Path, names: Iterable[str]) -> None:
    """Mark the names as of the command line, with the lock of the run left behind."""
    claim(out, names)
    number = json.loads((out / MARKER).read_text(encoding="utf-8"))["number"]
    (out / LOCK).write_text(json.dumps({"application": "Origami", "number": number}), encoding="utf-8")
