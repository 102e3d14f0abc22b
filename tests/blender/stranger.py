"""What a stranger does to a file: other units, linked documents, long names, moved photos, buttons pressed twice."""

from __future__ import annotations

import shutil
from pathlib import Path

import bpy

from .buttons import shown
from .hands import Waits
from .user import STAGES, User

_NAMES = ('a/b\\c: *?"<>|', "..", "x" * 200)
_LONG_WORDS = ("Traceback", "Error:", "report it", "unexpectedly")
_DRAWN_SECONDS = 2.0


def scene(user: User) -> Waits:
    """Each part starts with the same finished document, or with a new file."""
    path = yield from user.two_sheets("page")
    yield from _no_photos(user)
    yield from _same_photos_twice(user)
    yield from _other_units(user, path)
    yield from _linked(user, path)
    yield from _pressed_twice(user, path)
    yield from _undone_after_each(user, path)
    yield from _named(user, path)
    yield from _photos_moved(user, path)
    yield from _saved_elsewhere(user, path)


def _push(message: str) -> None:
    bpy.ops.ed.undo_push(message=message)


def _press(user: User, operator: str, **properties: object) -> str:
    """Press a button; returns what it says if it cannot."""
    try:
        with user.hands.at():
            getattr(bpy.ops.origami, operator)("INVOKE_DEFAULT", True, **properties)
    except RuntimeError as error:
        return str(error).strip()
    return ""


def _ended(user: User, what: str) -> Waits:
    """Wait for the job; returns its failure's sentence."""
    yield 0.3
    yield from user.wait_for_end()
    failure = user.module("jobs.running").failure()
    sentence = "" if failure is None else failure.sentence
    user.check(f"{what}: what is said is a sentence", not any(word in sentence for word in _LONG_WORDS), sentence)
    return sentence


def _drawable(user: User, what: str) -> None:
    """Each panel of the tab can be drawn, and each of its buttons asked whether it is grey."""
    try:
        with user.hands.at("UI"):
            buttons, _ = shown(user.module("window.panels"))
            enabled = [str(button) for button in buttons if button.is_enabled()]
    except Exception as error:
        user.check(f"{what}: the tab can be drawn", False, repr(error))
        return
    user.check(f"{what}: the tab can be drawn", True, len(enabled))


def _no_photos(user: User) -> Waits:
    """All photos are removed from the list, or unticked."""
    yield from user.new_file()
    with user.hands.at():
        bpy.ops.origami.add_photos(directory=f"{user.folder / 'two_sheets'}/", preset="sheet", new=True)
        _push("Document Photos")
    for photo in user.group().photos:
        photo.use = False
    said = _press(user, "rectify")
    failure = yield from _ended(user, "no photo is ticked")
    user.check("  and says so", "ticked" in said + failure, said + failure)
    while user.group().photos:
        with user.hands.at():
            bpy.ops.origami.remove_photo()
    said = _press(user, "rectify")
    failure = yield from _ended(user, "no photo is left")
    user.check("  and says so", "add some" in said + failure, said + failure)
    _drawable(user, "no photo is left")
    yield from user.hands.sidebar_picture("no_photo_left")


def _same_photos_twice(user: User) -> Waits:
    """The same folder again in one document, and by another path."""
    yield from user.new_file()
    folder = user.folder / "two_sheets"
    other = user.folder / "another_way"
    if not other.exists():
        other.symlink_to(folder, target_is_directory=True)
    with user.hands.at():
        bpy.ops.origami.add_photos(directory=f"{folder}/", preset="sheet", new=True)
        count = len(user.group().photos)
        for again in (f"{folder}/", f"{folder}/../two_sheets/", f"{other}/"):
            bpy.ops.origami.add_photos(directory=again, preset="sheet")
            there = len(user.group().photos)
            user.check(f"the same photos again are no more photos: {Path(again).name}", there == count, there)
        _push("Document Photos")
    _press(user, "run_stage", stage="place")
    failure = yield from _ended(user, "the same photos again")
    user.check("  and they are placed", user.done() == ["place"], failure)


def _other_units(user: User, path: Path) -> Waits:
    """A scene in feet: the page's true size is the same."""
    sizes = {}
    for what, system in (("metres", "METRIC"), ("feet", "IMPERIAL")):
        yield from user.open(path)
        bpy.context.scene.unit_settings.system = system
        user.group().settings.page.paper = "A4"
        _push("Paper")
        said = _press(user, "rectify")
        failure = yield from _ended(user, f"in {what}")
        user.check("  all is done", user.done() == list(STAGES), said or failure)
        sizes[what] = [round(value, 4) for value in user.document().object("page").dimensions[:2]]
        user.hands.picture(f"units_{what}")
    user.check("a page has the same size in each unit", len({tuple(each) for each in sizes.values()}) == 1, sizes)


def _linked(user: User, path: Path) -> Waits:
    """A document linked from another file: nothing of it can be changed, and the tab does not offer to."""
    yield from user.new_file()
    with bpy.data.libraries.load(str(path), link=True) as (there, here):
        here.collections = [each for each in there.collections if each == "two_sheets"]
    for each in here.collections:
        bpy.context.scene.collection.children.link(each)
    _push("Link")
    yield _DRAWN_SECONDS
    linked = next(each for each in bpy.context.scene.objects if each.library is not None and each.type == "MESH")
    bpy.context.view_layer.objects.active = linked
    yield _DRAWN_SECONDS
    _drawable(user, "a linked object is active")
    user.check("a linked document is not offered", user.document() is None, user.document())
    yield from user.hands.sidebar_picture("linked_document")
    said = [_press(user, name) for name in ("rectify", "unwrap_developable", "edit_outline", "paint_ridges")]
    user.check("  and buttons do no more than refuse", not any("Traceback" in each for each in said), said)
    yield from user.hands.key("ESC")
    with user.hands.at():
        bpy.context.view_layer.objects.active = None
        bpy.ops.origami.add_photos(directory=f"{user.folder / 'two_sheets'}/", preset="sheet", new=True)
        _push("Document Photos")
    _press(user, "run_stage", stage="place")
    failure = yield from _ended(user, "a document of the same name beside a linked one")
    user.check("  is placed", user.done() == ["place"], failure)


