"""Runs that meet others: in the same folder, with what a power failure left, with photos that change."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from folded import folded_sheet, stand_in_for_steps
from origami.core.errors import UnusablePhotos, UsageError
from origami.origami_addon import run
from origami.origami_addon.files.folder_lock import only_run_in
from origami.origami_addon.files.kept import kept
from origami.origami_addon.files.marker import LOCK, MARKER
from origami.origami_addon.files.photos import gather, read_pixels
from origami.origami_addon.settings import RunSettings
from PIL import Image

RESULTS = {"page.tif": "a page", "sheet.obj": "a sheet", "map.npz": "a map"}


@pytest.fixture
def stand(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Runs with stand-ins for the steps; they count, and call ``meanwhile`` while they run."""
    out, now = tmp_path / "out", SimpleNamespace(computed=0, meanwhile=lambda: None)
    model = folded_sheet().model

    def place(*_: object) -> object:
        now.computed += 1
        now.meanwhile()
        return model

    def write_results(state: object, work: object, into: Path, *_: object) -> None:
        for name, text in RESULTS.items():
            (into / name).write_text(text)

    stand_in_for_steps(monkeypatch, run.steps)
    monkeypatch.setattr(run.steps, "place_photos", place)
    monkeypatch.setattr(run.steps, "write_results", write_results)
    now.out, now.go = out, lambda **how: run.rectify([photos], out, RunSettings(), **how)
    now.go()
    return now


def test_a_second_run_is_refused_while_the_first_goes_on(stand: SimpleNamespace) -> None:
    refused: list[str] = []

    def again() -> None:
        with pytest.raises(UsageError) as error:
            stand.go(force=True)
        refused.append(str(error.value))

    stand.meanwhile = again
    stand.go(force=True)
    assert f"(process {os.getpid()} on " in refused[0]
    assert not (stand.out / LOCK).exists()
    assert {name: (stand.out / name).read_text() for name in RESULTS} == RESULTS


