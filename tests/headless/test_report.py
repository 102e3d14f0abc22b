"""The report of a run, written without a run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from origami.origami_addon.report import Report


def test_report_is_plain_json(tmp_path: Path) -> None:
    report = Report({"seed": 1})
    with report.stage("first") as figures:
        figures |= {"number": np.float64(2), "unknown": float("nan"), "list": np.arange(2)}
        report.warn("A sentence.", "A sentence.")
    with report.stage("second"):
        report.warn("A sentence.", "Another.")
    (tmp_path / "page.tif").write_bytes(b"page")
    report.add_output(tmp_path, "page.tif")
    report.write(tmp_path / "report.json")
    content = json.loads((tmp_path / "report.json").read_text())
    assert content["stages"][0]["figures"] == {"number": 2, "unknown": None, "list": [0, 1]}
    assert content["stages"][0]["seconds"] >= 0
    assert content["warnings"] == ["A sentence.", "Another."]
    assert [stage["warnings"] for stage in content["stages"]] == [["A sentence."], ["Another."]]
    assert content["outputs"]["page.tif"]["bytes"] == 4
    assert [path.name for path in tmp_path.glob(".*")] == []


def test_peak_memory_is_each_step_s_own() -> None:
    report = Report({})
    with report.stage("large"):
        np.ones(30_000_000)
    with report.stage("small"):
        pass
    large, small = (stage["peak_memory_mb"] for stage in report.stages)
    assert large >= small + 150
