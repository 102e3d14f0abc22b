"""Every script of the benchmark starts."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

_BENCHMARKS = Path(__file__).resolve().parent.parent.parent / "benchmarks"
_SCRIPTS = sorted(path for path in _BENCHMARKS.rglob("*.py") if "__main__" in path.read_text(encoding="utf-8"))


def test_there_are_scripts() -> None:
    assert {"run.py", "generate.py", "fit_evidence.py"} <= {path.name for path in _SCRIPTS}


@pytest.mark.parametrize("script", _SCRIPTS, ids=lambda path: str(path.relative_to(_BENCHMARKS)))
def test_a_script_of_the_benchmark_prints_its_help(script: Path) -> None:
    done = subprocess.run([sys.executable, str(script), "--help"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "usage" in done.stdout.lower()