_HOLDER = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
import runpy
runpy.run_path(sys.argv[2] + "/headless/checkout.py")["load_checkout"]()
from origami.origami_addon.files.folder_lock import only_run_in
with only_run_in(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def holder(tmp_path: Path, root: Path) -> Iterator[subprocess.Popen[str]]:
    """Another process that holds the folder's lock."""
    command = [sys.executable, "-c", _HOLDER, str(tmp_path), str(root)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def test_the_lock_of_a_run_that_was_killed_is_taken_over(holder: subprocess.Popen[str], tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=f"process {holder.pid} on "), only_run_in(tmp_path):
        pass
    holder.kill()
    holder.wait()
    assert (tmp_path / LOCK).exists()
    with only_run_in(tmp_path):
        assert json.loads((tmp_path / LOCK).read_text())["process"] == os.getpid()
    assert not (tmp_path / LOCK).exists()


@pytest.mark.parametrize("content", ["theirs", "{}", "[" * 9999, '{"application": "Paperfold"}'])
def test_a_lock_of_the_users_is_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / LOCK).write_text(content)
    with pytest.raises(UsageError, match="Origami did not write"), only_run_in(tmp_path):
        pass
    assert (tmp_path / LOCK).read_text() == content


def test_a_marker_that_was_copied_proves_nothing(stand: SimpleNamespace, tmp_path: Path) -> None:
    theirs = tmp_path / "theirs"
    theirs.mkdir()
    shutil.copy(stand.out / MARKER, theirs)
    (theirs / "page.tif").write_text("theirs")
    for also in ("", "report.json"):  # a report alone, whose page is another, proves nothing either
        if also:
            (theirs / MARKER).unlink()
            shutil.copy(tmp_path / "out" / also, theirs)
        with pytest.raises(UsageError, match="which Origami did not write there"):
            run.rectify([tmp_path / "photos"], theirs, RunSettings(), force=True)
        assert (theirs / "page.tif").read_text() == "theirs"


def test_a_folder_that_was_copied_or_lost_its_marker_is_still_ours(stand: SimpleNamespace, tmp_path: Path) -> None:
    shutil.copytree(stand.out, tmp_path / "copy")
    run.rectify([tmp_path / "photos"], tmp_path / "copy", RunSettings(), force=True)
    (stand.out / MARKER).unlink()
    stand.go(force=True)
    assert (
        json.loads((stand.out / MARKER).read_text())["number"]
        == json.loads((stand.out / "report.json").read_text())["number"]
    )


@pytest.mark.parametrize("name", RESULTS)
@pytest.mark.parametrize("damage", [lambda content: b"", lambda content: b"?" + content[1:]])
def test_damaged_results_are_made_again(stand: SimpleNamespace, name: str, damage: Callable[[bytes], bytes]) -> None:
    path = stand.out / name
    path.write_bytes(damage(path.read_bytes()))
    before = stand.computed
    stand.go(resume=True)
    assert stand.computed == before + 1
    assert path.read_text() == RESULTS[name]


@pytest.mark.parametrize("damage", [*range(0, 400, 57), "empty", "short", "gone"])
def test_damaged_kept_results_are_reported_and_made_again(tmp_path: Path, damage: int | str) -> None:
    computed: list[bool] = []
    warnings: list[str] = []

    def compute() -> tuple[dict[str, Any], dict[str, Any]]:
        computed.append(True)
        return {"array": np.arange(20)}, {"figure": 1}

    def again() -> Any:
        arrays, notes = kept(tmp_path, "step", 16 * "0", compute, warnings.append)
        return arrays["array"].tolist(), notes

    first = again()
    assert again() == first
    assert len(computed) == 1
    (path,) = tmp_path.iterdir()
    content = path.read_bytes()
    if damage == "gone":
        path.unlink()
    elif isinstance(damage, int):
        path.write_bytes(content[:damage] + bytes([content[damage] ^ 1]) + content[damage + 1 :])
    else:
        path.write_bytes(b"" if damage == "empty" else content[:-30])
    assert again() == first
    assert len(computed) == 2
    assert [("damaged" in text, str(path) in text) for text in warnings] == [(True, True)] * (damage != "gone")
    assert [each.read_bytes() for each in tmp_path.iterdir()] == [content]


def test_what_the_user_put_beside_the_kept_results_stays(stand: SimpleNamespace) -> None:
    for name in ("work/notes.txt", ".writing-poem/poem.txt", "work/poems/1.txt"):
        (stand.out / name).parent.mkdir(exist_ok=True)
        (stand.out / name).write_text("theirs")
    stand.go(force=True)
    stand.go(resume=True)
    for name in ("work/notes.txt", ".writing-poem/poem.txt", "work/poems/1.txt"):
        assert (stand.out / name).read_text() == "theirs"


def test_kept_files_are_never_written_through(stand: SimpleNamespace, tmp_path: Path) -> None:
    database = stand.out / "work" / "sfm" / "database.db"
    database.parent.mkdir()
    database.write_text("before")
    os.link(database, tmp_path / "backup")
    stand.go(resume=True)
    database.write_text("after")
    assert (tmp_path / "backup").read_text() == "before"


def test_a_photo_that_is_replaced_is_noticed_when_it_is_read(photos: Path) -> None:
    found, _ = gather(photos)
    assert read_pixels(found[1]).shape == (200, 300, 3)
    before = found[1].path.stat()
    Image.new("RGB", (300, 200), (9, 9, 9)).save(found[1].path)
    os.utime(found[1].path, ns=(before.st_atime_ns, before.st_mtime_ns))
    with pytest.raises(UnusablePhotos, match="changed during the run"):
        read_pixels(found[1])


@pytest.mark.skipif(sys.platform == "win32", reason="shells of POSIX")
@pytest.mark.parametrize(
    ("redirected", "code"),
    [
        ("--help | true; exit ${PIPESTATUS[0]}", 0),
        ("--print-settings > /dev/full", 5),
        ("nowhere -o out 2> /dev/full", 2),
        ("nowhere -o out <&- >&- 2>&-", 2),
    ],
)
def test_nobody_listens(root: Path, tmp_path: Path, redirected: str, code: int) -> None:
    """And nothing stays in the folder for temporary files."""
    if "/dev/full" in redirected and not os.path.exists("/dev/full"):
        pytest.skip("no device that is always full")
    (tmp_path / "temporary").mkdir()
    done = subprocess.run(
        ["bash", "-c", f"'{sys.executable}' '{root / 'headless' / 'rectify.py'}' {redirected}"],
        cwd=tmp_path,
        env=os.environ | {"TMPDIR": str(tmp_path / "temporary")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    assert not list((tmp_path / "temporary").iterdir())


def test_letters_that_the_terminal_does_not_have(root: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, root / "headless" / "rectify.py", "Δελτα", "-o", "out"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONIOENCODING": "cp1252", "PYTHONUTF8": "0"},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 2
    assert rb"\u0394" in done.stderr
