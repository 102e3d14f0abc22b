"""The summary of a batch: summary.csv, summary.html and small pictures, from what each document's folder holds.

.venv/bin/python workflow/scripts/summary.py OUT
blender -b -P workflow/scripts/summary.py -- OUT

It can be written at any time, also while documents are still being made.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import os
import runpy
import sys
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
from costs import Prediction, predict
from summary_page import page_of

ROOT = Path(__file__).resolve().parents[2]
runpy.run_path(str(ROOT / "headless" / "checkout.py"))["load_checkout"]()
from origami.origami_addon.window.quality import confidence, measures  # noqa: E402 - once the checkout is loaded

DONE, FAILED, UNFINISHED = "done", "failed", "not finished"
# Where record.py writes what became of a document, and the small pictures go.
BATCH = "batch"
_FAILED = ".failed"
# The steps of a document in their order, and the name of all of them in one; receipts of others are only costs.
STEPS, WHOLE = ("place", "sheet", "page"), "document"
PICTURES = ("page.jpg", "outline.jpg")
THUMBNAIL = 240  # pixels, the longer side
COLUMNS = (
    *("document", "state", "look", "quality", "reason", "warnings", "measures", "photos", "photos_placed", "reference"),
    *("width_px", "height_px", "dpi", "dpi_source", "seconds", "cpu_seconds", "peak_memory_mb", "read_bytes"),
    *("written_bytes", "results_bytes", "folder", "photos_in"),
)


@dataclass
class Row:
    """What became of a document.

    Attributes
    ----------
    document : str
        The name of its folder of results.
    state : {"done", "failed", "not finished"}
    quality : {"good", "fair", "poor", ""}
    reason : str
        The sentence with which it failed.
    warnings, measures : list of str
    figures : dict
        Of the stages of the run and of its costs, by the names of the columns.
    pictures : dict of str to str
        The small picture of each large one, relative to the folder of all results.
    """

    document: str
    state: str = UNFINISHED
    quality: str = ""
    reason: str = ""
    warnings: list[str] = field(default_factory=list)
    measures: list[str] = field(default_factory=list)
    figures: dict[str, Any] = field(default_factory=dict)
    pictures: dict[str, str] = field(default_factory=dict)

    @property
    def look(self) -> bool:
        """Whether somebody ought to look at it."""
        return self.state != DONE or self.quality != "good" or bool(self.warnings)

    def cells(self) -> dict[str, Any]:
        """The row of the table."""
        return self.figures | {
            "document": self.document,
            "state": self.state,
            "look": "yes" if self.look else "no",
            "quality": self.quality,
            "reason": self.reason,
            "warnings": " | ".join(self.warnings),
            "measures": " | ".join(self.measures),
        }


def main(argv: Sequence[str]) -> int:
    """Write the summary; returns the exit code."""
    parser = argparse.ArgumentParser(prog="summary.py", description="Write summary.csv and summary.html of a batch.")
    parser.add_argument("out", type=Path, metavar="OUT", help="the folder with a folder for each document")
    parser.add_argument(
        "--documents",
        metavar="FILE",
        help="the documents as JSON, [{name, folder}, ...], - for standard input; without it, all folders in OUT that "
        "a batch has written into",
    )
    given = parser.parse_args(argv)
    out = given.out.absolute()
    rows = [_row(out, each["name"], each.get("folder", "")) for each in _listed(given.documents, out)]
    prediction = predict([row.figures for row in rows if row.figures.get("seconds")])
    _write(out / "summary.csv", "\ufeff" + _table(rows))  # the mark by which Excel knows UTF-8
    _write(out / "summary.html", page_of(rows, prediction, PICTURES))
    print(_in_a_sentence(rows, prediction, out).encode(errors="backslashreplace").decode())
    return 0


def _listed(named: str | None, out: Path) -> list[dict[str, str]]:
    if named is None:
        found = [path for path in sorted(out.iterdir()) if (path / BATCH).is_dir() or (path / "report.json").is_file()]
        return [{"name": path.name} for path in found]
    text = sys.stdin.read() if named == "-" else Path(named).read_text(encoding="utf-8")
    return list(json.loads(text))


def _row(out: Path, name: str, photos: str) -> Row:
    row, folder = Row(name), out / name
    receipts = {path.stem: content for path in sorted((folder / BATCH).glob("*.json")) if (content := _json(path))}
    finished = _add_report(row, _json(folder / "report.json") or {})
    failures = {key.removesuffix(_FAILED): receipts.pop(key) for key in list(receipts) if key.endswith(_FAILED)}
    _add_costs(row, [*receipts.values(), *failures.values()])
    if failures:
        first = min(failures, key=lambda step: STEPS.index(step) if step in STEPS else len(STEPS))
        row.state, row.reason = FAILED, str(failures[first].get("sentence", ""))
    elif finished and (receipts.keys() >= set(STEPS) or WHOLE in receipts or not receipts):
        row.state = DONE
    row.figures |= {"folder": str(folder), "photos_in": photos}
    if row.state == DONE:
        row.pictures = {picture: small for picture in PICTURES if (small := _thumbnail(out, name, picture))}
    return row


def _json(path: Path) -> dict[str, Any] | None:
    """The object in a JSON file; None if there is none: the engine makes empty files of logs that were not written."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return content if isinstance(content, dict) else None


