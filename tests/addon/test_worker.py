"""Blender does not survive pycolmap in its own process, so the worker's functions are tested in another one."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def test_the_workers_functions_in_a_process_of_their_own(root: Path) -> None:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", "0"]
    run = subprocess.run(
        [*command, Path(__file__).with_name("worker_alone.py")], cwd=root, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stdout
    assert "4 passed" in run.stdout
