"""When a finished run is reused, and when it is not; the steps are stand-ins that count."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from folded import folded_sheet, stand_in_for_steps, white_page
from origami.core.errors import StepFailed
from origami.origami_addon import report as report_module
from origami.origami_addon import run
from origami.origami_addon.settings import ImageSettings, RunSettings
from origami.origami_addon.state import Page
from origami.origami_addon.steps.work import PAGE_IMAGE, Work, kept_image
from PIL import Image


@pytest.fixture
def runs(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., bool]:
    """Runs with ``--resume``, and says whether anything was computed."""
    computed = []
    model = folded_sheet().model

    def write_results(state: object, work: object, out: Path, *_: object) -> None:
        (out / "cameras").mkdir(exist_ok=True)
        (out / "cameras" / "01_00.jpg").write_text("a picture")
        (out / "sheet.obj").write_text("a sheet")

    stand_in_for_steps(monkeypatch, run.steps)
    monkeypatch.setattr(run.steps, "place_photos", lambda *_: computed.append(1) or model)
    monkeypatch.setattr(run.steps, "write_results", write_results)

    def resume(**settings: object) -> bool:
        before = len(computed)
        run.rectify([photos], tmp_path / "out", RunSettings(**settings), resume=True)  # type: ignore[arg-type]
        return len(computed) > before

    assert resume()
    assert not resume()
    return resume


@pytest.mark.parametrize("name", ["cameras", "sheet.obj", "report.json"])
def test_a_result_is_gone(runs: Callable[..., bool], tmp_path: Path, name: str) -> None:
    gone = tmp_path / "out" / name
    if gone.is_dir():
        shutil.rmtree(gone)
    else:
        gone.unlink()
    assert runs()
    assert not runs()


def test_the_code_changed(runs: Callable[..., bool], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report_module, "_code", lambda: "other")
    assert runs()
    assert not runs()


def test_a_setting_changed(runs: Callable[..., bool]) -> None:
    assert runs(image=ImageSettings(source="reference"))


def test_a_photo_changed(runs: Callable[..., bool], photos: Path) -> None:
    Image.new("RGB", (300, 200), (9, 9, 9)).save(photos / "1.png")
    assert runs()


def test_the_colmap_model_changed(runs: Callable[..., bool], tmp_path: Path) -> None:
    model = tmp_path / "model"
    model.mkdir()
    for name in ("cameras", "images", "points3D"):
        (model / f"{name}.txt").write_text("1 0 0 0")
    assert runs(colmap_model=str(model))
    assert not runs(colmap_model=str(model))
    report = (tmp_path / "out" / "report.json").read_text(encoding="utf-8")
    assert '"name": "points3D.txt"' in report
    (model / "points3D.txt").write_text("1 0 0 1")
    assert runs(colmap_model=str(model))


def test_images_of_earlier_settings_are_removed(
    runs: Callable[..., bool], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def render(state: object, work: Work, *_: object) -> Page:
        kept_image(work, PAGE_IMAGE, work.settings.image.source, lambda: ({}, {}))
        return white_page()

    monkeypatch.setattr(run.steps, "make_page", render)
    work = tmp_path / "out" / "work"
    assert runs(image=ImageSettings(source="reference"))
    (work / "sheet-1.npz").write_text("slow and small")
    assert runs(image=ImageSettings(source="fused"))
    page, sheet = sorted(path.name for path in work.glob("*.npz"))
    assert page.startswith("page-fused-")
    assert sheet == "sheet-1.npz"
    monkeypatch.setattr(run, "place_for_results", fail)
    with pytest.raises(StepFailed):
        runs(image=ImageSettings(source="reference"))
    assert len(list(work.glob("page-*.npz"))) == 2  # until the new page is written, the old one may be wanted again


def fail(*_: object, **__: object) -> None:
    raise StepFailed("The disk is full.")
