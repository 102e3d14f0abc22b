"""The one job that runs at a time, as panels and buttons see it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from .process import Job

Wish = Literal["stop", "cancel"]


@dataclass
class Running:
    """A job on its way.

    Attributes
    ----------
    job : Job
    label : str
        What is being done, for the user.
    fraction : float
        0 to 1, of the whole job.
    text : str
        What it is at.
    wish : {"stop", "cancel"} or None
        What the user wants of it.
    """

    job: Job
    label: str
    fraction: float = 0.0
    text: str = "Starting"
    wish: Wish | None = None


@dataclass(frozen=True)
class Failure:
    """Why the last job failed, or could not begin.

    Attributes
    ----------
    document : str
        Name of the document that it worked on; empty for none.
    sentence : str
    warnings : tuple of str
        What it had warned of before: often the reason.
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
    """How many jobs have ended: a sign to look again at what may have changed since."""
    return _ended


def failure() -> Failure | None:
    """Why the last job failed; None once another one was begun, or if it did not."""
    return _failure


def set_failure(failure: Failure | None) -> None:
    """Keep why a job failed for panels to show, or forget it."""
    global _failure
    _failure = failure


def begin(running: Running) -> None:
    """Note that a job runs."""
    global _current
    _current = running


def end() -> None:
    """End the job that runs, if there is one, and forget it."""
    global _current, _ended
    if _current is not None:
        _ended += 1
        _current.job.kill()
        _current.job.remove_folder()
        _current = None
