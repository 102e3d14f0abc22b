"""A run and the terminal: progress, Ctrl-C, the log, and no output from Blender."""

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
            bar = "#" * (percent * 30 // 100)
            self.stream.write(f"\r[{bar:<30}] {percent:3d} %  {text[:60]}\x1b[K")
            self.stream.flush()
            self.shown = (percent, text)
        elif text != self.shown[1] or percent // 10 > self.shown[0] // 10:
            print(f"{percent:3d} %  {text}", file=self.stream, flush=True)
            self.shown = (percent, text)

    def end(self) -> None:
        """Leave the bar's line."""
        if self.is_terminal and self.shown != (-1, ""):
            self.stream.write("\n")
            self.stream.flush()


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
    handler.setFormatter(logging.Formatter("%(message)s"))
    logger = logging.getLogger("origami")
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)


@contextlib.contextmanager
def without_blenders_chatter() -> Iterator[None]:
    """Keep the output of Blender and its exporters off stdout; they bypass `sys.stdout`."""
    sys.stdout.flush()
    stdout = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        with contextlib.suppress(OSError, TypeError, AttributeError):  # Windows has no such handle, and buffers no line
            ctypes.CDLL(None).fflush(None)
        os.dup2(stdout, 1)
        os.close(stdout)
        os.close(nowhere)
