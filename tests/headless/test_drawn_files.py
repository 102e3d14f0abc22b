"""Outlines and creases from files belong to one photo."""

from __future__ import annotations

import json
from pathlib import Path
from types import ModuleType

import pytest
from command_line import said, settings_of
from origami.origami_addon import settings_json


def test_an_outline_stays_with_its_photo(
    command: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, outline = tmp_path / "report.json", tmp_path / "outline.json"
    outline.write_text("[[1, 2], [30, 4.5], [20, 60]]")
    settings = settings_of("--reference", "a.jpg", "--outline", str(outline))
    file.write_text(json.dumps({"settings": settings_json.to_json(settings)}))
    assert settings_of("--settings", str(file)) == settings
    assert settings_of("--settings", str(file), "--reference", "a.jpg") == settings
    other = ["--settings", str(file), "--reference", "b.jpg"]
    assert settings_of(*other, "--outline", str(outline)).reference == "b.jpg"
    assert command.main([*other, "--print-settings"]) == 2
    assert "belongs to another reference photo than b.jpg" in said(capsys)
    assert command.main(["--outline", str(outline), "--print-settings"]) == 2
    assert "name it with --reference" in said(capsys)


def test_an_outline_and_creases_name_their_photo(
    command: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    outline, creases, other = (tmp_path / name for name in ("outline.json", "creases.json", "other.json"))
    outline.write_text('{"reference": "a/1.jpg", "outline": [[1, 2], [30, 4.5], [20, 60]]}')
    creases.write_text('{"reference": "1.jpg", "creases": [[1, 2, 30, 4.5]]}')
    other.write_text('{"reference": "2.jpg", "creases": []}')
    given = settings_of("--outline", str(outline))
    assert (given.reference, given.outline, given.creases) == ("a/1.jpg", ((1, 2), (30, 4.5), (20, 60)), None)
    for more in ([], ["--reference", "1.jpg"], ["--reference", "a/1.jpg"]):
        both = settings_of("--outline", str(outline), "--creases", str(creases), *more)
        assert (both.reference, both.creases) == ("a/1.jpg", ((1, 2, 30, 4.5),))
    assert settings_of("--creases", str(other)).creases == ()
    for more in (["--reference", "3.jpg"], ["--reference", "b/1.jpg"], ["--creases", str(other)]):
        assert command.main(["--outline", str(outline), *more, "--print-settings"]) == 2
        assert "both must be of the same reference photo" in said(capsys)
    settings = tmp_path / "settings.json"
    settings.write_text('{"reference": "2.jpg", "creases": [[1, 2, 30, 4.5]]}')
    assert command.main(["--settings", str(settings), "--outline", str(outline), "--print-settings"]) == 2
    assert "belongs to another reference photo than a/1.jpg" in said(capsys)


@pytest.mark.parametrize(
    "content", ['{"reference": "1.jpg", "creases": []}', '{"outline": [[0, 0]], "reference": 1}', "{}"]
)
def test_an_object_that_is_no_outline(
    command: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str], content: str
) -> None:
    outline = tmp_path / "outline.json"
    outline.write_text(content)
    assert command.main(["--outline", str(outline), "--print-settings"]) == 2
    assert "must hold a list, or an object" in said(capsys)


def test_an_outline_outside_its_photo(
    command: ModuleType, small_photos: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    outline = tmp_path / "outline.json"
    outline.write_text("[[100, 100], [90000, 100], [100, 900]]")
    options = ["--reference", "01.jpg", "--outline", str(outline), "-q"]
    assert command.main([str(small_photos), "-o", str(tmp_path / "out"), *options]) == 2
    assert "The outline leaves the photo 01.jpg" in said(capsys)
