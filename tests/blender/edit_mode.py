"""A run starts and ends while something is in Edit Mode or being moved: the user's edits stay."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bmesh
import bpy

from .hands import Waits
from .user import STAGES, User

_PAUSE_SECONDS = 0.4
_PATIENCE_SECONDS = 120.0
_CUBE = "Cube"
_UNDO_STEPS = 18  # two for each of four stages, those of the edit of the mesh, and some more


def scene(user: User) -> Waits:
    """Cancelled before and after results, with each kind of edit; kept; undone; and results that arrive meanwhile."""
    path = yield from user.two_sheets("page")
    for what, edit in _EDITS.items():
        for results in (False, True):
            yield from _given_up(user, path, what, edit, results)
    yield from _stopped(user, path)
    yield from _nothing_to_do(user, path)
    yield from _edited_meanwhile(user, path)
    for role in ("outline", "sheet"):
        yield from _moved_meanwhile(user, path, role)


def _push(message: str) -> None:
    bpy.ops.ed.undo_push(message=message)


def _enter(chosen: Any, mode: str = "EDIT") -> None:
    """As a user does it: select, make active, change the mode."""
    for each in bpy.context.view_layer.objects:
        each.select_set(each == chosen)
    bpy.context.view_layer.objects.active = chosen
    _push("Select")
    bpy.ops.object.mode_set(mode=mode)
    _push("Mode")


def _outline(user: User) -> None:
    """Points of the edge are moved, twice; between, a setting is changed."""
    with user.hands.at():
        bpy.ops.origami.edit_outline()
        _push("Edit Outline")
        bpy.ops.curve.select_all(action="SELECT")
        _push("Select All")
        bpy.ops.transform.resize(value=(0.97, 0.97, 0.97))
        _push("Resize")
        user.group().settings.surface.smoothness = 1.25
        _push("Smoothness")
        bpy.ops.transform.resize(value=(0.98, 0.98, 0.98))
        _push("Resize")


def _ridge(user: User) -> None:
    """Vertices of the sheet are put into the group of creases in Edit Mode."""
    sheet = user.document().object("sheet")
    with user.hands.at():
        _enter(sheet)
        bpy.ops.mesh.select_all(action="DESELECT")
        mesh = bmesh.from_edit_mesh(sheet.data)
        mesh.verts.ensure_lookup_table()
        low, high = (f([vertex.co.x for vertex in mesh.verts]) for f in (min, max))
        for vertex in mesh.verts:
            vertex.select_set(abs(vertex.co.x - (low + high) / 2) < 0.05 * (high - low))
        mesh.select_flush(True)
        bmesh.update_edit_mesh(sheet.data)
        _push("Select")
        sheet.vertex_groups.active = sheet.vertex_groups["ridge"]
        bpy.ops.object.vertex_group_assign()
        _push("Assign")
        user.group().settings.flatten.method = "lscm"
        _push("Method")


def _cube(user: User) -> None:
    """The user's own mesh, with an edit before and after a setting of the document is changed."""
    with user.hands.at():
        _enter(bpy.data.objects[_CUBE])
        bpy.ops.mesh.select_all(action="SELECT")
        _push("Select All")
        bpy.ops.transform.translate(value=(3, 0, 0))
        _push("Move")
        user.group().settings.surface.smoothness = 1.25
        _push("Smoothness")
        bpy.ops.transform.translate(value=(0, 2, 0))
        _push("Move")


def _painted(user: User) -> None:
    """The document's sheet in Weight Paint."""
    sheet = user.document().object("sheet")
    with user.hands.at():
        bpy.ops.origami.paint_ridges()
        _push("Paint Ridges")
        sheet.vertex_groups["ridge"].add(list(range(40)), 1.0, "REPLACE")
        sheet.data.update()
        _push("Weight Paint")
        user.group().settings.surface.smoothness = 1.25
        _push("Smoothness")


_EDITS: dict[str, Callable[[User], None]] = {
    "the outline": _outline,
    "the ridges": _ridge,
    "a mesh of the user's": _cube,
    "painted ridges": _painted,
}


def _seen(user: User) -> dict[str, Any]:
    """Everything that must be as before."""
    active = bpy.context.view_layer.objects.active
    if active.mode == "EDIT":
        active.update_from_editmode()
    document = user.document()
    outline, sheet = document.object("outline"), document.object("sheet")
    scene = bpy.context.scene
    return {
        "mode": (active.name, active.mode),
        "document": user.state_digest(),
        "settings": user.settings(),
        "outline": [tuple(round(v, 5) for v in point.co) for point in outline.data.splines[0].points],
        "sheet": [tuple(round(v, 5) for v in vertex.co) for vertex in sheet.data.vertices],
        "ridges": user.module("scene.mesh_values").members(sheet, "ridge").tolist(),
        "cube": [tuple(round(v, 5) for v in vertex.co) for vertex in bpy.data.objects[_CUBE].data.vertices],
        "objects": sorted(each.name for each in scene.objects),
        "scene": (scene.camera and scene.camera.name, scene.render.resolution_x, scene.view_settings.view_transform),
    }


def _same(user: User, what: str, before: dict[str, Any]) -> None:
    after = _seen(user)
    other = [name for name in before if before[name] != after[name]]
    details = {name: (before[name], after[name]) for name in other if len(str(before[name])) < 200}
    user.check(what, not other, f"{other} {details}" if other else "")


