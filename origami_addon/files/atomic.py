"""Writes files that are either complete or absent, even if the power fails."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ...core.errors import StepFailed

# How the names of temporary folders begin.
WRITING = ".writing-"
_ROOM = 1 << 20  # bytes that must be left on the disk; a choice


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A path to write to; the file replaces `path` if the block succeeds.

    The path has the same file name, in a temporary folder beside the target. Other files written there, such as the
    material of an OBJ, are moved with it.

    Raises
    ------
    StepFailed
        If it could not be written: no room, no permission, a folder in its place.
    """
    folder = None
    try:
        folder = Path(tempfile.mkdtemp(prefix=WRITING, dir=path.parent))
        yield folder / path.name
        if not (folder / path.name).is_file() or (folder / path.name).stat().st_size == 0:
            raise OSError("nothing was written")
        # On a full disk Blender truncates a file without an error; then there is no room for this either.
        with tempfile.TemporaryFile(dir=path.parent) as probe:
            probe.write(bytes(_ROOM))
        for written in folder.iterdir():
            _sync(written)
            os.replace(written, path.parent / written.name)
        sync_folder(path.parent)
    except (OSError, RuntimeError) as error:  # Blender's operators and image writer raise RuntimeError
        raise StepFailed(
            f"{path.name} could not be written ({_reason(error)}): "
            f"make room in {path.parent} or choose another output folder."
        ) from error
    finally:
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)


def write_text_at_once(path: Path, text: str) -> None:
    """Write a small text file completely or not at all; a link in its place is replaced, not followed.

    Raises
    ------
    OSError
    """
    unfinished = path.with_name(f"{path.name}-{uuid.uuid4().hex}")
    try:
        with unfinished.open("x", encoding="utf-8") as file:
            file.write(text)
        _sync(unfinished)
        os.replace(unfinished, path)
        sync_folder(path.parent)
    finally:
        unfinished.unlink(missing_ok=True)


def sync_folder(folder: Path) -> None:
    """Have the system write a folder's names to the disk; Windows does so by itself, and some file systems cannot."""
    with suppress(OSError):
        file = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(file)
        finally:
            os.close(file)


def _sync(path: Path) -> None:
    """Have the system write a file's content to the disk, before the file gets the name under which it is looked for.

    Raises
    ------
    OSError
    """
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def _reason(error: OSError | RuntimeError) -> str:
    """Why Python or Blender could not write, in one line: Blender's text may contain a whole traceback."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    full = os.strerror(errno.ENOSPC)
    return full if full in str(error) else str(error).removeprefix("Error: ").split("\n")[0].strip()
