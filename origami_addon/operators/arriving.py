"""Results on their way into the scene, piece by piece, and what is undone of them.

Blender frees what was made since its last undo step when the user undoes, but keeps what it takes for unchanged, with
its pointers to the freed data, and crashes. So a result that has been begun is completed, and gets its undo step,
before Blender undoes anything; what is left of one that cannot be completed gets an undo step too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import bpy

from ..scene.edits import own_changes
from ..scene.modes import UsersMode, return_to, users_mode

_UNDO_INTERVAL = 0.1  # seconds until Cancel undoes: its operator must have ended
# The most undo steps of the user's that Cancel goes back to reach its own.
_USERS_STEPS = 16
_HALF = "Cancelled"  # the name of the undo step of half a result


class Arriving:
    """The results of a job that are still to be put into the scene.

    Each is an iterator that does a small piece of it at a time and pushes an undo step in the end.
    """

    def __init__(self) -> None:
        self._results: list[Iterator[None]] = []
        self._is_begun = False
        self._failure: Exception | None = None

    def __bool__(self) -> bool:
        return bool(self._results)

    def add(self, results: Iterable[Iterator[None]]) -> None:
        """Put more results into the scene, after those still to be put there."""
        self._results += results

    def advance(self) -> None:
        """Do the next piece; raises what it raises."""
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise failure
        self._is_begun = True
        with own_changes():
            try:
                next(self._results[0])
            except StopIteration:
                self._results.pop(0)
                self._is_begun = False

    def complete(self) -> None:
        """Complete a result that has been begun; if that fails, `advance` raises why."""
        try:
            while self._is_begun and self._failure is None:
                self.advance()
        except Exception as failure:
            self._failure = failure
            bpy.ops.ed.undo_push(message=_HALF)


_arriving: Arriving | None = None  # of the operator that follows the job
_undo: Callable[[], None] | None = None  # the last one scheduled
_half_left = False  # whether that one has half a result to take away


def begin() -> Arriving:
    """The results of a job that has just been started, none so far."""
    global _arriving
    _arriving = Arriving()
    return _arriving


def end(results: Arriving | None) -> None:
    """Leave these results alone: the operator that follows their job ends."""
    global _arriving
    if results is _arriving:
        _arriving = None


def undo_soon(steps: int, unfinished: bool, is_as_before: Callable[[], bool] | None, mode: UsersMode | None) -> None:
    """Undo the changes to the scene once the operator has ended: it must not undo itself.

    The user may have done and undone things meanwhile, so the number of steps does not say how far to go. Afterwards
    the user is back in the mode in which they started the work.
    """
    global _undo, _half_left

    def undo() -> None:
        global _half_left
        window = bpy.context.window_manager.windows[0]
        with bpy.context.temp_override(window=window):
            if _half_left:
                _half_left = False
                _push_half()
                bpy.ops.ed.undo()
            for _ in range(steps if is_as_before is None else steps + _USERS_STEPS):
                if is_as_before is not None and is_as_before():
                    break
                bpy.ops.ed.undo()
            return_to(bpy.context, mode)

    _undo, _half_left = undo, unfinished
    bpy.app.timers.register(undo, first_interval=_UNDO_INTERVAL)


def is_undoing() -> bool:
    """Whether something is still to be undone."""
    return _undo is not None and bpy.app.timers.is_registered(_undo)


def _push_half() -> None:
    if users_mode(bpy.context) is not None:
        bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.ed.undo_push(message=_HALF)


@bpy.app.handlers.persistent
def _before_undo(*_: object) -> None:
    """Let the scene hold nothing that no undo step has."""
    global _half_left
    if _arriving is not None:
        _arriving.complete()
    elif _half_left and is_undoing():
        _half_left = False  # the user's undo takes it away
        _push_half()


def register() -> None:
    """Start to look for undos."""
    bpy.app.handlers.undo_pre.append(_before_undo)
    bpy.app.handlers.redo_pre.append(_before_undo)


def unregister() -> None:
    """Stop looking for undos."""
    bpy.app.handlers.undo_pre.remove(_before_undo)
    bpy.app.handlers.redo_pre.remove(_before_undo)
    end(_arriving)
