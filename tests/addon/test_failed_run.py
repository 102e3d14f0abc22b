"""A failed run repeats its earlier warnings, in the words of the command line."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.errors import StepFailed
from origami.core.watch import SILENT
from origami.origami_addon.jobs import tasks
from origami.origami_addon.jobs.requests import RunStages
from PIL import Image


def test_a_stage_that_fails_takes_its_warnings_along(monkeypatch, tmp_path):
    def fail(stages, state, work, watch_of):
        work.report.warn("find is not sure.")
        raise StepFailed("There is no edge.")

    monkeypatch.setattr(tasks, "advance_through", fail)
    monkeypatch.setattr(tasks, "_photos", lambda request, watch: ([], [], {}))
    request = RunStages(work=str(tmp_path), stages=("find",))
    with pytest.raises(StepFailed) as failed:
        tasks.run_stages(request, {}, tmp_path, lambda **_: None, SILENT)
    assert failed.value.warnings == ("find is not sure.",)


@pytest.fixture
def noise(tmp_path):
    """Photos of noise, one of them twice."""
    folder = tmp_path / "noise"
    folder.mkdir()
    random = np.random.default_rng(3)
    pictures = random.integers(0, 256, (3, 300, 400, 3), np.uint8)
    for number, picture in enumerate((*pictures, pictures[0])):
        Image.fromarray(picture).save(folder / f"{number}.png")
    return folder


def test_the_window_keeps_why_a_run_failed_and_what_it_warned_of(noise):
    import bpy
    from origami import register, unregister
    from origami.origami_addon.jobs import running

    register()
    try:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        assert bpy.ops.origami.add_photos(directory=f"{noise}/", new=True) == {"FINISHED"}
        with pytest.raises(RuntimeError) as failed:
            bpy.ops.origami.rectify()
        failure = running.failure()
        assert failure is not None
        assert failure.document == "noise"
        assert failure.sentence in str(failed.value)
        assert failure.warnings == ("3.png shows the same as 0.png, pixel for pixel, and is left out.",)
        with pytest.raises(RuntimeError, match="run it first"):
            bpy.ops.origami.run_stage(stage="page")
        assert running.failure().warnings == ()  # the one before is forgotten
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        assert running.failure() is None
    finally:
        unregister()
