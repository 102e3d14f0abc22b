"""Another sheet is chosen by a click, with whatever a user may do before, in between and after."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d

from . import interruptions
from .hands import Waits
from .user import User

_OPERATOR, _BUTTON = "ORIGAMI_OT_pick_sheet", "bpy.ops.origami.pick_sheet"
_PAUSE_SECONDS = 0.4
_NEAR_PIXELS = 12.0  # of the middle of a sheet, whose sides are 110 to 160 pixels long in the photos
_BESIDE = 20.0, 20.0  # in the photo's corner, where the table is
_PATCH = 60, 60  # pixels of the screen, to the right and down from there
_GRAIN = 5.0  # grey levels
Place = tuple[float, float]


def scene(user: User) -> Waits:
    """A document of two sheets; a choice, undone, cancelled, beside the sheets, twice, and without the document."""
    path = yield from user.two_sheets("find")
    yield from _taken(user, path)
    yield from _given_up(user, path)
    yield from _given_up_while_it_is_found(user, path)
    yield from _beside(user, path)
    yield from _pressed_twice(user, path)
    yield from _changed_meanwhile(user, path)
    yield from _another_file(user, path)
    yield from _deleted_before(user, path)


def _open(user: User, path: Path) -> Waits:
    """The document of two sheets, seen from above, with the step open."""
    yield from user.hands.open(path)
    yield from user.hands.show_tab("Origami")
    with user.hands.at():
        bpy.ops.view3d.view_axis(type="TOP")
    yield 1.0
    user.hands.forget_places()
    yield from user.hands.toggle("sheet")


def _middles(user: User) -> np.ndarray:
    """Where the reference photo shows the middle of each sheet, in the order of their numbers."""
    region, reference = user.document().state.region, user.document().state.reference
    middles = np.array(json.loads((user.folder / "two_sheets" / "middles.json").read_text())[reference.name])
    found = np.array([_middle(reference.project(edge)) for edge in region.in_view])
    return middles[np.linalg.norm(found[:, None] - middles, axis=2).argmin(axis=1)]


def _found(user: User) -> np.ndarray:
    """The middle of the document's outline, in pixels of the reference photo."""
    return _middle(user.document().state.region.outline.polygon)


def _drawn(user: User) -> np.ndarray:
    """The middle of the scene's curve, in pixels of its reference photo."""
    outline = user.document().object("outline")
    points = [outline.matrix_world @ point.co.to_3d() for point in outline.data.splines[0].points]
    state = user.document().state
    in_model = user.module("scene.sheet_mesh").transform(np.linalg.inv(user.document().frame), np.array(points))
    return _middle(state.model.cameras[state.region.reference].project(in_model))


def _middle(polygon: np.ndarray) -> np.ndarray:
    return (polygon.min(axis=0) + polygon.max(axis=0)) / 2


def _on_screen(user: User, place: Place) -> Place:
    """Where the view through the camera shows this pixel of its photo."""
    view, scene = user.hands.region("WINDOW"), bpy.context.scene
    camera, space = scene.camera, user.hands.area().spaces.active
    corners = [camera.matrix_world @ corner for corner in camera.data.view_frame(scene=scene)]
    shown = np.array([location_3d_to_region_2d(view, space.region_3d, corner)[:] for corner in corners])
    low, high = shown.min(axis=0), shown.max(axis=0)
    part = np.array(place) / (scene.render.resolution_x, scene.render.resolution_y)
    x, y = low + (high - low) * (part[0], 1 - part[1])
    return float(view.x + x), float(view.y + y)


def _click_on_photo(user: User, place: Place) -> Waits:
    yield from user.hands.click(*_on_screen(user, place))
    yield _PAUSE_SECONDS


def _photo_is_seen(user: User) -> bool:
    """Whether the photo's corner shows the table's grain; Blender's own cube is white, the empty view grey."""
    x, y = _on_screen(user, _BESIDE)
    pixels = user.hands.pixels((int(x), int(user.hands.window.height - y), *_PATCH))
    return bool(pixels.std(axis=(0, 1)).max() > _GRAIN)


