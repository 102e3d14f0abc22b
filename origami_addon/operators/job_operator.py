"""An operator whose work runs in a job: without blocking the window, and in background mode until it is done."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Container, Iterator
from typing import Any

import bpy

from ...core.errors import OrigamiError, StepFailed
from ..files.kept import Arrays
from ..jobs import running
from ..jobs.process import Job
from ..jobs.requests import AnyRequest
from ..plan import NothingToDo
from ..scene.chosen import active_document
from ..scene.document import Document, documents
from ..scene.document_copies import part_copies
from ..scene.edits import own_changes
from ..scene.modes import push_undo, return_to, users_mode
from . import arriving
from .needs import Operator
from .status import clear_status

_TICK_SECONDS = 0.05  # between two looks at the job in the window
_WAIT_SECONDS = 0.1  # the same without a window
# Share of each tick that may be spent on updating the scene.
_BUDGET_SECONDS = 0.02

CHANGED = (
    "The document was changed while the work ran, perhaps by Undo, and the results no longer fit: run the step again."
)

log = logging.getLogger("origami")


class JobOperator(Operator):
    """A mix-in for operators, which define the job's input (`prepare`) and what to do with its results (`apply`).

    They must not open a dialog: Blender would hold such an operator twice, as dialog and as job, and free it twice.
    Another operator asks and then starts this one (`nested.start`).
    """

    alone = True
    label = "Working"
    pushes_undo = True  # after each result; otherwise Blender does so once, because of the operator's options

    def target(self, context: bpy.types.Context) -> Document | None:
        """The document to work on; raises OrigamiError if it is gone."""
        return active_document(context)

    def prepare(self, context: bpy.types.Context) -> tuple[AnyRequest, Arrays]:
        """The job's request and arrays.

        Raises
        ------
        OrigamiError, NothingToDo
        """
        raise NotImplementedError

    def apply(self, context: bpy.types.Context, message: dict[str, Any], job: Job) -> Iterator[None]:
        """Put the result in a message into the scene, with a pause after each small piece."""
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Do the job and wait for it."""
        if not self._begin(context):
            return {"CANCELLED"}
        job = self._now.job
        try:
            while not job.ended:
                for message in job.messages(wait=_WAIT_SECONDS):
                    with own_changes():
                        for _ in self._take(context, message):
                            pass
        except OrigamiError as error:
            return self._fail(error)
        finally:
            running.end()
        return self._finish(context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Start the job and follow it from a timer, while the window stays responsive."""
        if bpy.app.background:
            return self.execute(context)
        if not self._begin(context):
            return {"CANCELLED"}
        manager = context.window_manager
        self._timer = manager.event_timer_add(_TICK_SECONDS, window=context.window)
        manager.modal_handler_add(self)
        self._arriving = arriving.begin()
        self._shown = ""
        self._shown_in: set[str] = set()
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Handle a tick of the timer; pass all other events on."""
        now = self._now
        if running.current() is not now:  # the add-on was disabled, or another file opened
            self._leave(context)
            return {"CANCELLED"}
        if event.type == "ESC" and event.value == "PRESS":
            now.wish = "cancel"
        elif event.type != "TIMER":
            return {"PASS_THROUGH"}
        if now.wish is not None:
            return self._give_up(context, now)
        try:
            return self._tick(context, now)
        except OrigamiError as error:
            self._end_midway(context)
            return self._fail(error)
        except ReferenceError:  # the object that was being updated has been removed since the last tick
            self._end_midway(context)
            return self._fail(StepFailed(CHANGED))
        except Exception:
            self._end_midway(context)
            raise

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator, for example when its window closes."""
        if running.current() is self._now:
            self._end_midway(context)
        else:  # another file is opened
            self._leave(context)

    def _begin(self, context: bpy.types.Context) -> bool:
        part_copies()  # copies that Blender has not reported yet
        self._mode = users_mode(context)
        self._warned: list[str] = []
        try:
            document = self.target(context)
            self._begun_on = "" if document is None else document.name
            running.forget_failure(self._begun_on)
            request, given = self.prepare(context)
            if self._mode is not None and not bpy.app.background:
                push_undo(context, f"Before {self.label}")  # Cancel goes back to it
            self._now = running.Running(Job(request, given), self.label, self._begun_on)
        except NothingToDo as reason:
            self.report({"INFO"}, str(reason))
            return_to(context, self._mode)
            return False
        except OrigamiError as error:
            self._fail(error)
            return_to(context, self._mode)
            return False
        running.begin(self._now)
        self._documents = {each.name for each in documents()}
        self._applied = 0
        self._summary = ""
        return True

    def _take(self, context: bpy.types.Context, message: dict[str, Any]) -> Iterator[None]:
        if "progress" in message:
            self._now.fraction, self._now.text = float(message["progress"]), str(message["text"])
        elif "done" in message:
            self._warned += message.get("warnings", [])
            yield from self.apply(context, message, self._now.job)
            yield
            if self.pushes_undo and not bpy.app.background:
                push_undo(context, self.done_text(message))
            self._applied += 1

    def done_text(self, message: dict[str, Any]) -> str:
        """The name of the undo step for the result in ``message``."""
        return self.label

    def _tick(self, context: bpy.types.Context, now: running.Running) -> set[str]:
        until = time.perf_counter() + _BUDGET_SECONDS
        if not self._arriving:  # finished results go into the scene before a later failure is reported
            self._arriving.add(self._take(context, message) for message in now.job.messages())
        while self._arriving and time.perf_counter() < until and not _is_held(context):
            self._arriving.advance()
        if now.job.ended and not self._arriving:
            self._leave(context)
            return self._finish(context)
        shown = f"{now.label}: {now.text}   {100 * now.fraction:.0f} %   ESC to cancel"
        if shown != self._shown:
            self._shown = shown
            context.workspace.status_text_set(shown)
            self._shown_in.add(context.workspace.name)
            _redraw(context, {"UI"})
        return {"RUNNING_MODAL"}

    def _give_up(self, context: bpy.types.Context, now: running.Running) -> set[str]:
        newer = [each.title for each in documents() if each.name not in self._documents]
        kept = self._applied if now.wish == "stop" or newer else 0
        if self.pushes_undo and self._applied and not kept:
            self._leave(context)
            arriving.undo_soon(self._applied, bool(self._arriving), self.as_before(), self._mode)
        else:
            self._end_midway(context)
        said = "Cancelled"
        if kept:
            why = f", because undoing them would also undo {newer[0]}" if newer and now.wish == "cancel" else ""
            said = f"Stopped; {kept} finished stages are kept{why}"
        self.report({"INFO"}, said)
        return {"CANCELLED"}

    def _end_midway(self, context: bpy.types.Context) -> None:
        """End, and undo a result of which only a part has been put into the scene."""
        self._leave(context)
        mode = None if self._applied else self._mode
        if self._arriving or mode is not None:
            arriving.undo_soon(0, bool(self._arriving), None, mode)

    def as_before(self) -> Callable[[], bool] | None:
        """A function that says, once the operator has ended, whether its changes are undone; None if unknown."""
        return None

    def _finish(self, context: bpy.types.Context) -> set[str]:
        for warning in self._warned:
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, self.finished_text())
        if not self.pushes_undo:  # the edited data is as before
            return_to(context, self._mode)
        return {"FINISHED"}

    def finished_text(self) -> str:
        """The message once everything is done."""
        return f"{self.label}: done"

    def _fail(self, error: OrigamiError) -> set[str]:
        warnings = tuple(dict.fromkeys((*self._warned, *error.warnings)))
        running.fail(running.Failure(self._begun_on, str(error), warnings))
        for warning in warnings:
            self.report({"WARNING"}, warning)
        self.report_failure(str(error))
        return {"CANCELLED"}

    def report_failure(self, sentence: str) -> None:
        """Report to the user why the work failed."""
        self.report({"ERROR"}, sentence)

    def _leave(self, context: bpy.types.Context) -> None:
        arriving.end(self._arriving)
        if running.current() is self._now:
            running.end()
        context.window_manager.event_timer_remove(self._timer)
        clear_status(self._shown_in)
        _redraw(context, {"WINDOW", "UI"})


def is_free(context: bpy.types.Context) -> bool:
    """Whether a job may start by itself: none runs or is being undone, and the user is not moving something."""
    return running.current() is None and not arriving.is_undoing() and not _is_held(context)


def _is_held(context: bpy.types.Context) -> bool:
    """Whether one of Blender's own operators is running, such as a move by mouse: it holds on to its data."""
    held = (each for window in context.window_manager.windows for each in window.modal_operators)
    return any(getattr(bpy.types, each.bl_idname, None) is None for each in held)  # Python's operators are known there


def _redraw(context: bpy.types.Context, regions: Container[str]) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in ("VIEW_3D", "IMAGE_EDITOR"):
                for region in area.regions:
                    if region.type in regions:
                        region.tag_redraw()
