"""A run that stops after a stage, and goes on; the steps are stand-ins that count."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest
from folded import STEPS, folded_sheet, stand_in_for_steps
from origami.core.errors import UsageError
from origami.origami_addon import run
from origami.origami_addon.settings import ImageSettings, RunSettings
from origami.origami_addon.stages import STAGES, of_option

_STEPS = (*STEPS.values(), "write_results")


@pytest.fixture
def steps(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[str]]:
    """Runs into one folder, and says which steps it took."""
    taken: list[str] = []
    model = folded_sheet().model
    stand_in_for_steps(monkeypatch, run.steps)
    monkeypatch.setattr(run.steps, "place_photos", lambda *_: model)
    for name in _STEPS:
        step = getattr(run.steps, name)
        monkeypatch.setattr(
            run.steps, name, lambda *given, step=step, name=name, **how: taken.append(name) or step(*given, **how)
        )

    def go(settings: RunSettings | None = None, **how: object) -> list[str]:
        taken.clear()
        run.rectify([photos], tmp_path / "out", settings or RunSettings(), **how)  # type: ignore[arg-type]
        return list(taken)

    return go


@pytest.mark.parametrize("number", range(len(STAGES) - 1))
def test_it_takes_no_step_after_the_stage(steps: Callable[..., list[str]], tmp_path: Path, number: int) -> None:
    assert steps(stop_after=STAGES[number]) == list(_STEPS[: number + 1])
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [".origami", "log.txt", "work"]
    report = json.loads((tmp_path / "out" / "work" / "stopped.json").read_text())
    assert report["outputs"] == {}


def test_the_next_run_goes_on_and_only_a_whole_one_writes(steps: Callable[..., list[str]], tmp_path: Path) -> None:
    out = tmp_path / "out"
    steps(stop_after="find")
    assert steps()[-1] == "write_results"
    assert (out / "report.json").exists() and not (out / "work" / "stopped.json").exists()
    before = (out / "report.json").read_bytes()
    # Nothing has changed, so there is nothing to stop.
    assert steps(resume=True, stop_after="find") == []
    assert not (out / "work" / "stopped.json").exists()
    other = RunSettings(image=ImageSettings(source="reference"))
    assert steps(other, resume=True, stop_after="find") == ["place_photos", "find_sheet"]
    assert json.loads((out / "work" / "stopped.json").read_text())["stopped_after"] == "find sheet"
    assert (out / "report.json").read_bytes() == before
    assert steps(resume=True) == []
    assert not (out / "work" / "stopped.json").exists()


def test_every_sheet_can_only_stop_where_all_are_one(steps: Callable[..., list[str]]) -> None:
    every = RunSettings(sheet="all")
    assert steps(every, stop_after="place") == ["place_photos"]
    with pytest.raises(UsageError, match="stop after place"):
        steps(every, stop_after="surface")


def test_words_of_the_command_line() -> None:
    assert of_option("lay-out") == "lay_out"
    assert of_option(None) is None


def test_it_says_what_it_found(
    command: ModuleType, photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    case = folded_sheet()
    stand_in_for_steps(monkeypatch, run.steps)

    def place(work: run.steps.Work, *_: object) -> object:
        with work.report.stage("place photos") as figures:
            figures |= {"photos": 3, "photos_placed": 3, "points": 50, "reprojection_error_mean_px": 0.5}
        return case.model

    monkeypatch.setattr(run.steps, "place_photos", place)
    assert command.main([str(photos), "-o", str(tmp_path / "out"), "--stop-after", "place"]) == 0
    assert "Placement: 3 of 3 photos placed; 50 points, 0.50 px off. Stopped here" in capfd.readouterr().err


def test_a_kind_of_document_is_what_the_options_change(command: ModuleType, capfd: pytest.CaptureFixture) -> None:
    assert command.main(["--print-settings", "--kind", "receipt", "--grid-rows", "90"]) == 0
    settings = json.loads(capfd.readouterr().out)
    assert settings["page"]["paper_size_mm"] == [80.0, None]
    assert settings["surface"]["grid_rows"] == 90
