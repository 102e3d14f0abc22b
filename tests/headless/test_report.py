"""The report of a run, written without a run."""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from origami.origami_addon import report as report_module
from origami.origami_addon.report import Report


def test_report_is_plain_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = itertools.count(start=5.0, step=0.25)
    monkeypatch.setattr(report_module, "time", SimpleNamespace(**{**vars(time), "perf_counter": lambda: next(clock)}))
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
    assert content["stages"][0]["seconds"] == 0.25
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


def test_the_costs_are_each_step_s_own_and_its_children_s(tmp_path: Path) -> None:
    report = Report({})
    with report.stage("writes and waits"):
        (tmp_path / "file").write_bytes(bytes(3_000_000))
    with report.stage("a child that computes and reads"):
        work = f"x = sum(i * i for i in range(4_000_000)); open({str(tmp_path / 'file')!r}, 'rb').read()"
        subprocess.run([sys.executable, "-c", work], check=True)
    wrote, computed = report.stages
    assert 3_000_000 <= wrote["written_bytes"] < 4_000_000
    assert computed["read_bytes"] >= 3_000_000 > computed["written_bytes"]
    assert computed["cpu_seconds"] > 0.1 > wrote["cpu_seconds"]
