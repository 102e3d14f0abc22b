"""The command line: exit codes, progress, and problems before a run."""

from __future__ import annotations

import io
import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from command_line import raising, said
from origami.core import errors
from origami.headless.terminal import Progress
from origami.origami_addon import feasibility, run
from origami.origami_addon.report import version


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--surface", "magic"], "invalid choice: 'magic'"),
        (["--nothing"], "unrecognized arguments: --nothing"),
        (["--dpi", "many"], "'many' is not a number"),
        (["--resume", "--force"], "not allowed with argument --resume"),
        (["--paper", "A99"], "paper size 'A99'"),
        ([], "No photos were named"),
        (["x"], "No folder for the results was named"),
    ],
)
def test_wrong_usage(command: ModuleType, capsys: pytest.CaptureFixture[str], options: list[str], words: str) -> None:
    assert command.main(options) == 2
    assert words in said(capsys).rpartition("error: ")[2]


def test_help_and_settings_are_printed(command: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["--help"]) == 0
    assert "PHOTOS" in capsys.readouterr().out
    assert command.main(["--version"]) == 0
    assert capsys.readouterr().out == f"Origami {version()}\n"
    assert command.main(["--print-settings", "--seed", "3"]) == 0
    assert json.loads(capsys.readouterr().out)["sfm"]["seed"] == 3


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
        if "features in photo 1 " in line:  # the worker is busy with it
            break
    assert all(" %  " in line for line in lines), lines
    os.killpg(process.pid, signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 130
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)
    assert not (tmp_path / "out" / "report.json").exists()
