"""Photos of a sheet of paper in, the flat page out: Origami without a window.

blender -b --factory-startup --python-exit-code 3 -P headless/rectify.py -- PHOTOS -o OUT
.venv/bin/python headless/rectify.py PHOTOS -o OUT

This file only finds Origami; `command.py` beside it is the command.
"""

from __future__ import annotations

import importlib
import os
import runpy
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

INTERNAL_ERROR, USAGE_ERROR = 3, 2
ROOT = Path(__file__).resolve().parent.parent
DEPENDENCIES = ("bpy", "numpy", "scipy", "pycolmap")
CHECKOUT = runpy.run_path(str(Path(__file__).with_name("checkout.py")))


def origami() -> str:
    """Load the Origami that contains this file and return the name it is loaded under.

    That is the extension's name if this is an enabled extension, and `origami` otherwise. An enabled extension
    elsewhere, perhaps of another version, is then disabled for this session: both register the same properties.
    """
    import bpy

    for addon in bpy.context.preferences.addons.keys():  # noqa: SIM118 - Blender's collection, not a dict
        loaded = sys.modules.get(addon)
        if loaded is None or not (addon.startswith("bl_ext.") and addon.endswith(".origami")):
            continue
        if Path(loaded.__file__ or "").resolve().parent == ROOT:
            return str(addon)
        import addon_utils  # which `import bpy` brings

        if addon_utils.check(addon)[1]:
            addon_utils.disable(addon)
    CHECKOUT["load_checkout"]()
    return "origami"


def module(name: str) -> ModuleType:
    """A module of this Origami, by its name inside the package."""
    return importlib.import_module(f"{origami()}.{name}")


def main(argv: Sequence[str]) -> int:
    """Run with the given arguments and return the exit code; never raises."""
    try:
        command = module("headless.command")
    except Exception as error:
        if isinstance(error, ImportError) and (error.name or "").partition(".")[0] in DEPENDENCIES:
            print(
                f"This Python cannot load {error.name} ({error}); run `make demo` once, which makes .venv, and then "
                ".venv/bin/python headless/rectify.py; or install the extension in Blender, which brings it.",
                file=sys.stderr,
            )
            return USAGE_ERROR
        if isinstance(error, CHECKOUT["OtherPackage"]):
            print(f"error: {error}", file=sys.stderr)
            return USAGE_ERROR
        print(f"internal error: {type(error).__name__}: {error}; please report it", file=sys.stderr)
        return INTERNAL_ERROR
    return int(command.main(argv))


def command_line() -> list[str]:
    """The arguments meant for this script: under Blender those after ``--``."""
    if os.path.basename(sys.argv[0]) == Path(__file__).name:
        return sys.argv[1:]
    return sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []


def open_standard_streams() -> None:
    """Open what the caller has closed of stdin, stdout and stderr.

    The next files that are opened would otherwise take their places, and receive what Blender prints.
    """
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free, which is this one
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, mode, encoding="utf-8", closefd=False))


if __name__ == "__main__":
    open_standard_streams()
    sys.exit(main(command_line()))
