"""A job as the window sees it: start it, read its messages without waiting, end it at once."""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core import errors
from ...core.errors import OrigamiError, StepFailed
from ..child_process import ChildProcess
from .requests import AnyRequest, request_text

SCRIPT = Path(__file__).resolve().parents[2] / "headless" / "job.py"
REQUEST, GIVEN, RESULT, LOG = "request.json", "given.npz", "{stage}.npz", "log.txt"
UNFOLDING = "unfolding.npz"  # the shapes of the sheet on its way to flat
OTHER_PICTURE = "other_light.png"  # the page of other photos
_SAID_LAST = 300  # characters of a failed job's output, for the error message


class Job:
    """One job and the folder into which it writes.

    Parameters
    ----------
    request : AnyRequest
    given : mapping of arrays
        The job's input.
    """

    def __init__(self, request: AnyRequest, given: Mapping[str, NDArray[Any]]) -> None:
        try:
            self.folder = Path(tempfile.mkdtemp(prefix="origami-job-"))
        except OSError as error:
            raise _not_started(error, "the folder for temporary files") from error
        try:
            np.savez(self.folder / GIVEN, **given)  # type: ignore[arg-type, unused-ignore]
            (self.folder / REQUEST).write_text(request_text(request), encoding="utf-8")
        except OSError as error:
            self.remove_folder()
            raise _not_started(error, self.folder.parent) from error
        try:
            self._child = ChildProcess([*_blender(), str(self.folder)], self.folder / LOG)
        except OSError as error:
            self.remove_folder()
            raise StepFailed(
                f"Blender's background process could not be started ({error.strerror}): restart Blender if it was "
                "updated or moved meanwhile, and close other programs if memory is short."
            ) from error
        self.ended = False
        self._failure: OrigamiError | None = None

    def messages(self, wait: float = 0.0) -> list[dict[str, Any]]:
        """The job's messages since the last call; `ended` is set after the last message.

        Parameters
        ----------
        wait : float
            Seconds to wait for the first message.

        Raises
        ------
        OrigamiError
            The job's failure, once all earlier messages have been returned.
        """
        said: list[dict[str, Any]] = []
        if self._failure is None and not self.ended:
            for message in self._child.messages(wait):
                if "error" in message:
                    self._failure = _failure(message)
                    break
                said.append(message)
            else:
                self.ended = self._child.code == 0
                if self._child.code:
                    self._failure = self._crash(self._child.code)
        if self._failure is not None and not said:
            raise self._failure
        return said

    def kill(self) -> None:
        """End the job and any worker that it started."""
        self._child.end()
        self.ended = True

    def remove_folder(self) -> None:
        """Remove the job's files, which must no longer be in use."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _crash(self, code: int) -> StepFailed:
        said = (self.folder / LOG).read_text("utf-8", "replace").strip()[-_SAID_LAST:]
        return StepFailed(
            f"Blender's background process ended unexpectedly (code {code}), perhaps because memory ran out; run "
            f"again. It said: {said or 'nothing'}"
        )


def _blender() -> list[str]:
    """The command that runs the job's script: this Blender, or this Python if Blender is a module of it."""
    if not bpy.app.binary_path:
        return [sys.executable, str(SCRIPT)]
    quiet = ["--background", "--factory-startup", "--python-exit-code", "3"]
    return [bpy.app.binary_path, *quiet, "--python", str(SCRIPT), "--"]


def _not_started(error: OSError, where: Path | str) -> StepFailed:
    return StepFailed(f"The work could not be started ({error.strerror}): make room in {where}.")


def _failure(message: Mapping[str, Any]) -> OrigamiError:
    kind = getattr(errors, str(message.get("kind")), StepFailed)
    failure: OrigamiError = kind(str(message["error"]))
    failure.warnings = tuple(message.get("warnings", ()))
    return failure
