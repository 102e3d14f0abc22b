"""Pages of other photos in the folder of a run: added, kept, dropped; the steps are stand-ins that count."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from folded import folded_sheet, stand_in_for_steps, white_page
from origami.core.errors import StepFailed, UnusablePhotos, UsageError
from origami.origami_addon import run
from origami.origami_addon.other_light import OtherPage
from origami.origami_addon.settings import RunSettings
from PIL import Image

FILES = ["raking.jpg", "raking.npz", "raking.tif", "ultraviolet.jpg", "ultraviolet.npz", "ultraviolet.tif"]


@pytest.fixture
def others(tmp_path: Path) -> list[Path]:
    """Two folders, with a photo each."""
    folders = [tmp_path / "ultraviolet", tmp_path / "raking"]
    for number, folder in enumerate(folders):
        folder.mkdir()
        Image.new("RGB", (300, 200), (0, number, 99)).save(folder / "only.png")
    return folders


@pytest.fixture
def go(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[str]]:
    """Runs with ``--resume`` and the folders of other photos, and names what was laid."""
    model = folded_sheet().model
    laid: list[str] = []

    def lay(state: Any, other: Any, *_: object) -> OtherPage:
        laid.append(other.name)
        page = white_page()
        dark = replace(page.texture, image=np.zeros_like(page.texture.image))
        return OtherPage(other, replace(state, page=replace(page, texture=dark, image=dark.image)))

    stand_in_for_steps(monkeypatch, run.steps)
    monkeypatch.setattr(run.steps, "place_photos", lambda *_: model)
    monkeypatch.setattr(run, "lay_other_photos", lay)

    def go(folders: list[Path], *, recursive: bool = False, **settings: Any) -> list[str]:
        laid.clear()
        options = {"other_photos": folders, "resume": True, "recursive": recursive}
        run.rectify([photos], tmp_path / "out", RunSettings(**settings), **options)
        return list(laid)

    return go


def names(out: Path) -> list[str]:
    folder = out / "other_light"
    return sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []


def test_pages_are_added_kept_and_dropped(go: Callable[..., list[str]], others: list[Path], tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert go([]) == []
    assert names(out) == []
    assert go(others[:1]) == ["ultraviolet"]
    assert go(others) == ["ultraviolet", "raking"]
    assert names(out) == FILES
    assert go(others) == []
    with Image.open(out / "other_light" / "raking.tif") as page:
        assert page.size == (4, 5)
        assert page.info["dpi"][0] == pytest.approx(100)
        assert np.asarray(page).max() == 0
    report = json.loads((out / "report.json").read_text(encoding="utf-8"))
    assert {f"other_light/{name}" for name in FILES} <= set(report["outputs"])
    assert [each["other_photos"] for each in report["inputs"] if "other_photos" in each] == ["ultraviolet", "raking"]
    (out / "other_light" / "mine.tif").write_text("the user's")
    assert go(others[1:]) == ["raking"]
    assert names(out) == ["mine.tif", *FILES[:3]]
    assert go([]) == []
    assert names(out) == ["mine.tif"]


def test_other_photos_that_changed_are_laid_again(go: Callable[..., list[str]], others: list[Path]) -> None:
    assert go(others[:1]) == ["ultraviolet"]
    Image.new("RGB", (300, 200), (7, 7, 7)).save(others[0] / "only.png")
    assert go(others[:1]) == ["ultraviolet"]


def test_the_users_files_stay(go: Callable[..., list[str]], others: list[Path], tmp_path: Path) -> None:
    taken = tmp_path / "out" / "other_light"
    taken.mkdir(parents=True)
    (taken / "ultraviolet.tif").write_text("the user's")
    with pytest.raises(UsageError, match=r"holds other_light/ultraviolet\.tif, which Origami did not write"):
        go(others)
    assert go(others[1:]) == ["raking"]
    assert (taken / "ultraviolet.tif").read_text() == "the user's"


def test_photos_that_do_not_fit_leave_a_warning(
    go: Callable[..., list[str]], others: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lay = run.lay_other_photos

    def lay_all_but_ultraviolet(state: Any, other: Any, *rest: Any) -> OtherPage:
        if other.name == "ultraviolet":
            raise UnusablePhotos("None of the photos in ultraviolet could be placed on the page.")
        return lay(state, other, *rest)

    monkeypatch.setattr(run, "lay_other_photos", lay_all_but_ultraviolet)
    assert go(others) == ["raking"]
    assert names(tmp_path / "out") == FILES[:3]
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    sentence = "None of the photos in ultraviolet could be placed on the page. The page itself is made without them."
    assert report["warnings"] == [sentence]
    assert not any("ultraviolet" in name for name in report["outputs"])
    assert go(others) == []  # the same photos still do not fit


def test_a_failure_leaves_the_run_before(
    go: Callable[..., list[str]], others: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    go([])
    before = (tmp_path / "out" / "report.json").read_bytes()

    def fail(*_: object) -> None:
        raise StepFailed("Memory ran out.")

    monkeypatch.setattr(run, "lay_other_photos", fail)
    with pytest.raises(StepFailed):
        go(others)
    assert (tmp_path / "out" / "report.json").read_bytes() == before


def test_photos_in_folders_inside(go: Callable[..., list[str]], others: list[Path]) -> None:
    inside = others[0] / "left"
    inside.mkdir()
    (others[0] / "only.png").rename(inside / "only.png")
    with pytest.raises(UnusablePhotos, match="take the photos of all with --recursive"):
        go(others[:1])
    assert go(others[:1], recursive=True) == ["ultraviolet"]


def test_what_cannot_be_done_is_refused_at_once(
    go: Callable[..., list[str]], others: list[Path], tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match="Other photos need one page to be laid on"):
        go(others, sheet="all")
    with pytest.raises(UsageError, match="There is no file or folder"):
        go([tmp_path / "infrared"])
    go(others)
    with pytest.raises(UsageError, match="lies where the results go"):
        go([tmp_path / "out" / "other_light"])
    with pytest.raises(UsageError, match="is the folder of the photos"):
        go([tmp_path / "out"])


def test_the_option(
    command: ModuleType, photos: Path, others: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: dict[str, Any] = {}
    monkeypatch.setattr(command.run, "rectify", lambda *_, **options: given.update(options) or run.Report({}))
    options = [f"--texture-from={folder}" for folder in others]
    assert command.main([str(photos), "-o", str(tmp_path / "out"), *options, "-q"]) == 0
    assert given["other_photos"] == others
