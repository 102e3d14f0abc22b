"""The documents that wait to be rectified, one after the other, and how long that will take.

Only names are kept, because the user may undo, delete and rename documents meanwhile; a file that is opened has its own
documents, and its queue is empty.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from .running import Running

# A job has to report this share of its work before the time left can be estimated from it.
_LEAST_SHARE = 0.05


@dataclass
class Queue:
    """Documents that wait.

    Attributes
    ----------
    waiting : list of str
        Their names, the next one first.
    paused : bool
        Whether the next one waits for the user, who has ended a run.
    """

    waiting: list[str] = field(default_factory=list)
    paused: bool = False
    _seconds: list[float] = field(default_factory=list)  # of the runs that have finished

    def add(self, names: Iterable[str]) -> None:
        """Put documents at the end, except those that wait already, and go on."""
        self.waiting += [name for name in dict.fromkeys(names) if name not in self.waiting]
        self.paused = False

    def take(self) -> str | None:
        """Take the next document out; None if none waits, or all wait for the user."""
        return None if self.paused or not self.waiting else self.waiting.pop(0)

    def leave(self, name: str) -> None:
        """Take a document out without rectifying it."""
        self.waiting = [each for each in self.waiting if each != name]

    def pause(self, name: str) -> None:
        """The user has ended the run of a document: it becomes the next one again, and waits with the others."""
        self.leave(name)
        self.waiting.insert(0, name)
        self.paused = True

    def resume(self) -> None:
        """Go on with the next one."""
        self.paused = False

    def finished(self, seconds: float) -> None:
        """Note how long the run of a document took."""
        self._seconds.append(seconds)

    def clear(self) -> None:
        """Forget everything, because another file is opened."""
        self.waiting.clear()
        self._seconds.clear()
        self.paused = False

    def seconds_left(self, now: Running, count: int) -> float | None:
        """How long ``count`` documents that wait will take, once the running job is done; None if that is not known."""
        one = sum(self._seconds) / len(self._seconds) if self._seconds else whole_seconds(now)
        return None if one is None else count * one


def whole_seconds(now: Running) -> float | None:
    """How long a running job will take in all; None if that is not known yet."""
    return None if now.fraction < _LEAST_SHARE else now.seconds / now.fraction


def seconds_left(now: Running) -> float | None:
    """How long a running job will still take; None if that is not known yet."""
    whole = whole_seconds(now)
    return None if whole is None else whole - now.seconds


queue = Queue()
