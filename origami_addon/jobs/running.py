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


_current: Running | None = None
_ended = 0


def current() -> Running | None:
    """The running job, if there is one."""
    return _current


def ended() -> int:
    """How many jobs have ended: a sign to look again at what may have changed since."""
    return _ended


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
