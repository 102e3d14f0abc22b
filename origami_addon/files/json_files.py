"""Reads JSON files that may hold anything; refuses endless text, endless nesting, pipes and devices."""

from __future__ import annotations

import errno
import json
import os
import stat
from pathlib import Path
from typing import Any

# A report of three hundred photos has half a megabyte, an outline of twenty thousand corners one.
MOST_BYTES = 1 << 26


def parsed_json(path: Path, most: int = MOST_BYTES) -> Any:
    """The parsed content of a JSON file.

    Raises
    ------
    OSError
        If it cannot be read, or is not a file.
    ValueError
        If it is larger than ``most`` bytes, not JSON, or nests too deep.
    """
    status = path.stat()
    if not stat.S_ISREG(status.st_mode):
        number = errno.EISDIR if stat.S_ISDIR(status.st_mode) else errno.EINVAL
        reason = os.strerror(number) if number == errno.EISDIR else "a pipe or a device, not a file"
        raise OSError(number, reason, str(path))
    if status.st_size > most:
        raise ValueError(f"it has {status.st_size} bytes, and at most {most} are read")
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except RecursionError:
        raise ValueError("it nests too deep") from None
