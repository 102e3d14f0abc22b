"""What the random user (`monkey.py`) does with hands and buttons."""

from __future__ import annotations

from typing import Any

import bpy

from .buttons import Setting
from .hands import Waits
from .monkey_deeds import DEEDS
from .random_user import Act, Monkey

_KEYS: tuple[tuple[str, ...], ...] = (
    *(("TAB",), ("A",), ("A", "alt"), ("B",), ("G",), ("R",), ("S",), ("H",), ("H", "alt"), ("ESC",), ("RET",)),
    *(("D", "shift"), ("D", "alt"), ("J", "ctrl"), ("P", "ctrl"), ("P", "alt"), ("L",), ("E",), ("F",), ("X",)),
    *(("NUMPAD_0",), ("NUMPAD_7",), ("NUMPAD_PERIOD",), ("NUMPAD_SLASH",), ("HOME",), ("Z",), ("TAB", "ctrl")),
    *(("M",), ("A", "ctrl"), ("ONE",), ("THREE",), ("I",), ("LEFTMOUSE",), ("RIGHTMOUSE",), ("LEFTMOUSE", "shift")),
)
_MODES = ("OBJECT", "EDIT", "SCULPT", "WEIGHT_PAINT", "VERTEX_PAINT", "TEXTURE_PAINT")
_AT_ONCE = 0.5  # of the photos that are added
_CONFIRMED = 0.3  # of the questions whether to delete a document


def _press(monkey: Monkey) -> Waits:
    """An enabled button."""
    buttons, _ = monkey.shown()
    enabled = [each for each in buttons if each.is_enabled()]
    if not enabled:
        return
    operator = monkey.random.choice(sorted({each.operator for each in enabled}))
    button = monkey.random.choice([each for each in enabled if each.operator == operator])
    given = dict(button.properties)
    if button.operator == "add_photos":
        given |= {"directory": f"{monkey.user.folder / 'two_sheets'}/", "rectify": False}
        given |= {"files": [{"name": f"{number}.png"} for number in range(monkey.random.randint(1, 5))]}
    if button.operator in ("export", "find_photos", "add_other_light", "add_folders"):
        yield from _browse(monkey, button)
        return
    monkey.say(f"press {button}")
    if button.operator == "add_photos":
        try:
            with monkey.user.hands.at():
                bpy.ops.origami.add_photos(**given)
                bpy.ops.ed.undo_push(message="Document Photos")
            if monkey.random.random() < _AT_ONCE:  # as its dialog does; a script would wait for the page
                monkey.press("rectify", {})
        except RuntimeError as error:
            monkey.hear(str(error))
    elif button.operator == "delete_document" and monkey.random.random() < _CONFIRMED:
        monkey.deletes = True
        with monkey.user.hands.at():
            bpy.ops.origami.delete_document()
    elif button.operator == "export_settings":
        try:
            bpy.ops.origami.export_settings(filepath=str(monkey.user.folder / "settings.json"))
        except RuntimeError as error:
            monkey.hear(str(error))
    else:
        monkey.press(button.operator, given)
    yield monkey.random.choice((0.05, 0.05, 0.2, 1.0))


def _browse(monkey: Monkey, button: Any) -> Waits:
    """A button that opens the file browser; its window is closed, or a folder is chosen."""
    monkey.say(f"press {button} and choose")
    monkey.press(button.operator, {})
    yield 1.0
    browser = bpy.context.window_manager.windows[-1]
    area = next((each for each in browser.screen.areas if each.type == "FILE_BROWSER"), None)
    if area is None:
        return
    places = ("shelf",) if button.operator == "add_folders" else ("two_sheets", "pictures")
    place = monkey.user.folder / monkey.random.choice(places)
    accept = monkey.random.random() < 0.6
    if area.spaces.active.params is not None:
        area.spaces.active.params.directory = f"{place}/".encode()
    yield 0.5
    try:
        with bpy.context.temp_override(window=browser, area=area):
            if accept:
                bpy.ops.file.execute("INVOKE_DEFAULT")
            else:
                bpy.ops.file.cancel()
    except RuntimeError as error:
        monkey.hear(str(error))
    yield 0.5
    if accept and button.operator == "add_folders":
        yield from monkey.user.hands.key("RET")  # of its dialog
        yield 0.5


def _set(monkey: Monkey) -> Waits:
    """A setting of the tab."""
    _, settings = monkey.shown()
    if not settings:
        return
    setting = monkey.random.choice(settings)
    value = _any_value(monkey, setting)
    monkey.say(f"{setting} = {value!r}")
    try:
        setattr(setting.owner, setting.name, value)
    except TypeError as error:  # Blender refuses it, as the window would
        monkey.say(error)
    bpy.ops.ed.undo_push(message="Setting")
    yield 0.05


