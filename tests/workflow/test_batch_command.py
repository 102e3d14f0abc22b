"""What the command for a batch refuses before any engine starts; it needs only Python."""

from __future__ import annotations

import fcntl
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.fixture
def documents(tmp_path: Path) -> Path:
    (tmp_path / "photos" / "a letter").mkdir(parents=True)
    return tmp_path / "photos"


def refused(root: Path, documents: Path, out: Path) -> str:
    command = [sys.executable, str(root / "workflow" / "batch.py"), str(documents), str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    return done.stderr


def test_folders_that_cannot_be_meant(root: Path, documents: Path, tmp_path: Path) -> None:
    assert "is the folder of the documents" in refused(root, documents, documents)
    assert "inside a document's folder" in refused(root, documents, documents / "a letter" / "out")
    assert "There is no folder or table" in refused(root, tmp_path / "gone", tmp_path / "out")
    assert not (tmp_path / "out").exists()
    (tmp_path / "file").touch()
    assert "cannot be used for the results" in refused(root, documents, tmp_path / "file")


def test_one_batch_at_a_time(root: Path, documents: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    with (tmp_path / "out" / ".batch-lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        assert "Another batch is writing into" in refused(root, documents, tmp_path / "out")