def _begin(user: User) -> Waits:
    yield from user.hands.press(_BUTTON)
    yield _PAUSE_SECONDS
    user.check("the button waits for a click", user.modal()[-1:] == [_OPERATOR], user.modal())


def _view(user: User) -> list[object]:
    """The state that a look through a camera changes."""
    space, scene = user.hands.area().spaces.active, bpy.context.scene
    shading, render = space.shading, scene.render
    camera = None if scene.camera is None else scene.camera.name
    return [
        *(space.region_3d.view_perspective, tuple(round(value, 4) for value in space.region_3d.view_rotation)),
        *(shading.type, shading.light, shading.color_type, shading.show_xray, round(shading.xray_alpha, 4)),
        *(camera, render.resolution_x, render.resolution_y, render.resolution_percentage),
    ]


def _is_taken(user: User, what: str, number: int) -> None:
    settings, middle = user.group().settings, _middles(user)[number - 1]
    user.check(f"{what}: Sheet says {number}", settings.sheet == number, settings.sheet)
    near = [float(np.linalg.norm(each - middle)) for each in (_found(user), _drawn(user))]
    user.check("  its edge is known and drawn", max(near) < _NEAR_PIXELS, [round(each, 1) for each in near])
    user.check("  later stages are to be done", user.done() == ["place", "find"], user.done())


def _taken(user: User, path: Path) -> Waits:
    """Choose a sheet by a click, undo, redo, and choose the first one by another click."""
    yield from _open(user, path)
    before = user.state_digest()
    yield from _begin(user)
    user.hands.picture("pick_sheet")
    user.check("the photo is seen past the scene's objects", _photo_is_seen(user))
    yield from _click_on_photo(user, _middles(user)[1])
    user.check("the click begins to find it", user.modal() == ["ORIGAMI_OT_take_sheet"], user.modal())
    yield from user.wait_for_end()
    user.hands.picture("picked_sheet")
    _is_taken(user, "the other sheet is taken", 2)
    user.check("  objects are solid again", not user.hands.area().spaces.active.shading.show_xray)
    after = user.state_digest()
    user.check("no hand has edited it", not user.module("scene.edits").edits(user.document()))
    yield from user.hands.over()
    yield from user.hands.key("Z", "ctrl")
    yield 1.0
    _is_taken(user, "Ctrl-Z takes it back", 1)
    user.check("  and all is as before", user.state_digest() == before)
    yield from user.hands.key("Z", "ctrl", "shift")
    yield 1.0
    _is_taken(user, "Ctrl-Shift-Z takes it again", 2)
    user.check("  and all is as after", user.state_digest() == after)
    yield from _begin(user)
    yield from _click_on_photo(user, _middles(user)[0])
    yield from user.wait_for_end()
    _is_taken(user, "another click takes the first one", 1)
    for _ in range(2):
        yield from user.hands.key("Z", "ctrl")
        yield 1.0
    _is_taken(user, "two Ctrl-Z are back at the beginning", 1)
    user.check("  and all is as before", user.state_digest() == before)


def _given_up(user: User, path: Path) -> Waits:
    """Cancel with either key, before and after a click that hit nothing."""
    yield from _open(user, path)
    before, view = user.state_digest(), _view(user)
    for key in ("ESC", "RIGHTMOUSE"):
        for clicks in (0, 1):
            yield from _begin(user)
            user.check("the photo is looked at", user.hands.area().spaces.active.region_3d.view_perspective == "CAMERA")
            for _ in range(clicks):
                yield from _click_on_photo(user, _BESIDE)
            yield from user.hands.over()
            yield from user.hands.key(key)
            yield _PAUSE_SECONDS
            user.check(f"{key} after {clicks} clicks gives up", user.modal() == [], user.modal())
            user.check("  the view is as before", _view(user) == view, _view(user))
    yield from user.hands.key("ESC")
    user.check("and the document too", user.state_digest() == before and user.group().settings.sheet == 1)


def _given_up_while_it_is_found(user: User, path: Path) -> Waits:
    yield from _open(user, path)
    before = user.state_digest()
    _, second = _middles(user)
    yield from _begin(user)
    yield from _click_on_photo(user, second)
    yield from user.hands.over()
    yield from user.hands.key("ESC")
    yield 2.0
    user.check("ESC ends the search", user.modal() == [] and user.running() is None, user.modal())
    user.check("and all is as before", user.state_digest() == before and user.group().settings.sheet == 1)


