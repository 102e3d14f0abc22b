"""How long-running work reports its progress and learns that it should stop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .errors import Cancelled


def _ignore(fraction: float, text: str) -> None:
    pass


def _never() -> bool:
    return False


@dataclass(frozen=True)
class Watch:
    """Passed to every long-running function of the core.

    The fractions that functions report are about the parts of the time that their steps take; nothing else follows from
    them.

    Attributes
    ----------
    progress : callable
        ``progress(fraction, text)``, fraction from 0 to 1.
    cancelled : callable
        ``cancelled()`` is true once the user wants to stop.
    """

    progress: Callable[[float, str], None] = _ignore
    cancelled: Callable[[], bool] = _never

    def step(self, fraction: float, text: str) -> None:
        """Report ``fraction`` and ``text``; call it where it is safe to stop.

        Raises
        ------
        Cancelled
            If the user asked to stop.
        """
        if self.cancelled():
            raise Cancelled("Stopped on request.")
        self.progress(fraction, text)

    def part(self, start: float, end: float) -> Watch:
        """The watch for a sub-task whose 0 to 1 is ``start`` to ``end`` of this one."""
        return Watch(lambda f, text: self.progress(start + f * (end - start), text), self.cancelled)


SILENT = Watch()
