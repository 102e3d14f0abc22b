"""What tests of the command line share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from origami.headless.options import build_parser, settings_from
from origami.origami_addon import own_results
from origami.origami_addon.settings import RunSettings

# Whatever a run may write into its folder.
EVERYTHING = ("report.json", "log.txt", "work", "cameras", *own_results.RESULTS)
# What the stand-in for structure from motion says when it comes to it.
USED = "It comes to the structure from motion."


def contents(folder: Path) -> dict[str, bytes]:
    """All files in a folder, those of folders in it too."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def settings_of(*options: str) -> RunSettings:
    """The settings that options select."""
    return settings_from(build_parser().parse_args([*options]))


def said(capsys: pytest.CaptureFixture[str]) -> str:
    """What the command line has said since the last call."""
    return capsys.readouterr().err


def raising(error: BaseException) -> Callable[..., Any]:
    """A function that raises an error, whatever it is called with."""

    def function(*_: object, **__: object) -> None:
        raise error

    return function
