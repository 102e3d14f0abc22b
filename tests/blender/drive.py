"""Runs inside Blender's window: plays the scenes one after the other and records the results.

blender --enable-event-simulate --python tests/blender/drive.py -- FOLDER [SCENE ...]

FOLDER holds photos in `trifold_letter` and `two_sheets`; it gets `pictures/` and `results.json`.
"""

from __future__ import annotations

import importlib.util
import json
import os
import sys
import time
import traceback
from collections.abc import Generator
from importlib import import_module
from pathlib import Path
from typing import Any

import bpy

HERE = Path(__file__).resolve().parent
SCENES = (
    *("whole_run", "opening", "showing", "looking", "framing", "numbering", "ending", "drawing"),
    *("going_on", "unwrapping"),
    *("picking", "edit_mode", "failing", "elsewhere", "queueing", "folders", "stranger"),  # with documents of their own
)


def load_package(name: str) -> None:
    """This folder as a package, so that its modules can import each other."""
    spec = importlib.util.spec_from_file_location(name, HERE / "__init__.py", submodule_search_locations=[str(HERE)])
    assert spec is not None and spec.loader is not None
    package = importlib.util.module_from_spec(spec)
    sys.modules[name] = package
    spec.loader.exec_module(package)


def play(folder: Path, names: list[str]) -> Generator[float, None, None]:
    """Play all scenes; a failing one does not prevent the next."""
    load_package("window_scenes")
    user = import_module("window_scenes.user").User(folder)
    results: list[dict[str, Any]] = []
    for name in names:
        begun, count, wrong = time.perf_counter(), len(user.shown), ""
        try:
            yield from import_module(f"window_scenes.{name}").scene(user)
        except Exception:
            wrong = traceback.format_exc()
            user.hands.picture(f"failed_{name}")
            yield from user.calm_down()
        seconds = round(time.perf_counter() - begun, 1)
        results.append({"scene": name, "seconds": seconds, "shown": user.shown[count:], "wrong": wrong})
        print(f"{name}: {seconds} s {wrong}", flush=True)
    content = {"scenes": results, "held": user.held.table(), "too_long": user.held.too_long()}
    (folder / "results.json").write_text(json.dumps(content, indent=1), encoding="utf-8")


def main(folder: Path, *names: str) -> None:
    """Start, and quit Blender after the last scene."""
    preferences = bpy.context.preferences
    preferences.view.show_splash = False
    preferences.system.use_region_overlap = False  # the sidebar's pictures must not show what is behind it
    playing = play(folder, list(names) or list(SCENES))

    def go_on() -> float | None:
        try:
            return next(playing)
        except StopIteration:
            pass
        except Exception:
            traceback.print_exc()
        sys.stdout.flush()
        os._exit(0)

    bpy.app.timers.register(go_on, first_interval=1, persistent=True)


if __name__ == "__main__":
    given = sys.argv[sys.argv.index("--") + 1 :]
    main(Path(given[0]), *given[1:])
