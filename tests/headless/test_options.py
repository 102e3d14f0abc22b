"""Options and files of settings become settings, or a sentence."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from command_line import said, settings_of
from origami.core.setting import Setting, declarations_within
from origami.headless.options import build_parser
from origami.origami_addon import settings_json
from origami.origami_addon.settings import RunSettings


def test_help_documents_every_option() -> None:
    parser = build_parser()
    for action in parser._actions:
        assert action.help, f"{action.option_strings} has no help"
    text = parser.format_help()
    for code in ("0 ", "2 ", "3 ", "4 ", "5 ", "130 "):
        assert f"\n  {code}" in text


def test_options_change_the_settings(tmp_path: Path) -> None:
    assert settings_of() == RunSettings()
    outline = tmp_path / "outline.json"
    outline.write_text("[[1, 2], [30, 4.5], [20, 60]]")
    creases = tmp_path / "creases.json"
    creases.write_text("[[1, 2, 30, 4.5]]")
    typed = {
        "--paper": ("80", (80, None)),
        "--reference": ("a.jpg", "a.jpg"),
        "--colmap-model": ("sparse/0", str(Path("sparse/0"))),
        "--outline": (str(outline), ((1, 2), (30, 4.5), (20, 60))),
        "--creases": (str(creases), ((1, 2, 30, 4.5),)),
    }
    options: list[str] = []
    wanted = asdict(RunSettings())
    for path, declared in declarations_within(RunSettings):
        if not declared.option:
            continue
        if declared.kind is bool:
            options.append(f"--no-{declared.flag[2:]}" if declared.default else declared.flag)
            value: Any = not declared.default
        else:
            text, value = typed.get(declared.flag) or another(declared)
            options += [declared.flag, text]
        inside = wanted[path[0]] if len(path) > 1 else wanted
        assert inside[path[-1]] != value
        inside[path[-1]] = value
    assert asdict(settings_of(*options)) == wanted


def another(declared: Setting) -> tuple[str, Any]:
    """A value of a setting that is not its default, as typed and as it is."""
    if declared.kind is str:
        return declared.words[-1], declared.words[-1]
    assert declared.least is not None and declared.most is not None
    value = declared.kind((declared.default or declared.least) + 1)
    assert declared.least <= value <= declared.most
    return str(value), value


def test_help_gives_ranges_and_defaults() -> None:
    text = " ".join(build_parser().format_help().split())
    for _, declared in declarations_within(RunSettings):
        if declared.option:
            assert declared.values_text.replace("- ", "-") in text, declared.name
            for word, choice in declared.choices.items():
                assert f"{word}: {choice.help}" in text.replace("as- photographed", "as-photographed"), declared.name


def test_words_of_older_files_are_understood() -> None:
    for word in ("healed", "best"):
        assert settings_json.from_json({"image": {"source": word}}).image.source == "fused"


def test_settings_survive_json(tmp_path: Path) -> None:
    settings = settings_of("--paper", "A4", "--dpi", "200", "--no-ridge-rows", "--reference", "ä b.jpg")
    assert settings_json.from_json(settings_json.to_json(settings)) == settings
    file = tmp_path / "settings.json"
    file.write_text(settings_json.as_text(settings), encoding="utf-8")
    assert settings_of("--settings", str(file)) == settings
    file.write_text(json.dumps({"settings": settings_json.to_json(settings)}))
    assert settings_of("--settings", str(file), "--dpi", "100").image.dpi == 100


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("{", "not valid JSON"),
        ("[]", "must be an object"),
        ('{"surfaces": {}}', "did you mean surface?"),
        ('{"surface": {"method": "magic"}}', "surface.method must be one of developable"),
        ('{"surface": {"grid_rows": 8.5}}', "surface.grid_rows must be a whole number"),
        ('{"surface": {"grid_rows": 5}}', "between 20 and 400"),
        ('{"flatten": {"ridge_rows": 1}}', "flatten.ridge_rows must be true or false"),
        ('{"page": {"paper_size_mm": [210]}}', "must have 2 values"),
        ('{"image": {"dpi": 300}}', "paper"),
        ('{"reference": 3}', "reference must be a text"),
        ('{"outline": [[0, 0], [9, 0], [9, 9]]}', "name it with --reference"),
        ('{"reference": "a.jpg", "outline": [[0, 0], [9, 0]]}', "at least three corners"),
        ('{"reference": "a.jpg", "outline": [[0, 0], [9, 9], [9, 0], [0, 9]]}', "crosses or touches itself"),
        ('{"reference": "a.jpg", "outline": [[0, 0], [5, 5], [9, 9]]}', "crosses or touches itself"),
        ('{"surface": {"ridge_emphasis": 1}}', "ridge_emphasis must lie between"),
        ('{"surface": {"ridge_curvature": 0}}', "ridge_curvature must lie between"),
        ('{"sfm": {"max_features": 0}}', "max_features must lie between"),
        ('{"image": {"dpi": 4000}, "page": {"paper_size_mm": [210, 297]}}', "at most 2737"),
        ('{"image": {"dpi": 4000}, "page": {"paper_size_mm": [210, null]}}', "choose fewer"),
    ],
)
def test_bad_settings(
    command: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str], content: str, words: str
) -> None:
    file = tmp_path / "settings.json"
    file.write_text(content)
    assert command.main(["--settings", str(file), "photos", "-o", str(tmp_path / "out")]) == 2
    assert words in said(capsys)
