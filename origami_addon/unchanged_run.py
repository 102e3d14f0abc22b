"""Recognises a folder that already holds the results of a run."""

from __future__ import annotations

from pathlib import Path

from .files.json_files import parsed_json
from .files.marker import REPORT
from .own_results import is_as_reported
from .report import Report, versions


def unchanged_run(out: Path, report: Report) -> Report | None:
    """The earlier run of the same inputs with the same settings and code, if the folder holds it completely."""
    try:
        earlier = parsed_json(out / REPORT)
        same = (
            earlier["versions"] == versions()
            and earlier["settings"] == report.settings
            and earlier["inputs"] == report.inputs
            and all(is_as_reported(out / name, entry) for name, entry in earlier["outputs"].items())
            and not any(sheet["failure"] for sheet in earlier.get("sheets", []))
        )
        if not same:
            return None
        return Report(
            earlier["settings"],
            earlier["inputs"],
            earlier["stages"],
            earlier["warnings"],
            earlier["tried"],
            earlier["outputs"],
            number=earlier["number"],
            sheets=earlier.get("sheets", []),
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
