"""What a user does elsewhere during a run: other scenes, other documents, Undo, saving, deleting."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy

from .hands import Waits
from .user import STAGES, User

_DRAWN_SECONDS = 2.0  # until the window shows what a script has done
_FORMAT = ("resolution_x", "resolution_y", "resolution_percentage")


def scene(user: User) -> Waits:
    """Each part starts with the same finished document."""
    path = yield from user.two_sheets("page")
    yield from _another_scene(user, path)
    yield from _copied_scene(user, path)
    for what, change in _CHANGES.items():
        yield from _changed(user, path, what, change)
    yield from _undone(user, path)
    yield from _saved(user, path)
    yield from _second_document(user, path)
    yield from _compared(user, path)
    yield from _exported(user, path)


def _push(message: str) -> None:
    bpy.ops.ed.undo_push(message=message)


def _run(user: User, all_stages: bool = True) -> Waits:
    """Start a run: of all stages after placing the photos, or from the surface."""
    settings = user.group().settings
    if all_stages:
        settings.sheet = 2
    else:
        settings.surface.smoothness += 0.1
    _push("Setting")
    with user.hands.at():
        bpy.ops.origami.rectify("INVOKE_DEFAULT")
    yield 0.3
    user.check("the run starts", user.running() is not None)


def _look(scene: Any) -> list[object]:
    """The settings that a document changes in its scene."""
    camera = None if scene.camera is None else scene.camera.name
    return [
        camera,
        *(getattr(scene.render, name) for name in _FORMAT),
        scene.view_settings.view_transform,
        scene.unit_settings.length_unit,
    ]


def _another_scene(user: User, path: Path) -> Waits:
    """The window shows another scene while all results arrive."""
    yield from user.open(path)
    own = bpy.context.scene.name
    bpy.data.objects.remove(bpy.data.objects["Camera"])
    user.group().settings.sfm.seed = 5
    name = user.document().name
    yield from _run(user)
    with user.hands.at():
        bpy.ops.scene.new(type="EMPTY")
        _push("New Scene")
    other, before = bpy.context.scene.name, _look(bpy.context.scene)
    yield from user.wait_for_end()
    after = _look(bpy.data.scenes[other])
    user.check("another scene is as it was", after == before, [before, after])
    failure = user.module("jobs.running").failure()
    user.check("  and the run ends well", failure is None, failure)
    user.hands.window.scene = bpy.data.scenes[own]
    yield 1.0
    document = user.module("scene.document").find_document(name)
    done = [stage for stage in STAGES if getattr(document.collection.origami, stage).done]
    user.check("  in the scene of the document", done == list(STAGES), done)
    look = _look(bpy.context.scene)
    user.check("  without a camera, as the user left it", look[0] is None, look)
    hidden = [each.hide_get() for each in document.objects("points")]
    user.check("  where the points are hidden", hidden == [True], hidden)
    user.check("  and nothing counts as edited", not user.module("scene.edits").edits(document))


def _copied_scene(user: User, path: Path) -> Waits:
    """A full copy of the scene has its own document, which is rectified at once."""
    yield from user.open(path)
    yield from user.hands.show_tab("Origami")
    first, before = user.document().name, user.state_digest()
    own = bpy.context.scene.name
    with user.hands.at():
        bpy.ops.scene.new(type="FULL_COPY")
        _push("New Scene")
    yield _DRAWN_SECONDS
    user.check("a copied scene has a document of its own", user.document().name != first, user.document().name)
    yield from _run(user, all_stages=False)
    yield from user.wait_for_end()
    user.check("  whose run is its own", user.document().name != first and user.done() == list(STAGES))
    user.hands.window.scene = bpy.data.scenes[own]
    yield 1.0
    user.check("  and the first document is as it was", user.document().name == first and user.state_digest() == before)


def _exclude(user: User) -> None:
    collection = user.document().collection.name
    bpy.context.view_layer.layer_collection.children[collection].exclude = True


def _hide(user: User) -> None:
    user.document().collection.hide_viewport = True


def _unparent(user: User) -> None:
    outline = user.document().object("outline")
    matrix = outline.matrix_world.copy()
    outline.parent = None
    outline.matrix_world = matrix


def _delete_outline(user: User) -> None:
    bpy.data.objects.remove(user.document().object("outline"))


def _delete_sheet(user: User) -> None:
    bpy.data.objects.remove(user.document().object("sheet"))


def _delete_cameras(user: User) -> None:
    for each in user.document().objects("camera"):
        bpy.data.objects.remove(each)


def _delete_all(user: User) -> None:
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()


def _purge(user: User) -> None:
    for kind in (bpy.data.images, bpy.data.materials):
        for each in list(kind):
            kind.remove(each)


def _link_elsewhere(user: User) -> None:
    """The user moves the document's objects into another collection."""
    mine = bpy.data.collections.new("mine")
    bpy.context.scene.collection.children.link(mine)
    for each in list(user.document().collection.objects):
        mine.objects.link(each)
        user.document().collection.objects.unlink(each)


