"""The one job that runs at a time, as panels and buttons see it."""

from __future__ import annotations

from dataclasses import dataclass
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
    fraction : float
        0 to 1, of the whole job.
    text : str
        Its current progress text.
    wish : {"stop", "cancel"} or None
        The user's request.
    """

    job: Job
    label: str
    fraction: float = 0.0
    text: str = "Starting"
    wish: Wish | None = None


@dataclass(frozen=True)
class Failure:
    """Why the last job failed, or could not start.

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
_failure: Failure | None = None
_ended = 0


def current() -> Running | None:
    """The running job, if there is one."""
    return _current


def ended() -> int:
    """How many jobs have ended; if the number changes, cached values must be refreshed."""
    return _ended


def failure() -> Failure | None:
    """Why the last job failed; None if it did not, or once another job has started."""
    return _failure


def set_failure(failure: Failure | None) -> None:
    """Store why a job failed, for panels to show, or clear it."""
    global _failure
    _failure = failure


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
