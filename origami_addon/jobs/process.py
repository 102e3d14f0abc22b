"""A job as seen from the window: started, followed without waiting, ended at once."""

from __future__ import annotations

import json
import os
import queue
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core import errors
from ...core.errors import OrigamiError, StepFailed

SCRIPT = Path(__file__).resolve().parents[2] / "headless" / "job.py"
REQUEST, GIVEN, RESULT, LOG = "request.json", "given.npz", "{stage}.npz", "log.txt"
_SAID_LAST = 300  # characters of what a job printed before it ended, for the error


class Job:
    """One job and the folder that it writes into.

    Parameters
    ----------
    request : dict
        What is to be done, as `worker.main` reads it.
    given : mapping of arrays
        What the job starts from.
    """

    def __init__(self, request: Mapping[str, Any], given: Mapping[str, NDArray[Any]]) -> None:
        try:
            self.folder = Path(tempfile.mkdtemp(prefix="origami-job-"))
        except OSError as error:
            raise _not_started(error, "the folder for temporary files") from error
        try:
            np.savez(self.folder / GIVEN, **given)  # type: ignore[arg-type, unused-ignore]
            (self.folder / REQUEST).write_text(json.dumps(request), encoding="utf-8")
        except OSError as error:
            self.remove_folder()
            raise _not_started(error, self.folder.parent) from error
        try:
            self._process = self._start()
        except OSError as error:
            self.remove_folder()
            raise StepFailed(
                f"Blender's background process could not be started ({error.strerror}): start Blender anew if it was "
                "updated or moved meanwhile, and close other programs if memory is short."
            ) from error
        self._lines: queue.Queue[bytes | None] = queue.Queue()
        threading.Thread(target=_pass_on, args=(self._process.stdout, self._lines), daemon=True).start()
        self.ended = False
        self._failure: OrigamiError | None = None

    def _start(self) -> subprocess.Popen[bytes]:
        with open(self.folder / LOG, "wb") as log:
            return subprocess.Popen(
                [*_blender(), str(self.folder)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                env=os.environ | {"PYTHONUTF8": "1"},
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )

    def messages(self, wait: float = 0.0) -> list[dict[str, Any]]:
        """What the job has said since the last call; `ended` is set after its last word.

        Parameters
        ----------
        wait : float
            Seconds to wait for the first message.

        Raises
        ------
        OrigamiError
            What the job failed with, once all that it had said before has been given.
        """
        if self._failure is not None:
            raise self._failure
        said: list[dict[str, Any]] = []
        while not self.ended:
            try:
                line = self._lines.get(timeout=wait) if wait and not said else self._lines.get_nowait()
            except queue.Empty:
                break
            if line is None:
                self._end()
            elif (message := _message(line)) is not None and "error" in message:
                self._failure = _failure(message)
            elif message is not None:
                said.append(message)
            if self._failure is not None:
                if said:
                    break
                raise self._failure
        return said

    def kill(self) -> None:
        """End the job; the worker that it may have started ends with it."""
        self._process.kill()
        self._process.wait()
        assert self._process.stdin is not None
        self._process.stdin.close()
        self.ended = True

    def remove_folder(self) -> None:
        """Remove what the job has written; nothing of it may be in use."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _end(self) -> None:
        self._process.wait()
        if self._process.returncode == 0:
            self.ended = True
        else:
            said = (self.folder / LOG).read_text("utf-8", "replace").strip()[-_SAID_LAST:]
            self._failure = StepFailed(
                f"Blender's background process ended unexpectedly (code {self._process.returncode}), perhaps because "
                f"memory ran out; run again. It said: {said or 'nothing'}"
            )


def _blender() -> list[str]:
    """The command that runs the job's script: this Blender, or this Python where Blender is its module."""
    if not bpy.app.binary_path:
        return [sys.executable, str(SCRIPT)]
    quiet = ["--background", "--factory-startup", "--python-exit-code", "3"]
    return [bpy.app.binary_path, *quiet, "--python", str(SCRIPT), "--"]


def _not_started(error: OSError, where: Path | str) -> StepFailed:
    return StepFailed(f"The work could not be started ({error.strerror}): make room in {where}.")


def _pass_on(stream: IO[bytes], lines: queue.Queue[bytes | None]) -> None:
    for line in stream:
        lines.put(line)
    lines.put(None)
    stream.close()


def _message(line: bytes) -> dict[str, Any] | None:
    """A line of the job's, or None where Blender itself said something."""
    try:
        message = json.loads(line)
    except ValueError:
        return None
    return message if isinstance(message, dict) else None


def _failure(message: Mapping[str, Any]) -> OrigamiError:
    kind = getattr(errors, str(message.get("kind")), StepFailed)
    error = kind(str(message["error"]))
    error.warnings = tuple(message.get("warnings", ()))
    return error
