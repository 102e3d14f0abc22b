"""From dropped photos to the finished page, by mouse."""

from __future__ import annotations

import json

import bpy

from .hands import Waits
from .user import STAGES, User

_MENU = 300, 700  # where Blender opens one


def scene(user: User) -> Waits:
    """Empty panel, import menu, dropped photos, progress, result, every step."""
    hands = user.hands
    yield from hands.over()
    yield from hands.key("A")
    yield from hands.key("DEL")
    user.check("an empty scene", not bpy.data.objects)
    yield from hands.show_tab("Origami")
    yield from hands.sidebar_picture("panel_empty")
    place = yield from hands.find("bpy.ops.origami.add_photos")
    user.check("the empty panel offers to add photos", place)
    yield from _import_menu(user)
    yield from _drop(user)
    yield from user.wait_for_text("Matched", "Bending", "Sampling")
    yield 0.3
    hands.picture("running")
    yield from hands.sidebar_picture("running_panel")
    yield from user.wait_for_end()
    yield from hands.over()
    yield 1.0
    user.check("all stages are done", user.done() == list(STAGES), user.done())
    view = hands.area().spaces.active.region_3d
    user.check("the page comes first, seen from straight above", view.view_perspective == "ORTHO")
    hands.picture("finished")
    yield from _say_letter(user)
    hands.forget_places()
    yield from hands.sidebar_picture("finished_panel")
    for step in hands.steps[:-1]:  # export asks in a separate window: `looking`
        yield from hands.toggle(step)
        yield from hands.sidebar_picture(f"step_{step}")
        yield from hands.toggle(step)


def _say_letter(user: User) -> Waits:
    """The sheet's size is unknown so far: choose Letter and make the page again."""
    user.group().settings.page.paper = "Letter"
    yield from user.hands.press("bpy.ops.origami.rectify")
    yield 0.5
    yield from user.wait_for_end()
    stage = user.group().lay_out
    user.check("a letter's size fits the page", json.loads(stage.warnings) == [], stage.figures)


def _import_menu(user: User) -> Waits:
    hands = user.hands
    yield from hands.move(*_MENU)
    with hands.at():
        bpy.ops.wm.call_menu(name="TOPBAR_MT_file_import")
    yield 0.8
    hands.picture("import_menu", (0, hands.window.height - _MENU[1] - 150, 560, 400))
    yield from hands.key("ESC")
    yield 0.3


def _drop(user: User) -> Waits:
    """Like Blender for dropped files: call the file handler's operator and show its dialog."""
    hands = user.hands
    yield from hands.over()
    files = [{"name": path.name} for path in sorted(user.photos.iterdir())]
    with hands.at():
        bpy.ops.origami.add_photos("INVOKE_DEFAULT", directory=f"{user.photos}/", files=files)
    yield 1.0
    yield from hands.press_blue("photos_dialog")
    yield 1.0
    user.check("the dialog's button starts the run", user.running() is not None)
