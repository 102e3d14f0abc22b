"""Folders of results that cannot be written: read-only ones, and full disks."""

from __future__ import annotations

import errno
import os
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import pytest
from command_line import raising, said
from origami.origami_addon import output_folder, run


@pytest.fixture
def mounted(tmp_path: Path) -> Iterator[Callable[[str], Path]]:
    """Mounts a small file system; skips where that is not allowed."""
    point = tmp_path / "mount"
    point.mkdir()

    def mount(options: str) -> Path:
        if not hasattr(os, "geteuid") or os.geteuid() != 0:
            pytest.skip("only root may mount")
        if subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(point)], capture_output=True).returncode:
            pytest.skip("mounting is not allowed here")
        return point

    yield mount
    subprocess.run(["umount", str(point)], capture_output=True, check=False)


@pytest.mark.parametrize("number", [errno.EROFS, errno.EACCES])
def test_it_cannot_be_written(
    command: ModuleType,
    small_photos: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    number: int,
) -> None:
    monkeypatch.setattr(output_folder.tempfile, "TemporaryFile", raising(OSError(number, os.strerror(number))))
    assert command.main([str(small_photos), "-o", str(tmp_path / "out"), "-q"]) == 2
    assert os.strerror(number) in said(capsys)


def test_a_full_disk_before_and_during_a_run(
    command: ModuleType,
    small_photos: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(tmp_path / "out"))
    with monkeypatch.context() as patch:
        patch.setattr(run.steps, "place_photos", raising(full))
        assert command.main([str(small_photos), "-o", str(tmp_path / "out"), "-q"]) == 5
    assert "disk" in said(capsys)
    monkeypatch.setattr(output_folder.tempfile, "TemporaryFile", raising(full))
    assert command.main([str(small_photos), "-o", str(tmp_path / "out"), "-q"]) == 5
    assert "disk" in said(capsys)


def test_a_read_only_mount(
    command: ModuleType,
    small_photos: Path,
    mounted: Callable[[str], Path],
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert command.main([str(small_photos), "-o", str(mounted("ro,size=1m") / "out"), "-q"]) == 2
    assert "cannot be written" in said(capsys)


def test_a_disk_that_fills_up(
    command: ModuleType,
    small_photos: Path,
    mounted: Callable[[str], Path],
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert command.main([str(small_photos), "-o", str(mounted("size=1m") / "out"), "-q"]) == 5
    assert "make room" in said(capsys)
