"""Three folders, one with damaged photos: each becomes a document, one after the other, while the user works."""

from __future__ import annotations

import shutil
import time

import bpy

from .hands import Waits
from .user import STAGES, User

_NAMES = ("broken", "first", "second")
_PATIENCE_SECONDS = 900
_ON_ITS_WAY = 0.3  # share of a run
_MOVED = 0.1


def scene(user: User) -> Waits:
    """Chosen in the file browser, worked through, stopped, resumed; then one is duplicated, renamed and deleted."""
    folder = user.folder / "folders"
    for name in _NAMES:
        shutil.copytree(user.folder / "two_sheets", folder / name)
    for photo in (folder / _NAMES[0]).glob("*.png"):
        photo.write_bytes(photo.read_bytes()[:500])
    (folder / "texts").mkdir()
    (folder / "texts" / "notes.txt").write_text("notes")
    yield from user.new_file()
    yield from _choose_folders(user, folder)
    yield from _while_it_runs(user)
    yield from _stopped(user)
    yield from _finished(user)
    yield from _in_the_list(user)


def _documents(user: User) -> dict[str, object]:
    return {each.title: each for each in user.module("scene.document").documents()}


def _queue(user: User) -> object:
    return user.module("jobs.queue").queue


def _choose_folders(user: User, folder: object) -> Waits:
    """The button, then all folders in the file browser."""
    yield from user.hands.press("bpy.ops.origami.add_folders")
    yield 3.0
    browser = bpy.context.window_manager.windows[-1]
    area = next(area for area in browser.screen.areas if area.type == "FILE_BROWSER")
    area.spaces.active.params.directory = f"{folder}/".encode()
    yield 2.0
    user.hands.picture("add_folders", user.hands.box(browser))
    with bpy.context.temp_override(window=browser, area=area):
        bpy.ops.file.execute("INVOKE_DEFAULT")
    yield 1.0
    yield from user.hands.press_blue("folders_dialog")
    yield 1.0
    titles = sorted(_documents(user))
    user.check("each folder with photos is a document", titles == sorted(_NAMES), titles)
    until = time.monotonic() + _PATIENCE_SECONDS
    while not _runs(user, "first") and time.monotonic() < until:
        yield 0.1
    failure = user.module("jobs.running").failure_of("broken")
    user.check("  the broken one fails, and says why", failure is not None, failure and failure.sentence)
    user.check("  the next one runs", _runs(user, "first"))
    user.check("  the last one waits", _queue(user).waiting == ["second"], _queue(user).waiting)


def _runs(user: User, name: str) -> bool:
    return user.running() is not None and user.running().document == name


def _while_it_runs(user: User) -> Waits:
    """The user reads why one has failed, and moves an object; the tab shows how far all are."""
    while _runs(user, "first") and user.running().fraction < _ON_ITS_WAY:
        yield 0.2
    bpy.context.scene.origami.place = bpy.data.collections.find("broken")
    yield 1.0
    user.check("another document can be looked at meanwhile", user.document().title == "broken")
    yield from user.hands.sidebar_picture("queue")
    cube = bpy.data.objects["Cube"]
    cube.select_set(True)
    bpy.context.view_layer.objects.active = cube
    bpy.ops.ed.undo_push(message="Select")
    yield from user.hands.over()
    yield from user.hands.key("G")
    yield from user.hands.move(user.hands.mouse[0] + 100, user.hands.mouse[1])
    yield from user.hands.key("LEFTMOUSE")
    yield 0.5
    user.check("  and objects be moved", cube.location.length > _MOVED, cube.location)


def _stopped(user: User) -> Waits:
    """ESC ends the first run; the queue waits for the user."""
    user.check("the run goes on meanwhile", _runs(user, "first"))
    first = _documents(user)["first"].collection.origami
    while _runs(user, "first") and not first.place.done:
        yield 0.1
    user.module("scene.document").new_document("newer", bpy.context.scene)
    bpy.ops.ed.undo_push(message="Newer Document")
    yield 0.5
    yield from user.hands.key("ESC")
    yield 2.0
    user.check("ESC ends it, and the queue waits", user.running() is None and _queue(user).paused)
    user.check("  with both documents", _queue(user).waiting == ["first", "second"], _queue(user).waiting)
    yield from user.hands.sidebar_picture("queue_paused")
    there = sorted(_documents(user))
    user.check("  all documents are there, one begun since then too", there == sorted((*_NAMES, "newer")), there)
    user.module("scene.document").remove_document("newer")
    bpy.ops.ed.undo_push(message="Delete")
    yield from user.hands.press("bpy.ops.origami.resume_queue")
    yield 1.0
    user.check("Resume goes on", user.running() is not None)


def _finished(user: User) -> Waits:
    until = time.monotonic() + _PATIENCE_SECONDS
    while (user.running() is not None or _queue(user).waiting) and time.monotonic() < until:
        yield 0.5
    yield 2.0
    for name in ("first", "second"):
        group = _documents(user)[name].collection.origami
        done = [stage for stage in STAGES if getattr(group, stage).done]
        user.check(f"{name} is finished", done == list(STAGES), user.module("jobs.running").failure_of(name))
    user.hands.picture("queue_finished")


def _in_the_list(user: User) -> Waits:
    """Duplicate, rename and delete by the buttons, each undone in one step."""
    bpy.context.view_layer.objects.active = None
    bpy.context.scene.origami.place = bpy.data.collections.find("first")
    bpy.ops.ed.undo_push(message="Document")
    yield 0.5
    yield from user.hands.press("bpy.ops.origami.duplicate_document")
    yield 1.0
    copy = user.document()
    user.check("the copy is chosen", copy.title == "first.001" and user.done() == list(STAGES), copy.title)
    yield from user.hands.over()
    yield from user.hands.key("Z", "ctrl")
    yield 1.0
    user.check("  Ctrl-Z takes it back in one step", sorted(_documents(user)) == sorted(_NAMES), list(_documents(user)))
    before = user.state_digest()
    yield from user.hands.press("bpy.ops.origami.delete_document")
    yield 1.0
    user.hands.picture("delete_document")
    yield from user.hands.key("RET")
    yield 1.0
    user.check("the document is deleted once confirmed", "first" not in _documents(user), list(_documents(user)))
    user.check("  and nothing else", "Cube" in bpy.data.objects and len(_documents(user)) == 2)
    yield from user.hands.over()
    yield from user.hands.key("Z", "ctrl")
    yield 1.0
    there = "first" in _documents(user)
    user.check("  Ctrl-Z brings it back in one step", there and user.state_digest() == before, user.document().title)
