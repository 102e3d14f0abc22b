"""One run at a time in a folder of results.

The system holds the lock and drops it when the process ends, however it ends. The file that is locked says who holds
the lock, and a run that finds it left behind takes it over.
"""

from __future__ import annotations

import errno
import json
import os
import platform
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ...core.errors import UsageError
from .json_files import parsed_json
from .marker import LOCK, foreign, new_number, number_of

_APPLICATION = "Origami"
_LARGEST = 1 << 12  # bytes; a larger file is not one of ours
# Windows forbids others to read the bytes that are locked, so these lie far behind the text.
_LOCKED_BYTE = 1 << 30
_HELD = (errno.EACCES, errno.EAGAIN, errno.EDEADLK)
# Some network folders have no locks; a run there goes on without.
_WITHOUT_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EINVAL)
# Each attempt may meet a file that its holder is just about to remove.
_ATTEMPTS = 20
_UNTIL_NEXT = 0.05  # seconds


@contextmanager
def only_run_in(out: Path) -> Iterator[None]:
    """Hold the lock of a folder of results.

    Raises
    ------
    UsageError
        If another run holds it, or something else has its name.
    OSError
        If the folder cannot be written.
    """
    file = _locked(out)
    try:
        _say_who(file, out)
        yield
    finally:
        if sys.platform == "win32":  # an open file cannot be removed there
            os.close(file)
        with suppress(OSError):  # on Windows the next run may have it open already
            os.unlink(out / LOCK)
        if sys.platform != "win32":
            os.close(file)


def _locked(out: Path) -> int:
    """The lock's file, open and locked."""
    path = out / LOCK
    for attempt in range(_ATTEMPTS):
        file = _opened(out)
        try:
            _lock(file)
            if sys.platform == "win32" or _is_still(file, path):
                return file
        except OSError as error:
            os.close(file)
            if error.errno not in _HELD:
                raise
            if attempt == _ATTEMPTS - 1:
                raise UsageError(
                    f"Another run of Origami writes into {out} ({_who(path)}); wait for its end, or choose another "
                    "folder for the results."
                ) from None
        else:
            os.close(file)
        time.sleep(_UNTIL_NEXT)
    raise UsageError(f"Other runs of Origami begin and end in {out} all the time; choose another folder.")


def _opened(out: Path) -> int:
    """The lock's file, open; a file that is not a lock of Origami's is refused and stays as it is."""
    path = out / LOCK
    with suppress(FileNotFoundError):
        status = path.lstat()
        if not stat.S_ISREG(status.st_mode) or status.st_nlink > 1 or not _is_ours(path, status.st_size):
            raise UsageError(foreign(out, LOCK))
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    return os.open(path, flags, 0o666)


def _is_ours(path: Path, size: int) -> bool:
    """Whether a file is a lock; an empty one is a lock whose holder had not written into it yet."""
    if size == 0:
        return True
    try:
        return bool(parsed_json(path, _LARGEST)["application"] == _APPLICATION)
    except FileNotFoundError:
        return True  # its holder has just removed it
    except (ValueError, KeyError, TypeError):
        return False


def _lock(file: int) -> None:
    """Lock an open file, or raise at once."""
    if sys.platform == "win32":
        import msvcrt

        os.lseek(file, _LOCKED_BYTE, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        return
    import fcntl

    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno not in _WITHOUT_LOCKS:
            raise


def _is_still(file: int, path: Path) -> bool:
    """Whether the open file is the one in the folder: the run before may have removed it meanwhile."""
    try:
        mine, there = os.fstat(file), path.lstat()
    except OSError:
        return False
    return (mine.st_dev, mine.st_ino) == (there.st_dev, there.st_ino)


def _say_who(file: int, out: Path) -> None:
    """Write into the lock who holds it, and the folder's number, which is decided here if it has none yet."""
    content = {
        "application": _APPLICATION,
        "number": number_of(out) or new_number(),
        "process": os.getpid(),
        "computer": platform.node(),
        "since": time.strftime("%Y-%m-%d %H:%M:%S"),
    }
    os.lseek(file, 0, os.SEEK_SET)
    os.ftruncate(file, 0)
    os.write(file, json.dumps(content).encode("ascii"))


def _who(path: Path) -> str:
    try:
        content = parsed_json(path, _LARGEST)
        return f"process {content['process']} on {content['computer']}, since {content['since']}"
    except (OSError, ValueError, KeyError, TypeError):
        return "it has just begun"
