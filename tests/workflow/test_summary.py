"""The summary of a batch, from folders as a batch leaves them."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from PIL import Image

FIGURES = {
    "photos": 8,
    "photos_placed": 8,
    "views_per_point_mean": 5.0,
    "viewing_angle_median_degrees": 30.0,
    "reprojection_error_mean_px": 0.3,
    "outline_confidence": 0.95,
    "reference": "00.jpg",
    "width_px": 600,
    "height_px": 800,
}


def finished(folder: Path, *warnings: str, **figures: Any) -> None:
    """A document that is done."""
    report = {"stages": [{"name": "all", "figures": FIGURES | figures}], "warnings": warnings}
    for name in ("page.jpg", "outline.jpg"):
        (folder / "batch").mkdir(parents=True, exist_ok=True)
        Image.new("RGB", (600, 800), (200, 10, 10)).save(folder / name)
    outputs = {"page.jpg": {"bytes": 5000, "sha256": ""}}
    (folder / "report.json").write_text(json.dumps(report | {"outputs": outputs}))
    for name in ("place", "sheet", "page"):
        costs = {"seconds": 10.0, "cpu_seconds": 8.0, "peak_memory_mb": 400}
        stages = [{"name": "a", "read_bytes": 7, "written_bytes": 11}]
        (folder / "batch" / f"{name}.json").write_text(json.dumps(costs | {"stages": stages}))
        (folder / "batch" / f"{name}.failed.json").touch()  # as the engine leaves logs that nobody wrote


def failed(folder: Path, **sentences: str) -> None:
    """A document that failed, with a sentence for each step that did."""
    (folder / "batch").mkdir(parents=True, exist_ok=True)
    for step, sentence in sentences.items():
        content = {"seconds": 3.0, "cpu_seconds": 2.0, "peak_memory_mb": 300, "exit_code": 4, "sentence": sentence}
        (folder / "batch" / f"{step}.failed.json").write_text(json.dumps(content))
        (folder / "batch" / f"{step}.json").unlink(missing_ok=True)


def summary(scripts: dict[str, ModuleType], out: Path) -> tuple[dict[str, dict[str, str]], str]:
    """The rows of summary.csv by document, and summary.html."""
    assert scripts["summary"].main([str(out)]) == 0
    with (out / "summary.csv").open(encoding="utf-8-sig", newline="") as file:
        rows = {row["document"]: row for row in csv.DictReader(file)}
    return rows, (out / "summary.html").read_text(encoding="utf-8")


def test_what_became_of_each(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    finished(tmp_path / "good")
    finished(tmp_path / "fair", outline_confidence=0.7)
    finished(tmp_path / "warned", "Look at it.")
    failed(tmp_path / "bad", place="No <photo>.")
    finished(tmp_path / "was good")
    failed(tmp_path / "was good", sheet="Later.", place="First.")
    finished(tmp_path / "again")
    (tmp_path / "again" / "batch" / "page.json").unlink()
    rows, page = summary(scripts, tmp_path)
    found = {name: (row["state"], row["quality"], row["look"], row["reason"]) for name, row in rows.items()}
    assert found == {
        "good": ("done", "good", "no", ""),
        "fair": ("done", "fair", "yes", ""),
        "warned": ("done", "good", "yes", ""),
        "bad": ("failed", "", "yes", "No <photo>."),
        "was good": ("failed", "good", "yes", "First."),
        "again": ("not finished", "good", "yes", ""),
    }
    assert rows["fair"]["measures"] == "Paper's edge 70 % sure"
    assert rows["good"]["seconds"] == "30.0" and rows["good"]["peak_memory_mb"] == "400"
    assert rows["good"]["read_bytes"] == "21" and rows["good"]["written_bytes"] == "33"
    assert "No &lt;photo&gt;." in page and "<photo>" not in page
    assert "to look at: 5" in page and "failed: 2" in page


def test_small_pictures_are_made_and_made_again(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    finished(tmp_path / "Ü #1 %")
    _, page = summary(scripts, tmp_path)
    small = tmp_path / "Ü #1 %" / "batch" / "page.jpg"
    assert 'src="./%C3%9C%20%231%20%25/batch/page.jpg"' in page
    with Image.open(small) as image:
        assert image.size == (180, 240)
        assert image.getpixel((90, 120))[0] > 150
    Image.new("RGB", (800, 600)).save(tmp_path / "Ü #1 %" / "page.jpg")
    summary(scripts, tmp_path)
    with Image.open(small) as image:
        assert image.size == (240, 180)


def test_a_damaged_picture_costs_only_itself(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    finished(tmp_path / "one")
    (tmp_path / "one" / "page.jpg").write_bytes(b"no picture")
    rows, page = summary(scripts, tmp_path)
    assert rows["one"]["state"] == "done"
    assert "one/batch/outline.jpg" in page and "one/batch/page.jpg" not in page


def test_a_report_of_another_program_is_none(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "report.json").write_text('{"stages": [{"name": 1}]}')
    rows, _ = summary(scripts, tmp_path)
    assert rows["other"]["state"] == "not finished"


def test_no_name_becomes_a_formula(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    finished(tmp_path / "=1+1")
    rows, _ = summary(scripts, tmp_path)
    assert list(rows) == ["'=1+1"]


def test_a_folder_of_photos_whose_name_is_no_text(
    scripts: dict[str, ModuleType], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed = [{"name": "caf%E9", "folder": "/photos/caf\udce9"}]
    monkeypatch.setattr("sys.stdin", io.StringIO(json.dumps(listed)))
    assert scripts["summary"].main([str(tmp_path), "--documents", "-"]) == 0
    assert "/photos/caf\\udce9" in (tmp_path / "summary.csv").read_text(encoding="utf-8")


def test_nothing_has_run_yet(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    rows, page = summary(scripts, tmp_path)
    assert rows == {} and "No document has run yet." in page


def test_a_collection_is_predicted_from_ten_documents(scripts: dict[str, ModuleType]) -> None:
    costs = [{"seconds": 90.0 + 2 * n, "cpu_seconds": 80.0, "peak_memory_mb": 500 + n} for n in range(10)]
    prediction = scripts["costs"].predict(costs)
    assert prediction.seconds.value == pytest.approx(99)
    # Student's t of nine degrees of freedom, 2.2622, times the standard error of the mean.
    assert prediction.seconds.most - 99 == pytest.approx(2.2622 * 6.0553 / 10**0.5, rel=1e-3)
    assert prediction.memory_mb == 509
    assert "1000 such documents would take 27.5 hours" in prediction.sentence()
    assert scripts["costs"].predict([]) is None
    assert scripts["costs"].predict(costs[:1]).seconds.most == float("inf")
