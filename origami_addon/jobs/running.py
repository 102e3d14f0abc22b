"""The one job that runs at a time, as panels and buttons see it, and why earlier ones failed."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Literal

from .process import Job

Wish = Literal["stop", "cancel"]


@dataclass
class Running:
    """A running job.

    Attributes
    ----------
    job : Job
    label : str
        The name of the work, for the user.
    document : str
        Name of the document on which it works; empty for none.
    fraction : float
        0 to 1, of the whole job.
    text : str
        Its current progress text.
    wish : {"stop", "cancel"} or None
        The user's request.
    begun : float
        When it was started, in seconds of the monotonic clock.
    """

    job: Job
    label: str
    document: str = ""
    fraction: float = 0.0
    text: str = "Starting"
    wish: Wish | None = None
    begun: float = field(default_factory=time.monotonic)

    @property
    def seconds(self) -> float:
        """How long it has been running."""
        return time.monotonic() - self.begun


@dataclass(frozen=True)
class Failure:
    """Why a job failed, or could not start.

    Attributes
    ----------
    document : str
        Name of the document that it worked on; empty for none.
    sentence : str
    warnings : tuple of str
        Its earlier warnings, which often give the reason.
    """

    document: str
    sentence: str
    warnings: tuple[str, ...]


_current: Running | None = None
_last: Failure | None = None
_failures: dict[str, Failure] = {}
_ended = 0


def current() -> Running | None:
    """The running job, if there is one."""
    return _current


def ended() -> int:
    """How many jobs have ended; if the number changes, cached values must be refreshed."""
    return _ended


def failure() -> Failure | None:
    """Why the last job failed; None if it did not, or once another job has started."""
    return _last


def failure_of(document: str) -> Failure | None:
    """Why the last job of a document failed; None if it did not."""
    return _failures.get(document)


def fail(failure: Failure) -> None:
    """Note why a job failed, for panels to show."""
    global _last
    _last = _failures[failure.document] = failure


def forget_failure(document: str) -> None:
    """Forget the last failure and that of a document, because another job of it starts."""
    global _last
    _last = None
    _failures.pop(document, None)


def forget_failures() -> None:
    """Forget all failures."""
    global _last
    _last = None
    _failures.clear()


def begin(running: Running) -> None:
    """Note that a job is running."""
    global _current
    _current = running


def end() -> None:
    """End the running job, if there is one, and forget it."""
    global _current, _ended
    if _current is not None:
        _ended += 1
        _current.job.kill()
        _current.job.remove_folder()
        _current = None