def _any_value(monkey: Monkey, setting: Setting) -> Any:
    declared, dice = setting.declared, monkey.random
    if declared.type == "BOOLEAN":
        return dice.random() < 0.5
    if declared.type == "ENUM":
        return dice.choice([each.identifier for each in declared.enum_items] or [""])
    if declared.type == "INT":
        return dice.randint(declared.soft_min, min(declared.soft_max, declared.soft_min + 1000))
    if declared.type == "FLOAT":
        return dice.uniform(declared.soft_min, min(declared.soft_max, declared.soft_min + 500))
    if declared.type == "POINTER":
        return dice.choice([*bpy.data.collections, None])
    names = [each.name for each in setting.owner.id_data.origami.photos] if declared.name else []
    return dice.choice([*names, "", "nothing of that name", "//"])


def _key(monkey: Monkey) -> Waits:
    key = monkey.random.choice(_KEYS)
    monkey.say(f"key {key}")
    view = monkey.user.hands.region("WINDOW")
    x, y = (monkey.random.randint(0, size - 1) for size in (view.width, view.height))
    yield from monkey.user.hands.move(view.x + x, view.y + y)
    yield from monkey.user.hands.key(*key)
    if monkey.random.random() < 0.5:
        yield from monkey.user.hands.move(view.x + x // 2, view.y + y // 2)
        yield from monkey.user.hands.key(monkey.random.choice(("LEFTMOUSE", "RET", "ESC")))


def _click(monkey: Monkey) -> Waits:
    """Anywhere in the tab."""
    side = monkey.user.hands.region("UI")
    if side.width <= 1:
        with monkey.user.hands.at():
            bpy.context.space_data.show_region_ui = True
        return
    x, y = side.x + monkey.random.randint(0, side.width - 25), side.y + monkey.random.randint(0, side.height - 1)
    monkey.say(f"click {x} {y}")
    yield from monkey.user.hands.click(x, y)
    if monkey.random.random() < 0.3:
        yield from monkey.user.hands.key(monkey.random.choice(("RET", "ESC", "DOWN_ARROW", "WHEELDOWNMOUSE")))


def _undo(monkey: Monkey) -> Waits:
    count = monkey.random.randint(1, 4)
    monkey.say(f"undo {count}")
    yield from monkey.user.hands.over()
    for _ in range(count):
        yield from monkey.user.hands.key("Z", "ctrl")


def _redo(monkey: Monkey) -> Waits:
    count = monkey.random.randint(1, 3)
    monkey.say(f"redo {count}")
    yield from monkey.user.hands.over()
    for _ in range(count):
        yield from monkey.user.hands.key("Z", "ctrl", "shift")


def _mode(monkey: Monkey) -> Waits:
    mode = monkey.random.choice(_MODES)
    monkey.say(f"mode {mode}")
    with monkey.user.hands.at():
        try:
            bpy.ops.object.mode_set("INVOKE_DEFAULT", True, mode=mode)
        except (RuntimeError, TypeError) as error:
            monkey.say(error)
    yield 0.1


def _choose(monkey: Monkey) -> Waits:
    """Make another object active."""
    if bpy.context.mode != "OBJECT" or not bpy.context.view_layer.objects:
        return
    chosen = monkey.random.choice(list(bpy.context.view_layer.objects))
    monkey.say(f"choose {chosen.name}")
    for each in bpy.context.view_layer.objects:
        each.select_set(each == chosen)
    bpy.context.view_layer.objects.active = chosen
    bpy.ops.ed.undo_push(message="Select")
    yield 0.05


def _wait(monkey: Monkey) -> Waits:
    monkey.say("wait")
    yield monkey.random.uniform(0.3, 4.0)


ACTS: dict[str, Act] = {
    "press": Act(_press, 30),
    "set": Act(_set, 12),
    "key": Act(_key, 14, may_lose=True, by_hand=True),
    "click": Act(_click, 8, may_lose=True, by_hand=True),
    "undo": Act(_undo, 8, may_lose=True, by_hand=True),
    "redo": Act(_redo, 4, may_lose=True, by_hand=True),
    "mode": Act(_mode, 5),
    "choose": Act(_choose, 6),
    "wait": Act(_wait, 6),
    **{name: Act(*rest) for name, rest in DEEDS.items()},
}