def _pressed_twice(user: User, path: Path) -> Waits:
    """Each enabled button that starts a job, twice at once: one job runs."""
    for name, properties in (
        ("rectify", {}),
        ("run_stage", {"stage": "unwrap"}),
        ("turn_page", {"clockwise": True}),
        ("compare_methods", {}),
        ("rectify_all", {}),
    ):
        yield from user.open(path)
        user.group().settings.surface.smoothness = 1.5
        _press(user, name, **properties)
        yield 0.1
        said = _press(user, name, **properties)
        yield 0.3
        jobs = [each for each in user.modal() if each.startswith("ORIGAMI")]
        user.check(f"{name} twice runs once", len(jobs) <= 1, [jobs, said])
        yield from user.hands.over()
        yield from user.hands.key("ESC")
        yield 2.0
        user.check("  and one ESC ends it", user.running() is None and user.modal() == [], user.modal())


def _undone_after_each(user: User, path: Path) -> Waits:
    """Ctrl-Z and the stage again, at each stage from the surface on."""
    yield from user.open(path)
    user.group().settings.surface.smoothness = 1.1
    _push("Smoothness")
    for stage in STAGES[2:]:
        steps = 2 if stage == "unwrap" else 1  # it lays out the page too, and each stage has a step of its own
        before = user.done()
        _press(user, "run_stage", stage=stage)
        yield from _ended(user, stage)
        after, digest = user.done(), user.state_digest()
        yield from user.hands.over()
        for _ in range(steps):
            yield from user.hands.key("Z", "ctrl")
            yield 1.0
        user.check(f"Ctrl-Z takes {stage} back", user.done() == before, user.done())
        for _ in range(steps):
            yield from user.hands.key("Z", "ctrl", "shift")
            yield 1.0
        user.check("  and Ctrl-Shift-Z brings it back", user.state_digest() == digest and user.done() == after)
    user.check("all stages are done", user.done() == list(STAGES), user.done())


def _named(user: User, path: Path) -> Waits:
    """The user gives the document's collection any name; it runs, is exported, and is saved and opened."""
    for number, name in enumerate(_NAMES):
        yield from user.open(path)
        user.document().collection.name = name
        _push("Rename")
        user.group().settings.surface.smoothness = 1.2
        said = _press(user, "rectify")
        failure = yield from _ended(user, f"named {name[:20]}")
        user.check("  all is done", user.done() == list(STAGES), said or failure)
        out = user.folder / f"named_{number}" / "out"
        out.mkdir(parents=True)
        _press(user, "write_files", directory=str(out), kinds={"jpeg", "gltf", "obj"})
        failure = yield from _ended(user, "  exported")
        files = sorted(each.name for each in out.iterdir())
        beside = [each.name for each in out.parent.iterdir()]
        user.check("  into its folder alone", len(files) >= 3 and beside == ["out"], [files, beside, failure])
        if number == _NAMES.index("x" * 200):
            yield from user.hands.show_tab("Origami")
            yield from user.hands.sidebar_picture("long_name")


def _photos_moved(user: User, path: Path) -> Waits:
    """The folder of the photos is renamed between two stages, and Find Photos finds them."""
    yield from user.open(path)
    yield from user.hands.show_tab("Origami")
    folder, moved = user.folder / "two_sheets", user.folder / "moved"
    for stage, change in (("place", "sfm"), ("surface", "surface"), ("page", "page")):
        settings = user.group().settings
        if change == "sfm":
            settings.sfm.seed = 3
        elif change == "surface":
            settings.surface.smoothness = 1.3
        folder.rename(moved)
        try:
            said = _press(user, "run_stage", stage=stage)
            failure = yield from _ended(user, f"photos moved before {stage}")
            user.check("  it says so or goes on", stage in user.done() or said or failure, said or failure)
            yield from user.hands.sidebar_picture(f"photos_moved_{stage}")
            with user.hands.at():
                bpy.ops.origami.find_photos(directory=f"{moved}/")
                _push("Find Photos")
            _press(user, "rectify")
            failure = yield from _ended(user, f"  found before {stage}")
            user.check("  and then all is done", user.done() == list(STAGES), failure)
        finally:
            moved.rename(folder)
        with user.hands.at():
            bpy.ops.origami.find_photos(directory=f"{folder}/")
            _push("Find Photos")


def _saved_elsewhere(user: User, path: Path) -> Waits:
    """Saved as another file in another folder, with and without relative paths, then opened from a third one."""
    for relative in (True, False):
        yield from user.open(path)
        there = user.folder / "another" / f"folder {relative}"
        there.mkdir(parents=True)
        saved = there / "saved.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(saved), relative_remap=relative)
        third = user.folder / f"third_{relative}"
        third.mkdir()
        shutil.move(saved, third / "moved.blend")
        yield from user.open(third / "moved.blend")
        user.check("opened from a third folder, all is there", user.done() == list(STAGES), user.done())
        user.check("  and nothing counts as edited", not user.module("scene.edits").edits(user.document()))
        user.group().settings.surface.smoothness = 1.4
        said = _press(user, "rectify")
        failure = yield from _ended(user, "opened from a third folder")
        user.check("  and it runs", user.done() == list(STAGES), said or failure)
