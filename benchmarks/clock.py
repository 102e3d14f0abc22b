"""Seconds of the steps, of which methods share some."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..origami_addon.files.kept import Arrays, kept, kept_as
from .tables import Row


class Clock:
    """Seconds that each of the steps' kept results took to compute; whoever finds one kept is charged the same."""

    def __init__(self) -> None:
        self._seconds: dict[Path, float] = {}
        self._charged: dict[str, float] = {}

    def kept(
        self,
        folder: Path,
        name: str,
        key: str,
        compute: Callable[[], tuple[Arrays, dict[str, Any]]],
        warn: Callable[[str], None],
    ) -> tuple[Arrays, dict[str, Any]]:
        """`kept` of the steps, timed."""
        begun = time.perf_counter()
        result = kept(folder, name, key, compute, warn)
        seconds = time.perf_counter() - begun
        (file,) = folder.glob(f"{kept_as(name, key)}-*.npz")
        self._seconds.setdefault(file, seconds)
        self._charged[name] = self._seconds[file]
        return result

    def share(self, file: Path, folder: Path) -> None:
        """Put a kept result into another folder too."""
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, folder)
        self._seconds[folder / file.name] = self._seconds[file]

    def charge(self, name: str, seconds: float) -> None:
        """Count what was computed without the steps."""
        self._charged[name] = seconds

    def take(self) -> Row:
        """``NAME seconds`` of what was asked for since the last call."""
        charged, self._charged = self._charged, {}
        return {f"{name} seconds": seconds for name, seconds in charged.items()}
