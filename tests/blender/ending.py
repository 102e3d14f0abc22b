"""ESC, Cancel and Stop at each stage: how soon the operator ends, how soon its processes, and what is left."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy

from .hands import Waits
from .user import User

_LIMIT_SECONDS = 1.0
_GIVE_UP_SECONDS = 20.0


def _place_again(settings: Any, number: int) -> None:
    settings.sfm.seed = number


def _smooth_otherwise(settings: Any, number: int) -> None:
    settings.surface.smoothness = 1 + 0.01 * number


# The change that makes the run start at or before a stage, the job's text once it is there, and how many stages a Stop
# keeps.
_AT = {
    "structure from motion": (_place_again, ("xtract", "atch"), 0),
    "the surface": (_smooth_otherwise, ("surface", "Bending"), 2),
    "the page": (_smooth_otherwise, ("Looking at the page", "Laying", "Blending", "light off"), 5),
}


def scene(user: User) -> Waits:
    """Every way to end, at every stage."""
    number = 10
    places: dict[str, tuple[int, int]] = {}
    for stage in _AT:
        for way in ("ESC", "cancel", "stop"):
            number += 1
            yield from _end(user, stage, way, number, places)


def _end(user: User, stage: str, way: str, number: int, places: dict[str, tuple[int, int]]) -> Waits:
    """The buttons are located during long work, and are in the same place during short work."""
    hands = user.hands
    change, words, kept = _AT[stage]
    change(user.group().settings, number)
    yield 0.3
    before, done_before = user.state_digest(), user.done()
    hands.forget_places()
    yield from hands.press("bpy.ops.origami.rectify")
    yield from user.wait_for_text(*words)
    job = user.running().job
    if way == "ESC":
        yield from hands.over()
    else:
        if way not in places:
            places[way] = yield from hands.find(f"bpy.ops.origami.{way}()")
        place = places[way]
    if way == "cancel" and kept:
        _work_on(hands)
    processes = descendants(os.getpid())
    names = ", ".join(sorted(name for name in processes.values()))
    watch = _Watch(lambda: user.running() is None, processes)
    if way == "ESC":
        watch.begin()
        hands.window.event_simulate(type="ESC", value="PRESS", x=hands.mouse[0], y=hands.mouse[1])
        yield 0.1
        hands.window.event_simulate(type="ESC", value="RELEASE", x=hands.mouse[0], y=hands.mouse[1])
    else:
        yield from hands.move(*place)
        yield 0.2
        hands.window.event_simulate(type="LEFTMOUSE", value="PRESS", x=place[0], y=place[1])
        yield 0.1
        watch.begin()
        hands.window.event_simulate(type="LEFTMOUSE", value="RELEASE", x=place[0], y=place[1])
    while not watch.over:
        yield 0.1
    measured = f"operator {watch.operator:.2f} s, processes {watch.processes:.2f} s ({len(processes)}: {names})"
    user.check(
        f"{way} at {stage} ends within a second", max(watch.operator, watch.processes) < _LIMIT_SECONDS, measured
    )
    yield 2.0
    user.check("  its folder is gone", not Path(job.folder).exists())
    if way == "stop":
        user.check("  what was finished stays", len(user.done()) >= kept, user.done())
    else:
        same = user.state_digest() == before and user.done() == done_before
        user.check("  the document is as before", same, user.done())


def _work_on(hands: Any) -> None:
    """What a user does meanwhile."""
    with hands.at():
        bpy.ops.object.empty_add()
        bpy.ops.ed.undo_push(message="Add Empty")


def descendants(parent: int) -> dict[int, str]:
    """All processes that a process has started, directly or not, by number, with their names."""
    children: dict[int, list[tuple[int, str]]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                head, _, tail = (entry / "stat").read_text().rpartition(")")
            except OSError:
                continue
            children.setdefault(int(tail.split()[1]), []).append((int(entry.name), head.partition("(")[2]))
    found: dict[int, str] = {}
    waiting = [parent]
    while waiting:
        for number, name in children.get(waiting.pop(), []):
            found[number] = name
            waiting.append(number)
    return found


def lives(process: int) -> bool:
    """Whether a process still runs; a zombie does not count."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


class _Watch:
    """Notes when something ends, polling a hundred times a second outside Blender's main loop."""

    def __init__(self, ended: Callable[[], bool], processes: dict[int, str]) -> None:
        self._ended, self._left = ended, set(processes)
        self.operator = self.processes = float("inf")
        self.over = False

    def begin(self) -> None:
        """Start the clock."""
        self._begun = time.perf_counter()
        threading.Thread(target=self._look, daemon=True).start()

    def _look(self) -> None:
        while not self.over:
            seconds = time.perf_counter() - self._begun
            if self._ended():
                self.operator = min(self.operator, seconds)
            self._left = {process for process in self._left if lives(process)}
            if not self._left:
                self.processes = min(self.processes, seconds)
            self.over = max(self.operator, self.processes) < float("inf") or seconds > _GIVE_UP_SECONDS
            time.sleep(0.01)
