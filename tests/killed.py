"""Processes that end while they change a folder."""

from __future__ import annotations

import itertools
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


class Killed(BaseException):
    """The process ends here, as far as Origami knows."""


def killed_after(calls: int, monkeypatch: pytest.MonkeyPatch, *methods: str) -> Callable[[], bool]:
    """Let the process end before one of the calls that move and remove files.

    Parameters
    ----------
    calls : int
        How many of the calls it survives.
    monkeypatch : MonkeyPatch
    methods : str
        Methods of `Path` whose calls count too.

    Returns
    -------
    callable
        Says whether it came to that.
    """
    counter, reached = itertools.count(), []

    def counted(function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            if next(counter) == calls:
                reached.append(True)
                raise Killed
            return function(*arguments, **options)

        return call

    for name in ("unlink", *methods):
        monkeypatch.setattr(Path, name, counted(getattr(Path, name)))
    monkeypatch.setattr(os, "replace", counted(os.replace))
    monkeypatch.setattr(shutil, "rmtree", counted(shutil.rmtree))
    return lambda: bool(reached)
