"""What the random user does to the file itself: deletes, copies, renames, moves, other scenes, saving, opening."""

from __future__ import annotations

from typing import Any

import bpy

from .hands import Waits
from .random_user import Monkey

ELSEWHERE = "elsewhere.blend"  # a copy of the file at the start, to append from
_WORKSPACES = ("Layout", "UV Editing", "Sculpting")


def _push(message: str) -> None:
    bpy.ops.ed.undo_push(message=message)


def _any_object(monkey: Monkey) -> Any:
    there = list(bpy.context.scene.objects)
    return monkey.random.choice(there) if there else None


def _any_collection(monkey: Monkey) -> Any:
    there = list(bpy.data.collections)
    return monkey.random.choice(there) if there else None


def _object_mode(monkey: Monkey) -> None:
    """The outliner, in which a user deletes, ends the mode of what it takes away."""
    if bpy.context.mode != "OBJECT":
        with monkey.user.hands.at():
            bpy.ops.object.mode_set(mode="OBJECT")


def _delete_object(monkey: Monkey) -> Waits:
    _object_mode(monkey)
    chosen = _any_object(monkey)
    if chosen is not None:
        monkey.say(f"delete {chosen.name}")
        bpy.data.objects.remove(chosen)
        _push("Delete")
    yield 0.1


def _delete_collection(monkey: Monkey) -> Waits:
    _object_mode(monkey)
    chosen = _any_collection(monkey)
    if chosen is not None:
        monkey.say(f"delete the collection {chosen.name}")
        bpy.data.collections.remove(chosen)
        _push("Delete Collection")
    yield 0.1


def _purge(monkey: Monkey) -> Waits:
    _object_mode(monkey)
    monkey.say("purge")
    bpy.ops.outliner.orphans_purge()
    yield 0.1


def _rename(monkey: Monkey) -> Waits:
    chosen = monkey.random.choice((_any_object, _any_collection))(monkey)
    if chosen is not None:
        monkey.say(f"rename {chosen.name}")
        chosen.name = monkey.random.choice(("x", "Brief ü", "two_sheets", "a" * 60))
        _push("Rename")
    yield 0.05


def _move(monkey: Monkey) -> Waits:
    chosen = _any_object(monkey)
    if chosen is not None and chosen.mode == "OBJECT":
        monkey.say(f"move {chosen.name}")
        chosen.location.x += monkey.random.uniform(-0.5, 0.5)
        if monkey.random.random() < 0.3:
            chosen.scale = [monkey.random.choice((0.0, 1.0, -2.0))] * 3
        _push("Move")
    yield 0.05


def _edit_mesh(monkey: Monkey) -> Waits:
    """Move or delete some vertices of a mesh."""
    _object_mode(monkey)
    chosen = _any_object(monkey)
    if chosen is None or chosen.type not in ("MESH", "CURVE") or chosen.name not in bpy.context.view_layer.objects:
        return
    monkey.say(f"edit {chosen.name}")
    bpy.context.view_layer.objects.active = chosen
    with monkey.user.hands.at():
        try:
            bpy.ops.object.mode_set("INVOKE_DEFAULT", True, mode="EDIT")
            kind = bpy.ops.mesh if chosen.type == "MESH" else bpy.ops.curve
            if chosen.type == "MESH":
                bpy.ops.mesh.select_all(action="DESELECT")
                bpy.ops.mesh.select_random(ratio=0.1, seed=monkey.random.randint(0, 99))
            else:
                bpy.ops.curve.select_random(ratio=0.3, seed=monkey.random.randint(0, 99))
            if monkey.random.random() < 0.5:
                bpy.ops.transform.translate("EXEC_DEFAULT", True, value=(0.01, 0, 0.01))
            else:
                kind.delete("EXEC_DEFAULT", True, type="VERT")
            if monkey.random.random() < 0.7:
                bpy.ops.object.mode_set("INVOKE_DEFAULT", True, mode="OBJECT")
        except RuntimeError as error:  # a hidden object has no Edit Mode
            monkey.say(error)
    yield 0.1


def _convert(monkey: Monkey) -> Waits:
    """Make something else of an object: a curve of a mesh, a mesh of a curve."""
    _object_mode(monkey)
    chosen = _any_object(monkey)
    if chosen is None or chosen.type not in ("MESH", "CURVE") or not chosen.visible_get():
        return
    monkey.say(f"convert {chosen.name}")
    with monkey.user.hands.at():
        bpy.ops.object.select_all(action="DESELECT")
        chosen.select_set(True)
        bpy.context.view_layer.objects.active = chosen
        bpy.ops.object.convert("EXEC_DEFAULT", True, target="CURVE" if chosen.type == "MESH" else "MESH")
    yield 0.1