def _delete_scene(user: User) -> None:
    other = bpy.data.scenes.new("other")
    mine = bpy.context.scene
    user.hands.window.scene = other
    bpy.data.scenes.remove(mine)


def _rename(user: User) -> None:
    user.document().collection.name = "renamed"
    for each in user.document().collection.objects:
        each.name = "x"


def _clear_materials(user: User) -> None:
    user.document().object("sheet").data.materials.clear()
    for layer in list(user.document().object("sheet").data.uv_layers):
        user.document().object("sheet").data.uv_layers.remove(layer)


_CHANGES: dict[str, Callable[[User], None]] = {
    "its collection is excluded": _exclude,
    "its collection is hidden": _hide,
    "its outline is unparented": _unparent,
    "its outline is deleted": _delete_outline,
    "its sheet is deleted": _delete_sheet,
    "its cameras are deleted": _delete_cameras,
    "all objects are deleted": _delete_all,
    "the document is deleted": User.delete_document,
    "pictures and materials are removed": _purge,
    "its objects are sorted elsewhere": _link_elsewhere,
    "its scene is deleted": _delete_scene,
    "all is renamed": _rename,
    "the sheet's materials and UV maps are removed": _clear_materials,
}


# These only affect a run that does not find the sheet again.
_FROM_SURFACE = {_unparent, _delete_outline, _delete_sheet, _purge, _clear_materials}


def _changed(user: User, path: Path, what: str, change: Callable[[User], None]) -> Waits:
    """Just after the start of a run: it succeeds, or says why not, and Blender survives."""
    yield from user.open(path)
    yield from _run(user, all_stages=change not in _FROM_SURFACE)
    with user.hands.at():
        change(user)
        _push(what)
    yield from user.wait_for_end()
    failure = user.module("jobs.running").failure()
    sentence = "" if failure is None else failure.sentence
    user.check(f"{what}: the run ends", user.modal() == [], sentence)
    user.check("  and a failure is a sentence", "Error" not in sentence and "report it" not in sentence, sentence)
    yield from user.hands.over()
    for _ in range(3):
        yield from user.hands.key("Z", "ctrl")
        yield 0.7
    document = user.document()
    if document is not None and failure is None:
        nouns = ("model", "region", "sheet", "uv", "flat")
        known = [noun for noun in nouns if hasattr(document.state, noun)]
        count = len([stage for stage in user.done() if stage != "page"])
        user.check("  Undo leaves what was known", len(known) == count, user.done())


def _undone(user: User, path: Path) -> Waits:
    """Ctrl-Z again and again while results arrive."""
    yield from user.open(path)
    yield from _run(user)
    for _ in range(12):
        yield from user.hands.key("Z", "ctrl")
        yield 0.5
    yield from user.wait_for_end()
    failure = user.module("jobs.running").failure()
    user.check("Undo while results come ends the run at most", user.modal() == [], failure)
    if user.document() is not None:
        user.check("  and leaves a document", user.done() == list(STAGES[: len(user.done())]), user.done())