def _run(user: User) -> None:
    with user.hands.at():
        bpy.ops.origami.rectify("INVOKE_DEFAULT")


def _wait_for_result(user: User) -> Waits:
    """Wait until the first stage of the run is in the scene and a later one is running."""
    count, until = len(user.done()), time.monotonic() + _PATIENCE_SECONDS
    while len(user.done()) == count:
        assert user.running() is not None, "the run ended before a result came"
        assert time.monotonic() < until
        yield 0.02
    yield 0.1


def _given_up(user: User, path: Path, what: str, edit: Callable[[User], None], results: bool) -> Waits:
    when = "after a result" if results else "before any result"
    yield from user.open(path)
    edit(user)
    yield _PAUSE_SECONDS
    before = _seen(user)
    _run(user)
    yield 0.2
    user.check(f"{what} edited: the run begins", user.running() is not None)
    if results:
        yield from _wait_for_result(user)
    yield from user.hands.key("ESC")
    yield 2.0
    user.check("  ESC ends it", user.running() is None and user.modal() == [], user.modal())
    _same(user, f"{what} edited, given up {when}: all is as before", before)
    _run(user)
    yield 0.5
    user.check("  and another run takes the edit", user.running() is not None)
    yield from user.hands.key("ESC")
    yield 2.0
    _same(user, "  and can be given up, too", before)
    if before["mode"][1] == "EDIT" and what != "the ridges":
        with user.hands.at():
            bpy.ops.transform.resize(value=(0.9, 0.9, 0.9))
            _push("Resize")
        yield 0.3
        yield from user.hands.key("Z", "ctrl")
        yield 1.0
        _same(user, "  and one more edit is undone by one Ctrl-Z", before)


def _stopped(user: User, path: Path) -> Waits:
    yield from user.open(path)
    _cube(user)
    before = _seen(user)
    _run(user)
    yield 0.2
    yield from _wait_for_result(user)
    user.running().wish = "stop"
    yield 2.0
    after = _seen(user)
    user.check("Stop keeps the user's mesh", (before["cube"], before["mode"]) == (after["cube"], after["mode"]))
    user.check("  and what was finished", 0 < len(user.done()) < len(STAGES), user.done())
    for _ in range(10):
        if user.done() == list(STAGES):
            break
        yield from user.hands.key("Z", "ctrl")
        yield 1.0
    _same(user, "  which Ctrl-Z takes back", before)


def _nothing_to_do(user: User, path: Path) -> Waits:
    yield from user.open(path)
    with user.hands.at():
        bpy.ops.origami.edit_outline()
        _push("Edit Outline")
    before = _seen(user)
    _run(user)
    yield _PAUSE_SECONDS
    user.check("where all is up to date nothing runs", user.running() is None)
    _same(user, "  and the user stays in Edit Mode", before)


def _edited_meanwhile(user: User, path: Path) -> Waits:
    """The user works on another mesh while results arrive."""
    yield from user.open(path)
    whole = _seen(user)
    user.group().settings.surface.smoothness = 1.25
    _push("Smoothness")
    _run(user)
    yield 0.2
    _cube(user)
    before = _seen(user)
    yield from user.wait_for_end()
    after = _seen(user)
    user.check("a run ends beside a mesh in Edit Mode", user.done() == list(STAGES), user.done())
    user.check("  which stays so", (before["cube"], before["mode"]) == (after["cube"], after["mode"]), after["mode"])
    path = user.folder / "saved_in_edit_mode.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    counts = [len(user.done())]
    for _ in range(_UNDO_STEPS):
        yield from user.hands.key("Z", "ctrl")
        yield 0.7
        if len(user.done()) != counts[-1]:
            counts.append(len(user.done()))
    user.check("  Ctrl-Z takes back the stages one by one", counts == [6, 5, 4, 3, 6], counts)
    again = _seen(user)
    user.check("  the edits of the mesh go by steps of their own", again["cube"] in (before["cube"], whole["cube"]))


def _moved_meanwhile(user: User, path: Path, role: str) -> Waits:
    """Results arrive while the mouse moves an object of the document."""
    yield from user.open(path)
    chosen = user.document().object(role)
    for each in bpy.context.view_layer.objects:
        each.select_set(each == chosen)
    bpy.context.view_layer.objects.active = chosen
    with user.hands.at():
        bpy.ops.object.mode_set(mode="EDIT")
        _push("Edit Mode")
        bpy.ops.mesh.select_all(action="SELECT") if role == "sheet" else bpy.ops.curve.select_all(action="SELECT")
        bpy.ops.transform.resize(value=(0.99, 0.99, 0.99))
        bpy.ops.object.mode_set(mode="OBJECT")
        _push("Object Mode")
    user.group().settings.surface.smoothness = 1.25
    _run(user)
    yield 0.2
    yield from user.hands.over()
    with user.hands.at():
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.transform.translate("INVOKE_DEFAULT")
    x, y = user.hands.mouse
    for step in range(60):
        yield from user.hands.move(x + 3 * (step % 20), y)
        yield 0.2
        if user.running() is None:
            break
    yield from user.hands.key("LEFTMOUSE")
    yield 1.0
    yield from user.wait_for_end()
    user.check(f"results that come while {role} is moved do no harm", user.running() is None, user.done())
