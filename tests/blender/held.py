"""How long the add-on's code blocks Blender's main thread, call by call."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import bpy

LIMIT_SECONDS = 0.1
# Blender's own unwraps hold it too, and so have a redo panel.
_AT_ONCE = dict.fromkeys((f"{name} ORIGAMI_OT_unwrap_developable" for name in ("invoke", "execute")), 1.0)
# Its time is that of software OpenGL; the reading before it is measured separately.
_DRAWING = "draw over the 3D view"


@dataclass
class Calls:
    """Calls of one kind: seconds of processor and wall time, and the longest calls."""

    cpu: list[float] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)
    at: list[str] = field(default_factory=list)


class Held:
    """Wraps the add-on's functions that Blender calls.

    Parameters
    ----------
    package : str
        The add-on's, as Blender loads it.
    """

    def __init__(self, package: str) -> None:
        self.calls: dict[str, Calls] = {}
        self._package = package
        self._inside = 0
        self._wrap_operators()
        self._wrap_panels()
        self._wrap_handlers()

    @contextmanager
    def measured(self, kind: str, at: str = "") -> Iterator[None]:
        """Measure the block; blocks inside are part of the outer one."""
        if self._inside or threading.current_thread() is not threading.main_thread():
            yield
            return
        self._inside += 1
        wall, cpu = time.perf_counter(), time.thread_time()
        try:
            yield
        finally:
            self._inside -= 1
            calls = self.calls.setdefault(kind, Calls())
            calls.cpu.append(time.thread_time() - cpu)
            calls.wall.append(time.perf_counter() - wall)
            calls.at.append(at)

    def module(self, name: str) -> Any:
        """A module of the add-on."""
        return import_module(f"{self._package}.origami_addon.{name}")

    def _running(self) -> str:
        now = self.module("jobs.running").current()
        return "" if now is None else f"{now.label}: {now.text}"

    def _wrap_operators(self) -> None:
        for cls in self.module("operators").CLASSES:
            for name in ("invoke", "modal"):
                if hasattr(cls, name):
                    setattr(cls, name, self._event_timed(getattr(cls, name), f"{name} {cls.__name__}"))
            if hasattr(cls, "execute"):
                cls.execute = self._timed(cls.execute, f"execute {cls.__name__}")
            if hasattr(cls, "poll"):
                cls.poll = classmethod(self._timed(cls.poll.__func__, "poll of operators"))

    def _wrap_panels(self) -> None:
        for cls in self.module("window.panels").CLASSES:
            for name in ("draw", "draw_header_preset"):
                if issubclass(cls, bpy.types.Panel) and hasattr(cls, name):
                    setattr(cls, name, self._timed(getattr(cls, name), f"{name} of panels"))

    # Blender counts the arguments of what it calls: each kind has a wrapper of its own.

    def _timed(self, function: Any, kind: str) -> Any:
        def timed(subject: Any, context: Any) -> Any:
            with self.measured(kind, getattr(subject, "bl_label", "")):
                return function(subject, context)

        return timed

    def _event_timed(self, function: Any, kind: str) -> Any:
        def timed(subject: Any, context: Any, event: Any) -> Any:
            with self.measured(kind, self._running()):
                return function(subject, context, event)

        return timed

    def _wrap_handlers(self) -> None:
        edits, overlay = self.module("scene.edits"), self.module("window.overlay")
        edits.unregister()
        note = edits._note

        def noted(scene: Any, depsgraph: Any) -> None:
            with self.measured("depsgraph handler"):
                note(scene, depsgraph)

        edits._note = bpy.app.handlers.persistent(noted)
        edits.register()
        overlay.unregister()
        draw, refresh = overlay._draw, overlay._refresh

        def drawn() -> None:
            with self.measured(_DRAWING):
                draw()

        def refreshed(document: Any) -> None:
            inside, self._inside = self._inside, 0
            with self.measured("  of it: reading the scene"):
                refresh(document)
            self._inside = inside

        overlay._draw, overlay._refresh = drawn, refreshed
        overlay.register()

    def table(self) -> str:
        """The kinds of calls, those that block the main thread longest first."""
        lines = [f"{'what':44} {'calls':>6} {'longest CPU s':>14} {'longest wall s':>15}  at"]
        for kind, calls in sorted(self.calls.items(), key=lambda item: -max(item[1].cpu)):
            worst = max(range(len(calls.cpu)), key=calls.cpu.__getitem__)
            lines.append(
                f"{kind:44} {len(calls.cpu):6} {calls.cpu[worst]:14.3f} {max(calls.wall):15.3f}  {calls.at[worst]}"
            )
        return "\n".join(lines)

    def too_long(self) -> list[str]:
        """Each call over the limit."""
        return [
            f"{kind}: {cpu:.3f} s ({wall:.3f} s on the clock) {at}"
            for kind, calls in self.calls.items()
            for cpu, wall, at in zip(calls.cpu, calls.wall, calls.at)
            if cpu > _AT_ONCE.get(kind, LIMIT_SECONDS) and kind != _DRAWING
        ]
