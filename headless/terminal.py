"""A run and the terminal: progress, Ctrl-C, the log, and no output from Blender.

What cannot be said is left unsaid: a run does not fail because nobody listens.
"""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import signal
import sys
import threading
from collections.abc import Iterator
from typing import TextIO

from ..origami_addon.one_line import OneLine, one_line

_BAR, _TEXT = 30, 60  # letters of the bar and of the text beside it: together they fit into a line of 100


def say(text: str, stream: TextIO | None = None) -> None:
    """Print a line, on stderr unless a stream is given; nothing happens if the stream is closed or its disk full."""
    _put(one_line(text) + "\n", stream or sys.stderr)


def _put(text: str, stream: TextIO) -> None:
    with contextlib.suppress(OSError, ValueError):
        stream.write(text)
        stream.flush()


def keep_quiet_at_exit() -> None:
    """Drop what could not be said, because Python would try again when it exits, and exit with another code."""
    for stream, number in ((sys.stdout, 1), (sys.stderr, 2)):
        try:
            stream.flush()
        except (OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, number)
            os.close(nowhere)


def accept_every_letter() -> None:
    """Escape what the terminal's encoding lacks, instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError, ValueError):  # not a stream of Python's own, or closed
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]


class Progress:
    """How far a run is, on stderr: a bar on a terminal, otherwise a line for each tenth and each new text."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self.is_terminal = stream.isatty()
        self.shown: tuple[int, str] = (-1, "")

    def __call__(self, fraction: float, text: str) -> None:
        percent = int(100 * fraction)
        if (percent, text) == self.shown:
            return
        if self.is_terminal:
            bar = "#" * (percent * _BAR // 100)
            _put(f"\r[{bar:<{_BAR}}] {percent:3d} %  {one_line(text[:_TEXT])}\x1b[K", self.stream)
            self.shown = (percent, text)
        elif text != self.shown[1] or percent // 10 > self.shown[0] // 10:
            say(f"{percent:3d} %  {text}", self.stream)
            self.shown = (percent, text)

    def end(self) -> None:
        """Leave the bar's line."""
        if self.is_terminal and self.shown != (-1, ""):
            _put("\n", self.stream)


@contextlib.contextmanager
def stopping_on_signal() -> Iterator[threading.Event]:
    """An event that the first Ctrl-C (or a polite kill) sets; a second Ctrl-C ends the process where it stands."""
    stop = threading.Event()

    def note(number: int, _frame: object) -> None:
        stop.set()
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler if handler is not None else signal.SIG_DFL)


@contextlib.contextmanager
def log_on_screen(verbose: bool, stream: TextIO) -> Iterator[None]:
    """With ``verbose``, print on the screen what goes into log.txt."""
    if not verbose:
        yield
        return
    handler = logging.StreamHandler(stream)
    handler.setFormatter(OneLine("%(message)s"))
    logger = logging.getLogger("origami")
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)


@contextlib.contextmanager
def without_blenders_chatter() -> Iterator[None]:
    """Keep the output of Blender and its exporters off stdout; they bypass `sys.stdout`."""
    _put("", sys.stdout)
    stdout = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        _put("", sys.stdout)
        with contextlib.suppress(OSError, TypeError, AttributeError):  # Windows has no such handle, and buffers no line
            ctypes.CDLL(None).fflush(None)
        os.dup2(stdout, 1)
        os.close(stdout)
        os.close(nowhere)