def _add_report(row: Row, report: Mapping[str, Any]) -> bool:
    """What the report of a run says; False if it is none."""
    try:
        figures = {name: value for stage in report["stages"] for name, value in stage["figures"].items()}
        judged, warnings = measures(figures), [str(warning) for warning in report["warnings"]]
        size = sum(entry["bytes"] for entry in report["outputs"].values())
    except (KeyError, TypeError, AttributeError, ValueError):
        return False
    row.quality, row.measures = confidence(judged), [each.text for each in judged if each.verdict != "good"]
    row.warnings = warnings
    row.figures |= {name: figures[name] for name in COLUMNS if name in figures} | {"results_bytes": size}
    return True


def _add_costs(row: Row, receipts: Sequence[Mapping[str, Any]]) -> None:
    """Add up the costs of the commands, and those that only the stages know."""
    stages = [stage for receipt in receipts for stage in receipt.get("stages", [])]
    for name in ("seconds", "cpu_seconds"):
        row.figures[name] = round(sum(receipt.get(name) or 0 for receipt in receipts), 1)
    row.figures["peak_memory_mb"] = max((receipt.get("peak_memory_mb") or 0 for receipt in receipts), default=0)
    for name in ("read_bytes", "written_bytes"):
        row.figures[name] = sum(stage.get(name) or 0 for stage in stages)


def _thumbnail(out: Path, name: str, picture: str) -> str | None:
    """The small picture of a large one, made unless it is newer; None if there is no large one that can be read."""
    large, small = out / name / picture, out / name / BATCH / picture
    try:
        if not small.exists() or small.stat().st_mtime < large.stat().st_mtime:
            small.parent.mkdir(exist_ok=True)
            unfinished = small.with_name(f".{uuid.uuid4().hex}.jpg")
            _reduce(large, unfinished)
            os.replace(unfinished, small)
    except (OSError, RuntimeError):  # Blender's reader and writer raise RuntimeError
        return None
    return f"{name}/{BATCH}/{picture}"


def _reduce(large: Path, small: Path) -> None:
    """Write a picture at `THUMBNAIL` pixels.

    Raises
    ------
    OSError, RuntimeError
    """
    image = bpy.data.images.load(str(large))
    try:
        ratio = THUMBNAIL / max(*image.size, 1)
        image.scale(*(max(round(ratio * side), 1) for side in image.size))
        image.filepath_raw, image.file_format = str(small), "JPEG"
        image.save()
    finally:
        bpy.data.images.remove(image)


def _table(rows: Sequence[Row]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, restval="")
    writer.writeheader()
    writer.writerows({key: _as_cell(value) for key, value in row.cells().items()} for row in rows)
    return text.getvalue()


def _as_cell(value: Any) -> Any:
    """A value for a cell: a program for tables takes text that begins so for a formula."""
    return f"'{value}" if isinstance(value, str) and value.startswith(("=", "+", "@", "\t")) else value


def _in_a_sentence(rows: Sequence[Row], prediction: Prediction | None, out: Path) -> str:
    done, look = sum(row.state == DONE for row in rows), sum(row.look for row in rows)
    text = f"{done} of {len(rows)} documents are done, {look} ask to be looked at: {out / 'summary.html'}"
    return text if prediction is None else f"{text}\n{prediction.sentence()}"


def _write(path: Path, text: str) -> None:
    """Write a file completely or not at all."""
    unfinished = path.with_name(f".{path.name}-{uuid.uuid4().hex}")
    unfinished.write_text(text, encoding="utf-8", errors="backslashreplace", newline="")  # names need not be text
    os.replace(unfinished, path)


if __name__ == "__main__":
    under_blender = Path(sys.argv[0]).name != Path(__file__).name
    sys.exit(main(sys.argv[sys.argv.index("--") + 1 :] if under_blender else sys.argv[1:]))