def _beside(user: User, path: Path) -> Waits:
    """After a click beside all sheets, or on the current one, it keeps waiting; the sidebar handles its own clicks."""
    yield from _open(user, path)
    first, second = _middles(user)
    yield from _begin(user)
    for what, place in (("beside all sheets", _BESIDE), ("on the sheet that is taken", first)):
        yield from _click_on_photo(user, place)
        user.check(f"after a click {what} it waits on", user.modal() == [_OPERATOR] and not user.running())
    yield from _click_on_photo(user, second)
    yield from user.wait_for_end()
    _is_taken(user, "then the other sheet is taken", 2)


def _pressed_twice(user: User, path: Path) -> Waits:
    yield from _open(user, path)
    view = _view(user)
    _, second = _middles(user)
    yield from _begin(user)
    yield from _begin(user)
    yield from user.hands.over()
    yield _PAUSE_SECONDS
    user.check("pressed twice, one pipette is there", user.modal() == [_OPERATOR], user.modal())
    yield from user.hands.key("ESC")
    yield _PAUSE_SECONDS
    user.check("which one ESC puts down", user.modal() == [], user.modal())
    user.check("  the view is as before the first", _view(user) == view, _view(user))
    yield from _begin(user)
    yield from _begin(user)
    yield from _click_on_photo(user, second)
    yield from user.wait_for_end()
    _is_taken(user, "pressed twice and clicked", 2)


def _delete_objects(user: User) -> None:
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()


def _delete_collection(user: User) -> None:
    bpy.data.collections.remove(user.document().collection)


_CHANGES: dict[str, Callable[[User], None]] = {
    "the document is deleted": User.delete_document,
    "all objects are deleted": _delete_objects,
    "the collection is deleted": _delete_collection,
    "another document is chosen": User.choose_another_document,
    "what was found is taken back": User.forget_all_but_the_model,
}


def _changed_meanwhile(user: User, path: Path) -> Waits:
    """Between the button and the click."""
    for what, change in _CHANGES.items():
        yield from _open(user, path)
        yield from _begin(user)
        with user.hands.at():
            change(user)
            bpy.ops.ed.undo_push(message=what)
        yield _PAUSE_SECONDS
        yield from user.hands.over()
        yield from user.hands.key("LEFTMOUSE")
        yield _PAUSE_SECONDS
        yield from user.hands.key("ESC")
        yield 2.0
        user.check(f"{what} before the click: nothing waits", user.modal() == [], user.modal())
        user.check("  and nothing runs", user.running() is None)
        perspective = user.hands.area().spaces.active.region_3d.view_perspective
        user.check("  and the view is given back", perspective != "CAMERA", perspective)
        yield from user.hands.key("Z", "ctrl")
        yield 1.0


def _another_file(user: User, path: Path) -> Waits:
    yield from _open(user, path)
    yield from _begin(user)
    yield from interruptions.another_file(user, path, "opened", "while the pipette waits")
    yield from interruptions.clicks_afterwards(user)
    yield from _open(user, path)
    view = _view(user)
    yield from _begin(user)
    yield from user.hands.over()
    yield from user.hands.key("ESC")
    yield _PAUSE_SECONDS
    user.check("and what it looked like before is forgotten", _view(user) == view, _view(user))


def _deleted_before(user: User, path: Path) -> Waits:
    yield from _open(user, path)
    with user.hands.at():
        user.delete_document()
        bpy.ops.ed.undo_push(message="Delete")
        user.check("without a document there is no pipette", not bpy.ops.origami.pick_sheet.poll())
    yield 1.0
    user.hands.picture("document_deleted")
    yield from user.hands.over()
    yield from user.hands.key("Z", "ctrl")
    yield 1.0
    user.check("Undo brings the document back", user.done() == ["place", "find"], user.done())
    _, second = _middles(user)
    yield from _begin(user)
    yield from _click_on_photo(user, second)
    yield from user.wait_for_end()
    _is_taken(user, "and its other sheet is taken", 2)
