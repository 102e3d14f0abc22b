"""Jobs read photos only if they need them, and report unusable ones."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from folded import folded_sheet
from origami.core.errors import UnusablePhotos
from origami.core.watch import SILENT
from origami.origami_addon.files.photo_pixels import PhotoPixels
from origami.origami_addon.jobs import tasks
from origami.origami_addon.jobs.requests import RunStages
from origami.origami_addon.settings import PageSettings, RunSettings
from origami.origami_addon.state import state_arrays


@pytest.fixture(scope="module")
def case():
    return folded_sheet()


def run(case, tmp_path, stages: list[str], turn: str) -> list[str]:
    """The finished stages, with photos that no longer exist."""
    settings = RunSettings(page=PageSettings(turn=turn))
    photos = tuple(str(tmp_path / f"{number}.jpg") for number in range(3))
    request = RunStages(photos, settings, str(tmp_path / "work"), tuple(stages))
    done: list[str] = []
    given = {name: np.asarray(array) for name, array in state_arrays(case.state).items()}
    tasks.run_stages(request, given, tmp_path, lambda **said: done.append(said["done"]), SILENT)
    return done


def test_what_looks_at_no_pixel_needs_no_photo(case, tmp_path):
    assert run(case, tmp_path, ["unwrap", "lay_out"], "0") == ["unwrap", "lay_out"]


@pytest.mark.parametrize(
    "stages, turn", [(["unwrap", "lay_out"], "auto"), (["page"], "0"), (["find"], "0"), (["surface"], "0")]
)
def test_moved_photos_are_reported(case, tmp_path, stages, turn):
    with pytest.raises(UnusablePhotos, match=r"3 of 3 photos are no longer where they were, .*0\.jpg.*Find Photos"):
        run(case, tmp_path, stages, turn)


def test_a_photo_that_cannot_be_used_any_more_is_reported(case):
    first, second = (
        SimpleNamespace(name=camera.name, width=camera.width, height=camera.height) for camera in case.model.cameras
    )
    assert PhotoPixels([second, first], case.model).photos == [first, second]
    with pytest.raises(UnusablePhotos, match=f"The photo {second.name} was placed and can no longer be used"):
        PhotoPixels([first], case.model)
    second.width //= 2
    with pytest.raises(UnusablePhotos, match=f"The photo {second.name} has {second.width} x .* place the photos again"):
        PhotoPixels([first, second], case.model)
