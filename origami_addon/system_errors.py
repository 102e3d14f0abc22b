"""The system's errors about files and memory as sentences."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..core.errors import StepFailed, UsageError

_DISK_FULL = (errno.ENOSPC, errno.EDQUOT)
_NAME_UNUSABLE = (errno.ENAMETOOLONG, errno.ELOOP)
_HARDLY_ANY_ROOM = 1 << 24  # bytes
_NO_MEMORY = "Memory ran out; use --threads 1 and a smaller --match-size or --dpi."


@contextmanager
def unwritable_as_failure(out: Path) -> Iterator[None]:
    """Turn the system's errors about the folder for the results into sentences.

    Raises
    ------
    UsageError, StepFailed
    """
    try:
        yield
    except OSError as error:
        if error.errno in _DISK_FULL:
            raise StepFailed(_disk_full(out)) from error
        # not of a folder that exists, which is no error when it is made
        why = "a link there leads nowhere" if isinstance(error, FileExistsError) else error.strerror
        raise UsageError(f"{out} cannot be written ({why}); choose another folder for the results.") from error


@contextmanager
def system_errors_as_failures(out: Path | None = None) -> Iterator[None]:
    """Turn the system's errors about files and memory into sentences.

    Raises
    ------
    UsageError, StepFailed
    """
    try:
        yield
    except OSError as error:
        raise _failure(error, out) from error
    except MemoryError as error:
        raise StepFailed(_NO_MEMORY) from error
    except RuntimeError as error:
        if "can't start new thread" not in str(error):
            raise
        raise StepFailed(_NO_MEMORY) from error


def _failure(error: OSError, out: Path | None) -> UsageError | StepFailed:
    if error.errno == errno.ENOMEM:
        return StepFailed(_NO_MEMORY)
    file = None if error.filename is None else str(error.filename)
    # numpy says only how many bytes it could not write
    if error.errno in _DISK_FULL or error.errno is None:
        temporary = Path(tempfile.gettempdir())
        of_out = out is not None and (_hardly_any_room(out) if file is None else _is_in(file, out))
        if not of_out and (_hardly_any_room(temporary) if file is None else _is_in(file, temporary)):
            return StepFailed(
                f"The disk of the folder for temporary files, {temporary}, is full; make room there, or set TMPDIR to "
                "another folder, and run again; the finished steps are kept."
            )
        if out is not None and (of_out or error.errno is not None):
            return StepFailed(_disk_full(out))
    reason = error.strerror or str(error)
    if file is None:
        return StepFailed(f"The system refused something ({reason}); run again.")
    if error.errno in _NAME_UNUSABLE:
        return UsageError(f"{file} cannot be used ({reason}); check the path.")
    return StepFailed(f"{file} could not be used ({reason}); fix that, or choose another folder.")


def _is_in(file: str, folder: Path) -> bool:
    return Path(os.path.realpath(file)).is_relative_to(os.path.realpath(folder))


def _hardly_any_room(folder: Path) -> bool:
    try:
        return shutil.disk_usage(folder).free < _HARDLY_ANY_ROOM
    except OSError:
        return False


def _disk_full(out: Path) -> str:
    return f"The disk of {out} is full; make room there and run again; the finished steps are kept."
