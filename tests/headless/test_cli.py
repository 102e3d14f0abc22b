"""The command line: options to settings, exit codes, progress, and problems before a run."""

from __future__ import annotations

import errno
import io
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from marked_folder import mark
from origami.core import errors
from origami.core.setting import Setting, declarations_within
from origami.headless.options import build_parser, settings_from
from origami.headless.terminal import Progress
from origami.origami_addon import feasibility, output_folder, own_results, run, settings_json
from origami.origami_addon.files.marker import MARKER
from origami.origami_addon.paper_size import PAPER_SIZES_MM, check_unit, paper_size
from origami.origami_addon.settings import RunSettings

EVERYTHING = ("report.json", "log.txt", "work", "cameras", *own_results.RESULTS)


def contents(folder: Path) -> dict[str, bytes]:
    """All files in a folder, those of folders in it too."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def settings_of(*options: str) -> RunSettings:
    return settings_from(build_parser().parse_args([*options]))


def said(capsys: pytest.CaptureFixture[str]) -> str:
    return capsys.readouterr().err


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


@pytest.mark.parametrize(
    "options",
    [["--surface", "magic"], ["--nothing"], ["--dpi", "many"], ["--resume", "--force"], ["--paper", "A99"], [], ["x"]],
)
def test_wrong_usage(command: ModuleType, capsys: pytest.CaptureFixture[str], options: list[str]) -> None:
    assert command.main(options) == 2
    assert said(capsys)


def test_help_and_settings_are_printed(command: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["--help"]) == 0
    assert "PHOTOS" in capsys.readouterr().out
    assert command.main(["--version"]) == 0
    capsys.readouterr()
    assert command.main(["--print-settings", "--seed", "3"]) == 0
    assert json.loads(capsys.readouterr().out)["sfm"]["seed"] == 3


def raising(error: BaseException) -> Callable[..., Any]:
    def rectify(*_: object, **__: object) -> None:
        raise error

    return rectify


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (errors.UsageError("A sentence."), 2),
        (errors.UnusablePhotos("A sentence."), 4),
        (errors.StepFailed("A sentence."), 5),
        (errors.Cancelled("A sentence."), 130),
        (KeyboardInterrupt(), 130),
        (ValueError("a bug"), 3),
    ],
)
def test_exit_codes(
    command: ModuleType,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    error: BaseException,
    code: int,
) -> None:
    monkeypatch.setattr(run, "rectify", raising(error))
    assert command.main(["photos", "-o", "out"]) == code
    if isinstance(error, errors.OrigamiError):
        assert "A sentence." in said(capsys)


def test_a_failure_repeats_the_warnings_before_it(
    command: ModuleType,
    small_photos: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def place(work: run.steps.Work, watch: object) -> None:
        work.report.warn("The edge is not sure.")
        raise errors.StepFailed("There are too few points.")

    monkeypatch.setattr(run.steps, "place_photos", place)
    assert command.main([str(small_photos), "-o", str(tmp_path / "out"), "-q"]) == 5
    assert capsys.readouterr().err == "warning: The edge is not sure.\nerror: There are too few points.\n"
    assert not (tmp_path / "out" / "report.json").exists()


def test_bad_photos(command: ModuleType, small_photos: Path, tmp_path: Path) -> None:
    out = ["-o", str(tmp_path / "out"), "-q"]
    assert command.main([str(tmp_path / "nowhere"), *out]) == 2
    assert command.main([str(small_photos / "00.jpg"), str(small_photos / "01.jpg"), *out]) == 4
    assert not (tmp_path / "out" / "report.json").exists()
    assert "photos are needed" in (tmp_path / "out" / "log.txt").read_text()


def test_a_reference_that_is_no_photo(
    command: ModuleType, small_photos: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command.main([str(small_photos), "-o", str(tmp_path), "-q", "--reference", "99.jpg"]) == 2
    assert "choose one of 00.jpg" in said(capsys)


def test_a_reference_that_is_two_photos(
    command: ModuleType, small_photos: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for source, copy in (("00", "a/1"), ("01", "b/1"), ("02", "b/2")):
        (tmp_path / copy).parent.mkdir(exist_ok=True)
        shutil.copy(small_photos / f"{source}.jpg", tmp_path / f"{copy}.jpg")
    folders = [str(tmp_path / "a"), str(tmp_path / "b")]
    assert command.main([*folders, "-o", str(tmp_path / "out"), "-q", "--reference", "1.jpg"]) == 2
    assert "say which is the reference: a/1.jpg or b/1.jpg" in said(capsys)


def test_a_page_too_large_for_a_tiff(
    command: ModuleType,
    small_photos: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    options = ["--paper", "700x700", "--dpi", "1100", "-q"]
    monkeypatch.setattr(run.steps, "place_photos", raising(errors.StepFailed("No.")))
    assert command.main([str(small_photos), "-o", str(tmp_path / "out"), *options]) == 5
    monkeypatch.setattr(feasibility, "read_pixels", lambda photo: np.zeros((1, 1, 3), np.uint16))
    assert command.main([str(small_photos), "-o", str(tmp_path / "out"), *options]) == 2
    assert "more than 4 GiB" in said(capsys)


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (ModuleNotFoundError("No module named 'scipy'", name="scipy"), 2, "make demo"),
        (ImportError("libSM.so.6: cannot open shared object file", name="bpy"), 2, "libSM.so.6"),
        (ModuleNotFoundError("No module named 'origami.core.flat'", name="origami.core.flat"), 3, "internal error"),
        (ImportError("cannot import name 'x' from 'origami'", name="origami"), 3, "internal error"),
        (ValueError("a bug"), 3, "internal error"),
    ],
)
def test_what_cannot_be_loaded(
    script: ModuleType,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    error: Exception,
    code: int,
    words: str,
) -> None:
    monkeypatch.setattr(script, "module", raising(error))
    assert script.main(["photos", "-o", "out"]) == code
    assert words in said(capsys)


class TestOut:
    """What may lie in the way of the results."""

    def test_a_file_in_its_place(self, command: ModuleType, small_photos: Path, tmp_path: Path) -> None:
        in_place = tmp_path / "out"
        in_place.write_text("mine")
        assert command.main([str(small_photos), "-o", str(in_place), "-q"]) == 2
        assert command.main([str(small_photos), "-o", str(in_place / "below"), "-q"]) == 2
        assert in_place.read_text() == "mine"

    @pytest.mark.parametrize(("name", "code"), [("log.txt", 2), ("page.tif", 2), ("cameras", 2), ("work/sfm", 5)])
    def test_something_else_in_the_place_of_a_result(
        self, command: ModuleType, small_photos: Path, tmp_path: Path, name: str, code: int
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

    def test_the_photos_own_folder(
        self, command: ModuleType, small_photos: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert command.main([str(small_photos), "-o", str(small_photos), "-q"]) == 2
        assert "folder of the photos" in said(capsys)
        assert not (small_photos / "work").exists()

    def test_a_finished_run(
        self, command: ModuleType, small_photos: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (tmp_path / "report.json").write_text('{"versions": {"origami": "0"}}')
        assert command.main([str(small_photos), "-o", str(tmp_path), "-q"]) == 2
        text = said(capsys)
        assert "--resume" in text
        assert "--force" in text

    @pytest.mark.parametrize("options", [["--resume"], ["--force"], ["--resume", "--colmap-model", "nowhere"]])
    def test_a_finished_run_stays_when_the_next_one_fails(
        self,
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
        self,
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
        self,
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
        self, command: ModuleType, small_photos: Path, tmp_path: Path
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
        self,
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
        self, command: ModuleType, small_photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        (tmp_path / "letter.txt").write_text("mine")
        monkeypatch.setattr(run.steps, "place_photos", raising(errors.StepFailed("No.")))
        for flag in ("-q", "--resume", "--force"):
            assert command.main([str(small_photos), "-o", str(tmp_path), flag]) == 5
        assert {path.name for path in tmp_path.iterdir()} == {"letter.txt", "work", "log.txt", MARKER}

    @pytest.mark.parametrize("flag", ["-q", "--resume", "--force"])
    @pytest.mark.parametrize("below", ["cameras", "work", "work/photos"])
    def test_photos_where_results_go(
        self,
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
        self, command: ModuleType, small_photos: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
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
        self,
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
        self,
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
        self, command: ModuleType, small_photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        (tmp_path / "report.json").write_text('{"versions": {"origami": "0"}, "settings": {}}')
        monkeypatch.setattr(run.steps, "place_photos", raising(errors.StepFailed("No.")))
        options = ["--force", "--settings", str(tmp_path / "report.json")]
        assert command.main([str(small_photos), "-o", str(tmp_path), *options]) == 5

    @pytest.mark.parametrize("number", [errno.EROFS, errno.EACCES])
    def test_it_cannot_be_written(
        self,
        command: ModuleType,
        small_photos: Path,
        tmp_path: Path,
        monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str],
        number: int,
    ) -> None:
        monkeypatch.setattr(output_folder.tempfile, "TemporaryFile", raising(OSError(number, os.strerror(number))))
        assert command.main([str(small_photos), "-o", str(tmp_path / "out"), "-q"]) == 2
        assert os.strerror(number) in said(capsys)

    def test_a_full_disk_before_and_during_a_run(
        self,
        command: ModuleType,
        small_photos: Path,
        tmp_path: Path,
        monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(tmp_path / "out"))
        with monkeypatch.context() as patch:
            patch.setattr(run.steps, "place_photos", raising(full))
            assert command.main([str(small_photos), "-o", str(tmp_path / "out"), "-q"]) == 5
        assert "disk" in said(capsys)
        monkeypatch.setattr(output_folder.tempfile, "TemporaryFile", raising(full))
        assert command.main([str(small_photos), "-o", str(tmp_path / "out"), "-q"]) == 5
        assert "disk" in said(capsys)

    def test_a_read_only_mount(
        self,
        command: ModuleType,
        small_photos: Path,
        mounted: Callable[[str], Path],
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        assert command.main([str(small_photos), "-o", str(mounted("ro,size=1m") / "out"), "-q"]) == 2
        assert "cannot be written" in said(capsys)

    def test_a_disk_that_fills_up(
        self,
        command: ModuleType,
        small_photos: Path,
        mounted: Callable[[str], Path],
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        assert command.main([str(small_photos), "-o", str(mounted("size=1m") / "out"), "-q"]) == 5
        assert "make room" in said(capsys)


@pytest.fixture
def mounted(tmp_path: Path) -> Iterator[Callable[[str], Path]]:
    """Mounts a small file system; skips where that is not allowed."""
    point = tmp_path / "mount"
    point.mkdir()

    def mount(options: str) -> Path:
        if not hasattr(os, "geteuid") or os.geteuid() != 0:
            pytest.skip("only root may mount")
        if subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(point)], capture_output=True).returncode:
            pytest.skip("mounting is not allowed here")
        return point

    yield mount
    subprocess.run(["umount", str(point)], capture_output=True, check=False)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_progress_is_a_bar_on_a_terminal_and_lines_elsewhere() -> None:
    terminal, file = Terminal(), io.StringIO()
    for stream in (terminal, file):
        progress = Progress(stream)
        for fraction in (0.0, 0.001, 0.01, 0.5, 1.0):
            progress(fraction, "Working")
        progress.end()
    assert terminal.getvalue().count("\r") == 4
    assert terminal.getvalue().endswith("\n")
    assert file.getvalue() == "  0 %  Working\n 50 %  Working\n100 %  Working\n"


def test_stdout_is_free_of_what_blender_prints(root: Path) -> None:
    text = f"""
import ctypes, runpy
module = runpy.run_path({str(root / "headless" / "rectify.py")!r})["module"]
with module("headless.terminal").without_blenders_chatter():
    ctypes.CDLL(None).puts(b"noise from C")
print("result")
"""
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert done.stdout == "result\n"


def test_ctrl_c_stops_the_run_and_its_worker(root: Path, example_photos: Path, tmp_path: Path) -> None:
    photos = sorted(example_photos.iterdir())[:3]
    process = subprocess.Popen(
        [sys.executable, root / "headless" / "rectify.py", *photos, "-o", tmp_path / "out", "--threads", "1"],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
    assert process.stderr is not None
    lines = []
    for line in process.stderr:
        lines.append(line)
        if "features in photo 1 " in line:  # the worker is in the midst of it
            break
    assert all(" %  " in line for line in lines), lines
    os.killpg(process.pid, signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 130
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)
    assert not (tmp_path / "out" / "report.json").exists()
