"""Sizes of paper as they are typed."""

from __future__ import annotations

import json
from pathlib import Path
from types import ModuleType

import pytest
from command_line import said, settings_of
from origami.core import errors
from origami.origami_addon.paper_size import PAPER_SIZES_MM, check_unit, paper_size


def test_paper_sizes() -> None:
    assert paper_size("a4") == PAPER_SIZES_MM["A4"]
    assert paper_size("100x 200.5mm") == (100, 200.5)
    assert paper_size("none") is None
    for wrong in ("A99", "10x20x30", "-5", "", "8.5x11ft", "in", "xin", "8.5x11.", "1e3"):
        with pytest.raises(errors.UsageError, match="WIDTHxHEIGHT"):
            paper_size(wrong)


def test_paper_sizes_with_a_unit() -> None:
    for text in ("8.5x11in", '8.5x11"', "8.5 X 11 IN", '8.5" x 11"', "8.5inx11in", "8.5×11inch", "8.5x11″", "8.5inx11"):
        assert paper_size(text) == PAPER_SIZES_MM["Letter"], text
    assert paper_size("21x29.7cm") == PAPER_SIZES_MM["A4"]
    assert paper_size("210x297mm") == PAPER_SIZES_MM["A4"]
    assert paper_size("21cmx297mm") == PAPER_SIZES_MM["A4"]
    assert paper_size("8cm") == (80, None)
    assert paper_size("3.125in") == (79.375, None)
    assert paper_size("8.5x11mm") == (8.5, 11)


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("8.5x11", "Letter or 8.5x11in?"),
        ("11x8.5", "Letter or 11x8.5in?"),
        ("8.5x14", "Legal or 8.5x14in?"),
        ("21x29.7", "A4 or 21x29.7cm?"),
        ("21x30", "A4 or 21x30cm?"),
        ("29.7x42", "A3 or 29.7x42cm?"),
        ("21.6x27.9", "Letter or 21.6x27.9cm?"),
        ("8.27x11.69", "A4 or 8.27x11.69in?"),
        ("11x17", "mean 11x17in?"),
        ("4x6", "mean 4x6in?"),
        ("10x15", "mean 10x15cm?"),
        ("8.5", "mean 8.5in?"),
        ("21", "mean 21cm?"),
        ("8", "mean 8cm?"),
        ("5.8", "mean 5.8cm?"),
    ],
)
def test_paper_sizes_that_were_meant_in_another_unit(
    command: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, meant: str
) -> None:
    assert command.main(["photos", "-o", str(tmp_path / "out"), "--paper", text]) == 2
    sentence = said(capsys)
    assert meant in sentence
    assert f"--paper {text}mm" in sentence
    file = tmp_path / "settings.json"
    sides = [float(side) for side in text.split("x")]
    file.write_text(json.dumps({"page": {"paper_size_mm": [sides[0], sides[1] if len(sides) > 1 else None]}}))
    assert command.main(["photos", "-o", str(tmp_path / "out"), "--settings", str(file)]) == 2
    assert meant in said(capsys)
    assert not (tmp_path / "out").exists()
    assert settings_of("--settings", str(file), "--paper", "A5").page.paper_size_mm == PAPER_SIZES_MM["A5"]


@pytest.mark.parametrize("text", ["50x30", "54x86", "30x40", "35x45", "24x36", "38", "57", "80", "74x105", "105x148"])
def test_small_paper_that_exists(text: str) -> None:
    width, _, height = text.partition("x")
    assert paper_size(text) == (float(width), float(height) if height else None)
    for size in PAPER_SIZES_MM.values():
        check_unit(size)
