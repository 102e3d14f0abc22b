"""What may lie in the way of the results."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path
from types import ModuleType

import pytest
from command_line import EVERYTHING, contents, raising, said
from marked_folder import mark
from origami.core import errors
from origami.origami_addon import run
from origami.origami_addon.files.marker import MARKER


def test_a_file_in_its_place(command: ModuleType, small_photos: Path, tmp_path: Path) -> None:
    in_place = tmp_path / "out"
    in_place.write_text("mine")
    assert command.main([str(small_photos), "-o", str(in_place), "-q"]) == 2
    assert command.main([str(small_photos), "-o", str(in_place / "below"), "-q"]) == 2
    assert in_place.read_text() == "mine"


@pytest.mark.parametrize(("name", "code"), [("log.txt", 2), ("page.tif", 2), ("cameras", 2), ("work/sfm", 5)])
def test_something_else_in_the_place_of_a_result(
    command: ModuleType, small_photos: Path, tmp_path: Path, name: str, code: int
) -> None:
    in_place = tmp_path / "out" / name
    in_place.parent.mkdir(parents=True)
    if "." in name:
        in_place.mkdir()
    else:
        in_place.write_text("a file")
    mark(tmp_path / "out", EVERYTHING)
    assert command.main([str(small_photos), "-o", str(tmp_path / "out"), "-q"]) == code
    assert in_place.exists()


def test_the_photos_own_folder(command: ModuleType, small_photos: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main([str(small_photos), "-o", str(small_photos), "-q"]) == 2
    assert "folder of the photos" in said(capsys)
    assert not (small_photos / "work").exists()


def test_a_finished_run(
    command: ModuleType, small_photos: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "report.json").write_text('{"versions": {"origami": "0"}}')
    assert command.main([str(small_photos), "-o", str(tmp_path), "-q"]) == 2
    text = said(capsys)
    assert "--resume" in text
    assert "--force" in text


@pytest.mark.parametrize("options", [["--resume"], ["--force"], ["--resume", "--colmap-model", "nowhere"]])
def test_a_finished_run_stays_when_the_next_one_fails(
    command: ModuleType,
    small_photos: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    options: list[str],
) -> None:
    results = ["page.tif", "cameras/01_a.jpg", "work/sheet-1.npz", "work/sfm/1/model.npz"]
    for name in (*results, "mine.txt"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    outputs = {name: {"bytes": 1} for name in results[:2]}
    (tmp_path / "report.json").write_text(json.dumps({"versions": {"origami": "0"}, "outputs": outputs}))
    before = contents(tmp_path)
    out = ["-o", str(tmp_path), "-q", *options]
    assert command.main([str(tmp_path / "mistyped"), *out]) == 2
    if "--colmap-model" not in options:
        assert command.main([str(small_photos), *out, "--reference", "99.jpg"]) == 2
        monkeypatch.setattr(run.steps, "place_photos", raising(errors.UnusablePhotos("No.")))
    assert command.main([str(small_photos), *out]) == 4
    after = contents(tmp_path)
    assert {name: after[name] for name in before} == before


@pytest.mark.parametrize("flag", ["-q", "--resume", "--force"])
@pytest.mark.parametrize("name", ["page.jpg", "document.blend", "report.json", "log.txt", "cameras/a", "work/a"])
def test_the_users_own_files(
    command: ModuleType,
    small_photos: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    name: str,
    flag: str,
) -> None:
    own = tmp_path / name
    own.parent.mkdir(exist_ok=True)
    own.write_text("{}")
    assert command.main([str(small_photos), "-o", str(tmp_path), flag]) == 2
    assert "choose another folder" in said(capsys)
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [own]


@pytest.mark.parametrize("flag", ["-q", "--resume", "--force"])
@pytest.mark.parametrize("name", [MARKER, "page.tif", "log.txt", "report.json", "work", "cameras", "work/sfm"])
def test_links_are_not_followed(
    command: ModuleType,
    small_photos: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    name: str,
    flag: str,
) -> None:
    out, theirs = tmp_path / "out", tmp_path / "theirs"
    (out / name).parent.mkdir(parents=True)
    theirs.mkdir()
    (theirs / "photo.jpg").write_text("theirs")
    if name == MARKER:
        mark(theirs, EVERYTHING)
    else:
        mark(out, EVERYTHING)
    (out / name).symlink_to(theirs if name in ("work", "cameras", "work/sfm") else theirs / MARKER)
    before = contents(tmp_path)
    assert command.main([str(small_photos), "-o", str(out), flag]) == 2
    assert "choose another folder" in said(capsys)
    assert contents(tmp_path) == before


def test_a_log_with_another_name_keeps_its_content_there(
    command: ModuleType, small_photos: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    mark(out, EVERYTHING)
    (tmp_path / "backup.txt").write_text("before\n")
    os.link(tmp_path / "backup.txt", out / "log.txt")
    (tmp_path / "broken.jpg").touch()
    assert command.main([str(tmp_path / "broken.jpg"), "-o", str(out), "-q"]) == 4
    assert (tmp_path / "backup.txt").read_text() == "before\n"
    assert (out / "log.txt").read_text().startswith("before\n")
    assert "broken.jpg is empty" in (out / "log.txt").read_text()


@pytest.mark.parametrize("flag", ["-q", "--resume", "--force"])
def test_a_folder_with_somebody_elses_marker(
    command: ModuleType,
    small_photos: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    flag: str,
) -> None:
    (tmp_path / MARKER).write_text("cranes and frogs")
    for name in ("page.tif", "sheet.obj", "work/plan.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("theirs")
    before = contents(tmp_path)
    assert command.main([str(small_photos), "-o", str(tmp_path), flag]) == 2
    assert "which Origami did not write" in said(capsys)
    assert contents(tmp_path) == before


def test_unrelated_files_stay(
    command: ModuleType, small_photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "letter.txt").write_text("mine")
    monkeypatch.setattr(run.steps, "place_photos", raising(errors.StepFailed("No.")))
    for flag in ("-q", "--resume", "--force"):
        assert command.main([str(small_photos), "-o", str(tmp_path), flag]) == 5
    assert {path.name for path in tmp_path.iterdir()} == {"letter.txt", "work", "log.txt", MARKER}


@pytest.mark.parametrize("flag", ["-q", "--resume", "--force"])
@pytest.mark.parametrize("below", ["cameras", "work", "work/photos"])
def test_photos_where_results_go(
    command: ModuleType,
    small_photos: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    below: str,
    flag: str,
) -> None:
    shutil.copytree(small_photos, tmp_path / below)
    mark(tmp_path, EVERYTHING)
    photos = sorted((tmp_path / below).iterdir())
    for given in ([tmp_path / below], photos):
        assert command.main([*map(str, given), "-o", str(tmp_path), flag]) == 2
        assert "lies where the results go" in said(capsys)
    assert sorted((tmp_path / below).iterdir()) == photos


def test_links_to_where_results_go(
    command: ModuleType, small_photos: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, linked = tmp_path / "out", tmp_path / "linked"
    out.mkdir()
    linked.mkdir()
    mark(out, EVERYTHING)
    shutil.copy(small_photos / "00.jpg", out / "page.jpg")
    (linked / "a.jpg").symlink_to(out / "page.jpg")
    assert command.main([str(linked), "-o", str(out), "--force"]) == 2
    assert "lies where the results go" in said(capsys)
    assert (out / "page.jpg").exists()


@pytest.mark.parametrize(
    "options",
    [
        ["--colmap-model", "work/sparse"],
        ["--settings", "work/settings.json"],
        ["--reference", "00.jpg", "--outline", "cameras/outline.json"],
        ["--settings", "report.json"],
    ],
)
def test_other_inputs_where_results_go(
    command: ModuleType,
    small_photos: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    options: list[str],
) -> None:
    (tmp_path / "work" / "sparse").mkdir(parents=True)
    (tmp_path / "cameras").mkdir()
    mark(tmp_path, EVERYTHING)
    for name in ("work/settings.json", "report.json"):
        (tmp_path / name).write_text("{}")
    (tmp_path / "cameras" / "outline.json").write_text("[[0, 0], [9, 0], [9, 9]]")
    *others, name = options
    assert command.main([str(small_photos), "-o", str(tmp_path), "--force", *others, str(tmp_path / name)]) == 2
    assert "lies where the results go" in said(capsys)
    assert (tmp_path / name).exists()


def test_an_outline_that_was_edited_in_place(
    command: ModuleType,
    small_photos: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    outline = tmp_path / "outline.json"
    outline.write_text('{"reference": "01.jpg", "outline": [[10, 10], [90, 10], [90, 90]]}')
    outputs = {"outline.json": {"bytes": 1, "sha256": "of what the run had written"}}
    (tmp_path / "report.json").write_text(json.dumps({"versions": {"origami": "0"}, "outputs": outputs}))
    before = outline.read_bytes()
    monkeypatch.setattr(run.steps, "place_photos", raising(errors.StepFailed("No.")))
    out = [str(small_photos), "-o", str(tmp_path)]
    for flag in ("--resume", "--force"):
        assert command.main([*out, flag]) == 2
        assert "outline.json was changed since it was written" in said(capsys)
        assert command.main([*out, flag, "--outline", str(outline)]) == 5
        capsys.readouterr()
    assert outline.read_bytes() == before


def test_settings_from_the_report_that_is_replaced(
    command: ModuleType, small_photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "report.json").write_text('{"versions": {"origami": "0"}, "settings": {}}')
    monkeypatch.setattr(run.steps, "place_photos", raising(errors.StepFailed("No.")))
    options = ["--force", "--settings", str(tmp_path / "report.json")]
    assert command.main([str(small_photos), "-o", str(tmp_path), *options]) == 5
