"""A job that cannot be started gives a message and leaves nothing behind."""

from __future__ import annotations

import errno
import os
import tempfile

import pytest
from origami.core.errors import StepFailed
from origami.origami_addon.jobs import process
from origami.origami_addon.jobs.requests import RunStages


def full(*_: object, **__: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


@pytest.mark.parametrize("what", ["mkdtemp", "savez"])
def test_no_room_for_a_job(temporary, monkeypatch, what):
    monkeypatch.setattr(process.tempfile if what == "mkdtemp" else process.np, what, full)
    with pytest.raises(StepFailed, match=r"could not be started \(No space left on device\): make room in"):
        process.Job(RunStages(), {})
    assert not list(temporary.iterdir())


def test_a_blender_that_is_gone(temporary, monkeypatch):
    monkeypatch.setattr(process, "_blender", lambda: [str(temporary / "blender")])
    with pytest.raises(StepFailed, match="restart Blender"):
        process.Job(RunStages(), {})
    assert not list(temporary.iterdir())
