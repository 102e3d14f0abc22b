"""The benchmark's parts around the scores: synthetic errors, baselines, tables, stages."""

from __future__ import annotations

import json
import os
import stat
import subprocess
import sys
import threading

import numpy as np
import pytest
import sheets
from origami.core.flat.distortion import flipped_triangles, measure_strain

pytest.importorskip("cv2", reason="the benchmark's requirements are not installed")

from origami.benchmarks import blender_unwrap, page_dewarp, sweep, tables, whole_runs


def test_exact_flat_map_has_no_synthetic_error():
    sheet = sheets.cross()
    mesh, flat = sheets.mesh(sheet, 0.05)
    turned = flat @ np.array([[0, 3], [-3, 0]]) + 7
    errors = sweep.errors(mesh, turned, sheet)
    assert errors["G"] == pytest.approx(1)
    assert errors["p95"] < 1e-3


def test_synthetic_error_of_a_bent_flat_map():
    sheet = sheets.plane()
    mesh, flat = sheets.mesh(sheet, 0.02)
    errors = sweep.errors(mesh, flat + [[0.002, 0]] * np.sign(np.sin(40 * flat[:, 1:])), sheet)
    assert errors["mean"] == pytest.approx(2, rel=0.1)


@pytest.mark.parametrize("method", ["ANGLE_BASED", "CONFORMAL"])
def test_blender_unwraps_in_the_sheets_own_unit(empty_scene, method):
    sheet, _ = sheets.mesh(sheets.two_folds(), 0.05)
    uv = blender_unwrap.unwrap(sheet, method)
    strain = measure_strain(sheet.vertices, sheet.triangles, uv)
    assert strain.scale == pytest.approx(1, abs=1e-3)
    assert strain.stretch.max() < 0.02
    assert not flipped_triangles(sheet.triangles, uv).any()


def test_page_dewarp_that_ends_well_without_a_page_has_failed(tmp_path, monkeypatch):
    program = tmp_path / "page-dewarp"
    program.write_text("#!/bin/sh\necho skipping it because only 0 spans\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setattr(page_dewarp, "install", lambda: program)
    with pytest.raises(page_dewarp.BaselineFailed, match="only 0 spans"):
        page_dewarp.dewarp(tmp_path / "photo.jpg", tmp_path / "out")
    with pytest.raises(page_dewarp.BaselineFailed, match="any of 2 photos"):
        page_dewarp.dewarp_any([tmp_path / "photo.jpg", tmp_path / "other.jpg"], tmp_path / "out")


def test_a_failed_cell_stands_in_the_table(tmp_path):
    table = tables.Table("cells", "Cells", {"method": ("method", ""), "mean": ("mean px", ".2f"), "n": ("n", "d")})
    table.rows = [{"method": "a", "mean": 1.234, "n": 3}, {"method": "b", "failure": "it broke"}]
    table.write(tmp_path)
    lines = (tmp_path / "cells.md").read_text().splitlines()
    assert "| a | 1.23 | 3 |" in lines
    assert "| b | failed: it broke |  |" in lines
    assert "it broke" in (tmp_path / "cells.csv").read_text()
    assert json.loads((tmp_path / "cells.json").read_text())["rows"] == table.rows


def test_stages_are_read_off_the_log():
    ended = whole_runs._STAGE_ENDS.match('place photos: 12.3 s, {"photos": 8}')
    assert ended
    assert (ended["name"], float(ended["seconds"])) == ("place photos", 12.3)
    assert not whole_runs._STAGE_ENDS.match("place photos ...")
    assert not whole_runs._STAGE_ENDS.match(" 60 %  Finding the paper")


@pytest.mark.skipif(not os.path.isdir("/proc"), reason="the usage of a process is read from /proc")
def test_effort_counts_children():
    work = "import subprocess, sys, time; held = bytearray(40 << 20); end = time.process_time() + 0.5"
    spin = "\nwhile time.process_time() < end: pass"
    parent = subprocess.Popen(
        [sys.executable, "-c", f"{work}\nsubprocess.run([sys.executable, '-c', {work + spin!r}])"]
    )
    effort = whole_runs.Effort(parent.pid)
    watcher = threading.Thread(target=effort.watch)
    watcher.start()
    parent.wait()
    effort.stop()
    watcher.join()
    used = effort.take()
    assert used["megabytes"] > 80
    assert used["processor_seconds"] > 0.35
    assert effort.take() == {"megabytes": 0, "processor_seconds": 0}
