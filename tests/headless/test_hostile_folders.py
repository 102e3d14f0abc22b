"""Bad folders of photos and of results: each ends with the right exit code and a sentence that says why."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import USED
from marked_folder import mark


def pipe(path: Path) -> None:
    os.mkfifo(path)


def file(path: Path) -> None:
    path.write_text("theirs")


def folder(path: Path) -> None:
    path.mkdir()


def circle(path: Path) -> None:
    path.symlink_to(path.name)


def dangling(path: Path) -> None:
    path.symlink_to("nowhere at all")


def zeros(path: Path) -> None:
    path.symlink_to("/dev/zero")


POSIX = pytest.mark.skipif(sys.platform == "win32", reason="pipes and links of POSIX")


@POSIX
@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda path: None, "check the path"),
        (folder, "no photos"),
        (file, "are needed"),
        (pipe, "a pipe or a device"),
        (circle, "check the path"),
        (dangling, "check the path"),
        (zeros, "a pipe or a device"),
        (lambda path: [folder(path), pipe(path / "1.jpg")], "no photos"),
        (lambda path: [folder(path), zeros(path / "1.jpg")], "no photos"),
        (lambda path: [folder(path), circle(path / "1.jpg")], "no photos"),
        (lambda path: [folder(path), folder(path / "1.jpg")], "no photos"),
        (lambda path: [folder(path), file(path / "\n.jpg")], r"are needed.*\\n.jpg"),
        (lambda path: [folder(path), file(path / "\x1b[2J.jpg")], r"are needed.*\\x1b\[2J.jpg"),
        (lambda path: [folder(path), file(path / os.fsdecode(b"\xff\xfe.jpg"))], "are needed.*is not text"),
    ],
)
def test_the_place_of_the_photos(
    ends: Callable[..., tuple[int, str]], tmp_path: Path, make: Callable[[Path], object], words: str
) -> None:
    make(tmp_path / "photos")
    code, said = ends(tmp_path / "photos", "-o", tmp_path / "out")
    assert code in (2, 4)
    assert re.search(words, said), said


@POSIX
@pytest.mark.parametrize("name", ["x" * 300, "x" * 5000, os.fsdecode(b"\xff"), "\n", "a\x1b[31m", "∆ελτα"])
def test_names_of_photos_and_results(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, name: str
) -> None:
    for arguments in ([tmp_path / name, "-o", tmp_path / "out"], [good, "-o", tmp_path / name]):
        code, said = ends(*arguments)
        assert code in (2, 5)
        assert code == 2 or USED in said


def states(folder: Path) -> dict[str, tuple[int, ...]]:
    """What lies in a folder."""
    there = {path.name: path.lstat() for path in folder.iterdir()}
    return {name: (state.st_mode, state.st_ino, state.st_size, state.st_mtime_ns) for name, state in there.items()}


RESULTS = ["page.tif", "page.jpg", "document.blend", "report.json", "log.txt", "sheet.obj", "map.npz", "outline.json"]
KINDS = [file, folder, pipe, circle, dangling, zeros]


@POSIX
@pytest.mark.parametrize("make", KINDS)
@pytest.mark.parametrize("name", [*RESULTS, ".origami", ".origami-lock", "work", "cameras"])
def test_something_in_the_place_of_a_result(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, name: str, make: Callable[[Path], object]
) -> None:
    """In a folder that nobody marked, and in one whose marker was copied from elsewhere."""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    mark(elsewhere, [*RESULTS, "work", "cameras"])
    for copied in (False, True):
        out = tmp_path / f"out {copied}"
        out.mkdir()
        if copied and name != ".origami":
            (out / ".origami").write_bytes((elsewhere / ".origami").read_bytes())
        make(out / name)
        before = states(out)
        for flag in ("-q", "--force", "--resume"):
            code, said = ends(good, "-o", out, flag)
            assert code == 2
            assert name in said
            assert states(out) == before


@POSIX
@pytest.mark.parametrize("make", KINDS)
@pytest.mark.parametrize("name", ["page.tif", "log.txt", "cameras", "work", "report.json"])
def test_something_in_the_place_of_a_result_that_a_run_has_made(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, name: str, make: Callable[[Path], object]
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    mark(out, [*RESULTS, "work", "cameras"])
    make(out / name)
    code, said = ends(good, "-o", out, "--force")
    allowed = (make is folder) == (name in ("cameras", "work")) and make in (file, folder)
    assert code == (5 if allowed else 2)
    assert (USED if allowed else name) in said


@POSIX
@pytest.mark.parametrize("make", [file, pipe, circle, dangling, zeros])
def test_something_in_the_place_of_the_folder(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, make: Callable[[Path], object]
) -> None:
    make(tmp_path / "out")
    for out in (tmp_path / "out", tmp_path / "out" / "below"):
        code, said = ends(good, "-o", out)
        assert code == 2
        assert "choose another folder" in said or "check the path" in said
