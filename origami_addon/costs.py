"""What a step costs: processor time, memory, and bytes read and written, of this process and of its children."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Literal

_OWN = Path("/proc/self")


class Costs:
    """The costs since the object was created, of this process and of the children that have ended since.

    What a system does not report is None: Windows reports nothing about children that have ended, and only Linux counts
    bytes.
    """

    def __init__(self) -> None:
        self._cpu = _cpu_seconds()
        self._moved = _bytes_moved()
        self._children = _resident_mb("children")
        # Linux can reset this process's own peak; elsewhere it is the peak since the process started.
        with suppress(OSError):
            (_OWN / "clear_refs").write_text("5", encoding="ascii")

    def figures(self) -> dict[str, float | int | None]:
        """The costs by their names in the report.

        ``cpu_seconds`` is of all threads. ``peak_memory_mb`` is that of the largest process. ``read_bytes`` and
        ``written_bytes`` went through the system's calls, whether a disk or the cache served them.
        """
        now, moved = _cpu_seconds(), _bytes_moved()
        return {
            "cpu_seconds": None if now is None or self._cpu is None else round(now - self._cpu, 3),
            "peak_memory_mb": self._peak_mb(),
            "read_bytes": None if moved is None or self._moved is None else moved[0] - self._moved[0],
            "written_bytes": None if moved is None or self._moved is None else moved[1] - self._moved[1],
        }

    def _peak_mb(self) -> int | None:
        own, children = _resident_mb("self"), _resident_mb("children")
        if own is None or children is None:
            return None
        return max(own, children if children != self._children else 0)


def _cpu_seconds() -> float | None:
    if sys.platform == "win32":
        return None
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def _bytes_moved() -> tuple[int, int] | None:
    """Bytes read and written since the process started."""
    try:
        counted = dict(line.split(": ") for line in (_OWN / "io").read_text(encoding="ascii").splitlines())
        return int(counted["rchar"]), int(counted["wchar"])
    except (OSError, ValueError, KeyError):
        return None


def _resident_mb(whose: Literal["self", "children"]) -> int | None:
    if whose == "self":
        with suppress(OSError):
            status = (_OWN / "status").read_text(encoding="ascii")
            return int(status.split("VmHWM:")[1].split()[0]) // 1000
    if sys.platform == "win32":
        return None
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF if whose == "self" else resource.RUSAGE_CHILDREN).ru_maxrss
    return int(peak) // (1_000_000 if sys.platform == "darwin" else 1000)
