"""The random user (`monkey.py`): hands, dice, and what must hold after each action."""

from __future__ import annotations

import random
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

from .buttons import shown
from .hands import Waits
from .user import User

_ESCAPES = 4  # enough to leave a menu in a menu, a dialog and a move by mouse


@dataclass(frozen=True)
class Act:
    """An action: how likely it is, whether it may take documents away, and whether only hands do it."""

    act: Callable[[Monkey], Waits]
    weight: float
    may_lose: bool = False
    by_hand: bool = False


@dataclass
class Monkey:
    """The random user: its hands, its dice, the file it starts from, and what went wrong so far."""

    user: User
    random: random.Random
    home: Path

    def __post_init__(self) -> None:
        self.now = ""
        self.faults: list[str] = []
        self.sentences: set[str] = set()
        self.unfollowed = 0
        self.deletes = False  # whether the last action has deleted a document

    def say(self, what: object) -> None:
        """Print what is done next."""
        print(f"monkey {self.now}: {what} ({time.strftime('%T')})", flush=True)

    def documents(self) -> set[str]:
        """The names of all documents."""
        return {each.name for each in self.user.module("scene.document").documents()}

    def exists(self, name: str) -> bool:
        """Whether there is still a document of this name."""
        return name in self.documents()

    def ready(self, act: Act) -> Waits:
        """A script cannot do what a user cannot: nothing but keys while Blender's own operator is at work."""
        if act.by_hand:
            return
        for _ in range(_ESCAPES):
            if not self._blender_at_work():
                return
            yield from self.user.hands.key("ESC")
        self.say("Blender's own operator stays")

    def _blender_at_work(self) -> bool:
        held = self.user.hands.window.modal_operators
        return any(not each.bl_idname.startswith("ORIGAMI") for each in held)

    def press(self, operator: str, properties: dict[str, Any]) -> str:
        """Press a button; returns what it reports as an error."""
        try:
            with self.user.hands.at():  # as for a button of the sidebar
                getattr(bpy.ops.origami, operator)("INVOKE_DEFAULT", True, **properties)
        except RuntimeError as error:
            self.hear(str(error))
            return str(error)
        return ""

    def hear(self, sentence: str) -> None:
        if "Traceback" in sentence:
            self.faults.append(f"{self.now}: {sentence}")
        self.sentences.add(sentence.strip())

    def shown(self) -> tuple[list[Any], list[Any]]:
        """The tab's buttons and settings now; a failure to draw them is a fault."""
        try:
            with self.user.hands.at("UI"):
                return shown(self.user.module("window.panels"))
        except Exception:
            self.faults.append(f"{self.now}: {traceback.format_exc()}")
            return [], []

    def look(self, before: set[str], *, may_lose: bool) -> None:
        """What must hold after each action."""
        lost = before - self.documents()
        if lost and not may_lose and not self.deletes:
            self.faults.append(f"{self.now}: lost {lost}")
        failure = self.user.module("jobs.running").failure()
        if failure is not None:
            self.sentences.add(failure.sentence)
        followed = any(
            each.bl_idname.startswith("ORIGAMI")
            for window in bpy.context.window_manager.windows
            for each in window.modal_operators
        )
        self.unfollowed = self.unfollowed + 1 if self.user.running() is not None and not followed else 0
        if self.unfollowed == 2:
            self.faults.append(f"{self.now}: a job runs that no operator follows")
        self.deletes = False
        self.shown()

    def internal(self) -> list[str]:
        """Failures that blame the program."""
        words = ("Internal error", "unexpectedly", "report it", "Traceback")
        return [each for each in sorted(self.sentences) if any(word in each for word in words)]

    def end_all(self) -> Waits:
        """Close what is open and end what is running, as a user does."""
        for window in list(bpy.context.window_manager.windows)[1:]:
            with bpy.context.temp_override(window=window):
                bpy.ops.wm.window_close()
        yield from self.user.hands.over()
        for _ in range(_ESCAPES):
            yield from self.user.hands.key("ESC")
        yield 3.0
        if bpy.context.mode != "OBJECT":
            with self.user.hands.at():
                bpy.ops.object.mode_set(mode="OBJECT")
        yield from self.user.wait_for_end()
        self.say(f"heard: {sorted(self.sentences)}")
