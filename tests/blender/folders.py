"""A shelf of folders, as a stranger adds it: given up, twice, in part, one deleted meanwhile, the file reloaded."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

import bpy

from .hands import Waits
from .user import User

_BUTTON = "bpy.ops.origami.add_folders"
_RESUME, _ALL = "bpy.ops.origami.resume_queue", "bpy.ops.origami.rectify_all"
_PHOTOS = ("broken", "first", "Ordner ü", "second")
_PATIENCE_SECONDS = 300
_SOON_SECONDS = 10  # until the next document of the queue runs
_MANY = 60  # folders: more than the window is high


def scene(user: User) -> Waits:
    """Each part begins with an empty file; what runs is ended early, because other scenes finish it."""
    shelf = _shelf(user)
    yield from user.new_file()
    yield from _given_up(user, shelf)
    yield from _some(user, shelf)
    yield from _twice(user, shelf)
    yield from user.new_file()
    yield from _gone_meanwhile(user, shelf)
    yield from _reloaded(user)
    yield from _one_folder(user, shelf / "first")
    yield from _many(user, shelf)


def _shelf(user: User) -> Path:
    shelf = user.folder / "stranger"
    for name in _PHOTOS:
        shutil.copytree(user.folder / "two_sheets", shelf / name)
    for photo in (shelf / "broken").glob("*.png"):
        photo.write_bytes(photo.read_bytes()[:500])
    (shelf / "clip").mkdir()
    (shelf / "clip" / "walk.mp4").write_bytes(b"\0\0\0\x20ftypmp42" + bytes(64))
    (shelf / "empty").mkdir()
    (shelf / "photos are deeper" / "inside").mkdir(parents=True)
    shutil.copy(user.folder / "two_sheets" / "0.png", shelf / "photos are deeper" / "inside")
    return shelf


def _documents(user: User) -> list[str]:
    return sorted(each.title for each in user.module("scene.document").documents())


def _queue(user: User) -> object:
    return user.module("jobs.queue").queue


def _browse(user: User, folder: Path, *, select: bool = False, accept: bool = True) -> Waits:
    """The button, then the file browser at this folder."""
    yield from user.hands.press(_BUTTON)
    yield 3.0
    browser = bpy.context.window_manager.windows[-1]
    area = next(area for area in browser.screen.areas if area.type == "FILE_BROWSER")
    area.spaces.active.params.directory = f"{folder}/".encode()
    yield 2.0
    with bpy.context.temp_override(window=browser, area=area):
        if select:
            bpy.ops.file.select_all(action="SELECT")
        if accept:
            bpy.ops.file.execute("INVOKE_DEFAULT")
        else:
            bpy.ops.file.cancel()
    yield 1.5


def _given_up(user: User, shelf: Path) -> Waits:
    """In the file browser, and in the dialog; a folder without photos says so."""
    yield from _browse(user, shelf, accept=False)
    user.check("a closed file browser makes nothing", _documents(user) == [] and user.modal() == [])
    yield from _browse(user, shelf)
    user.hands.picture("folders_of_a_stranger")
    yield from user.hands.key("ESC")
    yield 1.0
    user.check("ESC in the dialog makes nothing", _documents(user) == [] and user.modal() == [])
    yield from _browse(user, shelf / "empty")
    yield from user.hands.key("ESC")
    user.check("a folder without photos makes nothing", _documents(user) == [] and user.running() is None)


def _add(user: User, shelf: Path, picture: str) -> Waits:
    """Add all folders, and wait until the first good one runs."""
    yield from _browse(user, shelf)
    yield from user.hands.press_blue(picture)
    yield 1.0
    until = time.monotonic() + _PATIENCE_SECONDS
    while not _runs(user, "first") and time.monotonic() < until:
        yield 0.1


def _some(user: User, shelf: Path) -> Waits:
    yield from _add(user, shelf, "folders_before_add")
    there = _documents(user)
    user.check("each folder with photos or a movie is a document", there == sorted((*_PHOTOS, "clip")), there)
    failure_of = user.module("jobs.running").failure_of
    for name in ("broken", "clip"):
        failure = failure_of(name)
        user.check(f"{name} says why it fails", failure is not None and "report it" not in failure.sentence, failure)
    yield from user.hands.sidebar_picture("queue_of_a_stranger")


def _runs(user: User, name: str) -> bool:
    return user.running() is not None and user.running().document == name


def _twice(user: User, shelf: Path) -> Waits:
    """The same shelf again, by mistake, then with all its folders selected."""
    before = _documents(user)
    yield from _browse(user, shelf)
    user.hands.picture("folders_twice")
    yield from user.hands.press_blue("folders_twice_dialog")
    yield 1.0
    user.check("pressed twice, no document is there twice", _documents(user) == before, _documents(user))
    yield from user.hands.key("ESC")
    yield 0.5
    yield from _browse(user, shelf, select=True)
    user.hands.picture("folders_selected")
    yield from user.hands.key("ESC")
    yield 1.0
    user.check("ESC leaves it so", _documents(user) == before, _documents(user))


def _gone_meanwhile(user: User, shelf: Path) -> Waits:
    """Documents that wait are deleted in the outliner, one and then all, and come back by Undo."""
    yield from _add(user, shelf, "folders_again")
    waits = _queue(user).waiting
    user.check("two wait", waits == ["Ordner ü", "second"], waits)
    yield from _delete(user, "Ordner ü")
    yield from user.hands.sidebar_picture("queued_one_deleted")
    yield from _end_run(user)
    user.check("ESC ends the run, and the queue waits", user.running() is None and _queue(user).paused)
    yield from user.hands.sidebar_picture("queue_paused_one_deleted")
    _queue(user).leave("first")
    yield from user.hands.press(_RESUME)
    until = time.monotonic() + _SOON_SECONDS
    while user.running() is None and time.monotonic() < until:
        yield 0.1
    user.check("one that is gone is passed over", _runs(user, "second"), _queue(user).waiting)
    yield from _end_run(user)
    yield from _delete(user, "second")
    place = yield from user.hands.find(_ALL)
    user.check("with all that wait gone, there is nothing to resume", place)
    for name in ("second", "Ordner ü"):
        yield from user.hands.over()
        yield from user.hands.key("Z", "ctrl")
        yield 1.0
        user.check(f"Ctrl-Z brings {name} back", name in _documents(user), _documents(user))
    place = yield from user.hands.find(_RESUME)
    user.check("  and second waits again", place)
    yield from user.hands.sidebar_picture("queue_paused_undone")
    _queue(user).leave("second")


def _delete(user: User, name: str) -> Waits:
    bpy.data.collections.remove(bpy.data.collections[name])
    bpy.ops.ed.undo_push(message="Delete Collection")
    yield 1.0


def _end_run(user: User) -> Waits:
    yield from user.hands.over()
    yield from user.hands.key("ESC")
    yield 2.0


def _reloaded(user: User) -> Waits:
    """The file is opened again while one runs and others wait."""
    path = user.folder / "stranger.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    there = _documents(user)
    yield from user.hands.press(_ALL)
    until = time.monotonic() + 60
    while not any(_runs(user, name) for name in ("first", "Ordner ü")) and time.monotonic() < until:
        yield 0.1
    user.check("some wait", bool(_queue(user).waiting), _queue(user).waiting)
    yield from user.open(path)
    user.check("reloaded, nothing runs or waits", user.running() is None and not _queue(user).waiting)
    yield 2.0
    user.check("  nor begins by itself", user.running() is None and user.modal() == [], user.modal())
    user.check("  and all documents are there", _documents(user) == there, _documents(user))


def _one_folder(user: User, folder: Path) -> Waits:
    """The folder of one sheet is chosen instead of the one that holds it."""
    yield from user.new_file()
    yield from _browse(user, folder)
    user.hands.picture("folders_one")
    yield from user.hands.press_blue("folders_one_dialog")
    yield 1.0
    user.check("one folder of photos is one document", _documents(user) == ["first"], _documents(user))
    yield from _end_run(user)


def _many(user: User, shelf: Path) -> Waits:
    """More folders than fit into the window."""
    for number in range(_MANY):
        (shelf / "many" / f"sheet {number:02d}").mkdir(parents=True)
        shutil.copy(user.folder / "two_sheets" / "0.png", shelf / "many" / f"sheet {number:02d}")
    yield from user.new_file()
    yield from _browse(user, shelf / "many")
    yield from user.hands.press_blue("folders_many")
    yield 1.0
    user.check("the dialog of many folders has its button", len(_documents(user)) == _MANY, len(_documents(user)))
    until = time.monotonic() + _PATIENCE_SECONDS
    while user.module("jobs.running").failure_of("sheet 00") is None and time.monotonic() < until:
        yield 0.2
    yield from user.hands.sidebar_picture("many_documents")
    yield from user.hands.over()
    while user.running() is None and _queue(user).waiting and time.monotonic() < until:
        yield 0.1
    yield from user.hands.key("ESC")
    yield 2.0
