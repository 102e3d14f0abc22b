"""A child process that reports in lines of JSON: start it, read its messages without waiting, end it at once.

It exits when its standard input is closed, so it never outlives the process that started it.
"""

from __future__ import annotations

import json
import os
import queue
import subprocess
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any


class ChildProcess:
    """A process that has just been started.

    Parameters
    ----------
    command : sequence of str
    log : Path
        Receives its stderr.
    environment : dict of str, optional
        Added to that of this process.

    Raises
    ------
    OSError
    """

    def __init__(self, command: Sequence[str], log: Path, environment: dict[str, str] | None = None) -> None:
        with open(log, "wb") as errors:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                env=os.environ | {"PYTHONUTF8": "1"} | (environment or {}),
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )
        self.code: int | None = None
        self._lines: queue.Queue[bytes | None] = queue.Queue()
        threading.Thread(target=self._pass_on, daemon=True).start()

    def messages(self, wait: float = 0.0) -> Iterator[dict[str, Any]]:
        """Its messages since the last call; after the last message and its end, `code` is its exit code.

        Parameters
        ----------
        wait : float
            Seconds to wait for the first message.
        """
        while self.code is None:
            try:
                line = self._lines.get(timeout=wait) if wait else self._lines.get_nowait()
            except queue.Empty:
                return
            if line is None:
                self.code = self._process.wait()
            elif (message := _message(line)) is not None:
                wait = 0.0
                yield message

    def end(self) -> int:
        """End it, and any processes that it started, unless it has ended already; returns its exit code."""
        self._process.kill()
        self.code = self._process.wait()
        assert self._process.stdin is not None
        self._process.stdin.close()
        return self.code

    def _pass_on(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as stream:
            for line in stream:
                self._lines.put(line)
        self._lines.put(None)


def _message(line: bytes) -> dict[str, Any] | None:
    """A line as JSON; None if a library in the process printed it."""
    try:
        message = json.loads(line)
    except ValueError:
        return None
    return message if isinstance(message, dict) else None