def _duplicate(monkey: Monkey) -> Waits:
    """Copy a document's collection, as the outliner does, or everything that is selected."""
    _object_mode(monkey)
    chosen = _any_collection(monkey)
    if chosen is None or monkey.random.random() < 0.5:
        monkey.say("duplicate what is selected")
        with monkey.user.hands.at():
            if bpy.ops.object.duplicate.poll():
                bpy.ops.object.duplicate("EXEC_DEFAULT", True)
        yield 0.1
        return
    monkey.say(f"duplicate the collection {chosen.name}")
    copy = chosen.copy()
    for each in list(copy.objects):
        copy.objects.link(each.copy())
        copy.objects.unlink(each)
    bpy.context.scene.collection.children.link(copy)
    _push("Duplicate")
    yield 0.3


def _hide_collection(monkey: Monkey) -> Waits:
    children = bpy.context.view_layer.layer_collection.children
    if children:
        chosen = monkey.random.choice(list(children))
        monkey.say(f"hide or exclude {chosen.name}")
        if monkey.random.random() < 0.5:
            chosen.exclude = not chosen.exclude
        else:
            chosen.hide_viewport = not chosen.hide_viewport
        _push("Hide")
    yield 0.1


def _scene(monkey: Monkey) -> Waits:
    """A new scene, a copied one, or one of the others; or this one is deleted."""
    _object_mode(monkey)
    what = monkey.random.choice(("EMPTY", "FULL_COPY", "LINK_COPY", "other", "other", "delete"))
    monkey.say(f"scene {what}")
    with monkey.user.hands.at():
        if what == "delete":
            if bpy.ops.scene.delete.poll():
                bpy.ops.scene.delete("EXEC_DEFAULT", True)
        elif what != "other" and len(bpy.data.scenes) < 4:
            bpy.ops.scene.new("EXEC_DEFAULT", True, type=what)
        else:
            monkey.user.hands.window.scene = monkey.random.choice(list(bpy.data.scenes))
    yield 0.5


def _workspace(monkey: Monkey) -> Waits:
    name = monkey.random.choice(_WORKSPACES)
    monkey.say(f"workspace {name}")
    if name in bpy.data.workspaces:
        monkey.user.hands.window.workspace = bpy.data.workspaces[name]
        yield 1.0
    if not any(area.type == "VIEW_3D" for area in monkey.user.hands.window.screen.areas):
        monkey.user.hands.window.workspace = bpy.data.workspaces["Layout"]
        yield 1.0


def _save(monkey: Monkey) -> Waits:
    monkey.say("save")
    bpy.ops.wm.save_as_mainfile(filepath=str(monkey.user.folder / "monkey.blend"))
    yield 0.2


def _open(monkey: Monkey) -> Waits:
    """The file saved last, or the one at the start."""
    saved = monkey.user.folder / "monkey.blend"
    path = saved if saved.exists() and monkey.random.random() < 0.4 else monkey.home
    monkey.say(f"open {path.name}")
    yield from monkey.user.hands.open(path, seconds=1.0)
    if not any(area.type == "VIEW_3D" for area in monkey.user.hands.window.screen.areas):
        monkey.user.hands.window.workspace = bpy.data.workspaces["Layout"]
        yield 1.0


def _append(monkey: Monkey) -> Waits:
    """Append or link the documents of the file at the start."""
    _object_mode(monkey)
    link = monkey.random.random() < 0.4
    monkey.say(f"append, linked: {link}")
    with bpy.data.libraries.load(str(monkey.user.folder / ELSEWHERE), link=link) as (there, here):
        here.collections = [each for each in there.collections if each.startswith("two_sheets")][:1]
    for each in here.collections:
        bpy.context.scene.collection.children.link(each)
    _push("Append")
    yield 0.3


# Each with its weight, and whether documents may be gone afterwards.
DEEDS: dict[str, tuple[Any, ...]] = {
    "delete object": (_delete_object, 3),
    "delete collection": (_delete_collection, 1, True),
    "purge": (_purge, 0.7, True),
    "rename": (_rename, 2),
    "move": (_move, 3),
    "edit mesh": (_edit_mesh, 4),
    "convert": (_convert, 1),
    "duplicate": (_duplicate, 2),
    "hide collection": (_hide_collection, 2),
    "scene": (_scene, 2, True),
    "workspace": (_workspace, 2),
    "save": (_save, 1),
    "open": (_open, 2, True),
    "append": (_append, 1),
}
