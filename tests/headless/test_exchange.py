"""A finished run stays complete until the next one is; the steps are stand-ins that write given content."""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from folded import folded_sheet, stand_in_for_steps
from killed import Killed, killed_after
from origami.core.errors import StepFailed, UsageError
from origami.origami_addon import new_results, output_folder, own_results, run
from origami.origami_addon.settings import RunSettings
from origami.origami_addon.system_errors import unwritable_as_failure

# The files of the runs; the second run omits one file, and has another file and another picture.
FIRST = {"page.tif": "page 1", "sheet.obj": "sheet 1", "map.npz": "map 1", "cameras/01_a.jpg": "a 1"}
SECOND = {"page.tif": "page 2", "page.jpg": "jpeg 2", "map.npz": "map 2", "cameras/01_b.jpg": "b 2"}


@pytest.fixture
def stand(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Runs that write given files into ``out``, and its content."""
    out = tmp_path / "out"
    files: dict[str, str] = {}
    model = folded_sheet().model

    def place(work: run.steps.Work, *_: object) -> object:
        (work.folder / "sfm" / "1").mkdir(parents=True, exist_ok=True)
        (work.folder / "sfm" / "1" / "model.npz").write_text(files["page.tif"])
        return model

    def write_results(state: object, work: object, into: Path, *_: object) -> None:
        (into / "cameras").mkdir(exist_ok=True)
        for name, text in files.items():
            (into / name).write_text(text)

    stand_in_for_steps(monkeypatch, run.steps)
    monkeypatch.setattr(run.steps, "place_photos", place)
    monkeypatch.setattr(run.steps, "write_results", write_results)

    def go(written: dict[str, str], seed: int = 0, **how: bool) -> None:
        files.clear()
        files.update(written)
        settings = RunSettings()
        settings = type(settings)(sfm=type(settings.sfm)(seed=seed))
        run.rectify([photos], out, settings, **how)

    def results() -> dict[str, str]:
        there = [*own_results.RESULTS, *(f"cameras/{path.name}" for path in (out / "cameras").glob("*"))]
        return {name: (out / name).read_text() for name in there if (out / name).exists()}

    def reported() -> set[str]:
        return set(json.loads((out / "report.json").read_text())["outputs"])

    go(FIRST)
    return SimpleNamespace(go=go, out=out, results=results, reported=reported)


@pytest.mark.parametrize("how", ["force", "resume"])
def test_a_second_run_takes_the_place_of_the_first(stand: SimpleNamespace, how: str) -> None:
    assert stand.results() == FIRST
    (stand.out / "cameras" / "mine.jpg").write_text("mine")
    (stand.out / "mine.txt").write_text("mine")
    stand.go(SECOND, seed=1, **{how: True})
    assert stand.results() == SECOND | {"cameras/mine.jpg": "mine"}
    assert stand.reported() == set(SECOND)
    assert (stand.out / "mine.txt").exists()
    assert sorted(path.name for path in (stand.out / "work").iterdir()) == ["number.json", "sfm"]
    assert not list(stand.out.glob(".writing-*"))


@pytest.mark.parametrize("how", ["force", "resume"])
@pytest.mark.parametrize("step", ["place_photos", "make_page", "write_results"])
@pytest.mark.parametrize("end", [StepFailed("No."), Killed()])
def test_a_second_run_that_ends_early_leaves_the_first(
    stand: SimpleNamespace, monkeypatch: pytest.MonkeyPatch, how: str, step: str, end: BaseException
) -> None:
    report = (stand.out / "report.json").read_bytes()
    usual = getattr(run.steps, step)

    def end_early(*arguments: Any) -> None:
        usual(*arguments)
        raise end

    with monkeypatch.context() as patch:
        patch.setattr(run.steps, step, end_early)
        with pytest.raises(type(end)):
            stand.go(SECOND, seed=1, **{how: True})
    assert stand.results() == FIRST
    assert (stand.out / "report.json").read_bytes() == report
    stand.go(SECOND, seed=1, resume=True)
    assert stand.results() == SECOND
    assert (stand.out / "work" / "sfm" / "1" / "model.npz").read_text() == "page 2"


@pytest.mark.parametrize("how", ["force", "resume"])
@pytest.mark.parametrize("again", [{}, {"resume": True}, {"force": True}])
def test_a_run_killed_while_results_are_exchanged(
    stand: SimpleNamespace, monkeypatch: pytest.MonkeyPatch, how: str, again: dict[str, bool]
) -> None:
    exchange = new_results.put_in_place
    for calls in itertools.count():
        stand.go(FIRST, force=True)
        with monkeypatch.context() as patch:
            reached: list[Callable[[], bool]] = []

            def from_here_on(out: Path, calls=calls, patch=patch, reached=reached) -> None:
                reached.append(killed_after(calls, patch))
                exchange(out)

            patch.setattr(run, "put_in_place", from_here_on)
            try:
                stand.go(SECOND, seed=1, **{how: True})
            except Killed:
                pass
            came_to_it = reached[0]()
        if not came_to_it:
            break
        finished = (stand.out / "report.json").exists()
        if finished and stand.reported() == set(FIRST):
            assert stand.results() == FIRST
        elif finished:
            assert stand.results() == SECOND
        waiting = (stand.out / "work" / "results" / "report.json").exists()
        if finished and not waiting and not again:
            with pytest.raises(UsageError, match="finished run"):
                stand.go(SECOND, seed=1)
            continue
        stand.go(SECOND, seed=1, **again)
        assert stand.results() == SECOND
        assert stand.reported() == set(SECOND)
    assert calls > len(SECOND)


def test_a_file_that_is_open_elsewhere(stand: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on Windows, where it cannot be replaced then."""
    replace = os.replace

    def refuse(source: Any, target: Any) -> None:
        if str(target).endswith("map.npz"):
            raise PermissionError(13, "Permission denied", str(source), None, str(target))
        replace(source, target)

    with monkeypatch.context() as patch:
        patch.setattr(output_folder.os, "replace", refuse)
        with pytest.raises(StepFailed, match=r"map\.npz could not be replaced \(Permission denied\)"):
            stand.go(SECOND, seed=1, resume=True)
    stand.go(SECOND, seed=1)
    assert stand.results() == SECOND


def test_results_of_a_run_that_did_not_finish_stay_until_others_are_written(
    stand: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    (stand.out / "report.json").unlink()
    with monkeypatch.context() as patch:
        patch.setattr(run.steps, "place_photos", lambda *_: (_ for _ in ()).throw(StepFailed("No.")))
        with pytest.raises(StepFailed):
            stand.go(SECOND, seed=1)
    assert stand.results() == FIRST
    stand.go(SECOND, seed=1)
    assert stand.results() == SECOND


def test_a_file_of_the_users_that_came_meanwhile(stand: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> None:
    usual = run.steps.find_sheet

    def theirs(*_: object, **__: object) -> object:
        (stand.out / "page.jpg").write_text("theirs")
        return usual()

    monkeypatch.setattr(run.steps, "find_sheet", theirs)
    marker = json.loads((stand.out / ".origami").read_text())
    marker["files"].pop("page.jpg", None)
    (stand.out / ".origami").write_text(json.dumps(marker))
    with pytest.raises(UsageError, match=r"page\.jpg, which Origami did not write"):
        stand.go(SECOND, seed=1, resume=True)
    assert stand.results() == FIRST | {"page.jpg": "theirs"}
    (stand.out / "page.jpg").unlink()
    monkeypatch.setattr(run.steps, "find_sheet", usual)
    stand.go(SECOND, seed=1, resume=True)
    assert stand.results() == SECOND


def test_a_link_that_leads_nowhere(tmp_path: Path) -> None:
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "unplugged")
    with pytest.raises(UsageError, match="is not a folder"):
        output_folder.check_folder(link, resume=False, force=False)
    inside = link / "page"
    with (
        pytest.raises(UsageError, match=r"cannot be written \(a link there leads nowhere\)"),
        unwritable_as_failure(inside),
    ):
        output_folder.check_folder(inside, resume=False, force=False)
        output_folder.make_folder(inside)
    assert not (tmp_path / "unplugged").exists()