def _saved(user: User, path: Path) -> Waits:
    """Saved during a run, reopened, and continued."""
    yield from user.open(path)
    yield from _run(user)
    count = len(user.done())
    while user.running() is not None and len(user.done()) == count:
        yield 0.02
    saved = user.folder / "saved_while_running.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(saved))
    user.check("saved while it runs", user.running() is not None)
    yield 0.5
    yield from user.open(saved)
    user.check("opened, nothing runs", user.running() is None and user.modal() == [])
    kept = user.done()
    user.check("  the stages are those in order", kept == list(STAGES[: len(kept)]), kept)
    with user.hands.at():
        bpy.ops.origami.rectify("INVOKE_DEFAULT")
    yield 0.3
    yield from user.wait_for_end()
    user.check("  and it goes on to the end", user.done() == list(STAGES), user.module("jobs.running").failure())


def _second_document(user: User, path: Path) -> Waits:
    yield from user.open(path)
    first = user.document()
    name = first.name
    yield from _run(user)
    with user.hands.at():
        bpy.context.view_layer.objects.active = None
        bpy.ops.origami.add_photos(directory=f"{user.folder / 'two_sheets'}/", preset="sheet", new=True)
        _push("Document Photos")
    second = user.document()
    user.check("a second document is begun while the first one is running", second.name != name, second.name)
    yield from user.wait_for_end()
    first = user.module("scene.document").find_document(name).collection.origami
    user.check("the first one's results are its own", all(getattr(first, stage).done for stage in STAGES))
    user.check("  the second has none", user.done() == [], user.done())
    with user.hands.at():
        bpy.ops.origami.rectify("INVOKE_DEFAULT")
    yield 0.3
    yield from user.wait_for_end()
    user.check("the second is rectified beside it", user.done() == list(STAGES), user.done())
    again = user.module("scene.document").find_document(name).collection.origami
    user.check("  the first stays", all(getattr(again, stage).done for stage in STAGES))
    user.hands.picture("two_documents")


def _compared(user: User, path: Path) -> Waits:
    yield from user.open(path)
    sheet = user.document().object("sheet")
    before = [layer.name for layer in sheet.data.uv_layers]
    with user.hands.at():
        bpy.ops.origami.compare_methods("INVOKE_DEFAULT")
    until = len(before)
    while user.running() is not None and len(user.document().object("sheet").data.uv_layers) == until:
        yield 0.02
    yield from user.hands.key("ESC")
    yield 2.0
    after = [layer.name for layer in user.document().object("sheet").data.uv_layers]
    user.check("Compare Methods given up leaves no UV map", after == before, after)
    with user.hands.at():
        bpy.ops.origami.compare_methods("INVOKE_DEFAULT")
    yield from user.wait_for_end()
    after = [layer.name for layer in user.document().object("sheet").data.uv_layers]
    user.check("  and finished one of each", len(after) > len(before) + 1, after)
    for _ in range(len(after) - len(before)):
        yield from user.hands.key("Z", "ctrl")
        yield 0.7
    after = [layer.name for layer in user.document().object("sheet").data.uv_layers]
    user.check("  which Ctrl-Z takes back", after == before, after)


def _exported(user: User, path: Path) -> Waits:
    """Cancelled while writing, then written; Edit Mode and settings stay as they are."""
    yield from user.open(path)
    out = user.folder / "exported_elsewhere"
    out.mkdir(exist_ok=True)
    (out / "mine.txt").write_text("mine")
    with user.hands.at():
        bpy.ops.origami.edit_outline()
        _push("Edit Outline")
    for given_up in (True, False):
        before = user.settings(), user.state_digest()
        with user.hands.at():
            bpy.ops.origami.write_files("INVOKE_DEFAULT", directory=str(out), kinds={"tiff", "jpeg"})
        yield 0.3
        user.check("an export begins", user.running() is not None, user.module("jobs.running").failure())
        if given_up:
            yield from user.wait_for_text("Looking at the page", "Laying", "Blending", "light off", "Writing")
            yield from user.hands.key("ESC")
            yield 2.0
        else:
            yield from user.wait_for_end()
        names = sorted(each.name for each in out.iterdir() if not each.name.startswith("."))
        after = user.settings(), user.state_digest()
        user.check("  the document is as it was", after == before)
        whole = ["mine.txt"] if given_up else ["mine.txt", "page.jpg", "page.tif"]
        user.check("  the folder has whole files alone", names == whole, names)
    user.check("  the user is in the mode as before", bpy.context.mode == "EDIT_CURVE", bpy.context.mode)
