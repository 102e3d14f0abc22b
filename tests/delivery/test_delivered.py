"""Delivered files are complete or as they were, and no file of the user's is replaced."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest
from origami.core.errors import UsageError
from origami.origami_addon.files.photo_files import photos_in
from origami.workflow.delivery.command import exit_code_of
from origami.workflow.delivery.delivered import delivering


def deliver(folder: Path, **files: str) -> None:
    with delivering(folder, "last.xml") as new:
        for name, text in files.items():
            path = new / f"{name.replace('__', '/')}.xml"
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")


def names(folder: Path) -> set[str]:
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*")}
    return files - {".origami", "delivered.json"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "text"


def test_a_second_delivery_replaces_the_first_and_removes_what_it_no_longer_has(folder):
    deliver(folder, last="1", a="1", inside__b="1", old__c="1")
    deliver(folder, last="2", a="2", inside__b="2")
    assert names(folder) == {"last.xml", "a.xml", "inside", "inside/b.xml"}
    assert (folder / "inside" / "b.xml").read_text() == "2"


def test_a_delivery_that_fails_leaves_the_earlier_one(folder):
    deliver(folder, last="1", a="1")
    with pytest.raises(ZeroDivisionError), delivering(folder, "last.xml") as new:
        (new / "a.xml").write_text("2")
        raise ZeroDivisionError
    assert names(folder) == {"last.xml", "a.xml"}
    assert (folder / "a.xml").read_text() == "1"


def test_a_delivery_stopped_between_two_files_is_made_again(folder, monkeypatch):
    deliver(folder, last="1", a="1", b="1")
    replaced = []

    def stop(source: Path, target: Path) -> None:
        if Path(target).suffix == ".xml" and replaced:
            raise KeyboardInterrupt
        replaced.append(target)
        Path(source).rename(target)

    with monkeypatch.context() as patched:
        patched.setattr("origami.workflow.delivery.delivered.os.replace", stop)
        with pytest.raises(KeyboardInterrupt):
            deliver(folder, last="2", a="2", b="2")
    assert not (folder / "last.xml").exists()  # nothing says that it is complete
    deliver(folder, last="3", a="3", b="3")
    assert {path.read_text() for path in folder.glob("*.xml")} == {"3"}


def test_what_a_killed_delivery_left_behind_goes(folder):
    deliver(folder, last="1")
    (folder / ".writing-old").mkdir()
    deliver(folder, last="2")
    assert names(folder) == {"last.xml"}


def test_a_file_that_somebody_has_corrected_is_kept(folder):
    deliver(folder, last="1", a="1")
    (folder / "a.xml").write_text("corrected")
    with pytest.raises(UsageError, match=r"a\.xml was changed since it was written"):
        deliver(folder, last="2", a="2")
    assert (folder / "a.xml").read_text() == "corrected"
    assert (folder / "last.xml").read_text() == "1"
    (folder / "a.xml").unlink()
    deliver(folder, last="2", a="2")


@pytest.mark.parametrize("theirs", ["a.xml", "inside"])
def test_a_file_of_the_users_is_kept(folder, theirs):
    folder.mkdir()
    (folder / theirs).write_text("mine")
    with pytest.raises(UsageError, match="did not write there"):
        deliver(folder, last="1", a="1", inside__b="1")
    assert names(folder) == {theirs}
    assert (folder / theirs).read_text() == "mine"


def test_two_deliveries_at_once(folder):
    with delivering(folder, "last.xml"), pytest.raises(UsageError, match="Another run"):
        deliver(folder, last="1")


def test_a_link_or_a_file_in_the_place_of_the_folder(folder, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    folder.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(UsageError, match="is a link"):
        deliver(folder, last="1")
    folder.unlink()
    folder.write_text("mine")
    with pytest.raises(UsageError, match="cannot be written"):
        deliver(folder, last="1")


def test_a_later_search_for_photos_passes_the_folder_by(folder):
    (folder.parent / "photo.jpg").write_bytes(b"\xff\xd8\xff")
    with delivering(folder, "last.jpg") as new:
        (new / "last.jpg").write_bytes(b"\xff\xd8\xff")
    found, _ = photos_in(folder.parent, recursive=True)
    assert [path.name for path in found] == ["photo.jpg"]


def test_a_command_asked_to_stop_leaves_nothing_behind(folder):
    def command() -> None:
        with delivering(folder, "last.xml"):
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(10)

    before = signal.getsignal(signal.SIGTERM)
    assert exit_code_of(command) == 130
    assert signal.getsignal(signal.SIGTERM) is before
    assert not folder.exists()


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (UsageError("Name a folder."), 2, "error: Name a folder."),
        (OSError(28, "No space left on device", "/a/b"), 5, "error: /a/b could not be used (No space left on device)"),
        (KeyError("x"), 3, "internal error: KeyError: 'x'; please report it"),
    ],
)
def test_a_command_fails_with_a_code_and_a_sentence(capsys, error, code, said):
    def command() -> None:
        raise error

    assert exit_code_of(command) == code
    assert capsys.readouterr().err.startswith(said)
