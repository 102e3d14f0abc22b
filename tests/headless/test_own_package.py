"""The script runs the checkout or extension that contains it, whatever else is installed or loaded."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

_OLDER = """
import bpy

class Older(bpy.types.PropertyGroup):
    pass

def register():
    bpy.utils.register_class(Older)
    bpy.types.Collection.origami = bpy.props.PointerProperty(type=Older)

def unregister():
    del bpy.types.Collection.origami
    bpy.utils.unregister_class(Older)
"""
# Enable the extension, load the script's own package, and use a property that the older one lacks.
_RUN = """
import bpy, addon_utils, runpy, sys
assert addon_utils.enable("bl_ext.user_default.origami", default_set=True)
module = runpy.run_path(sys.argv[1])["module"]
command = module("headless.command")
command.start_empty()
print(command.__name__, bpy.data.collections.new("page").origami.settings.surface.grid_rows)
assert module("headless.command") is command
"""
_OTHER_LOADED = """
import runpy, sys, types
sys.modules["origami"] = types.ModuleType("origami")
sys.modules["origami"].__file__ = "/elsewhere/origami/__init__.py"
sys.exit(runpy.run_path(sys.argv[1])["main"](["--version"]))
"""


@pytest.fixture
def extension(tmp_path: Path) -> Path:
    """Where Blender looks for the extension; nothing is there yet."""
    folder = tmp_path / "extensions" / "user_default" / "origami"
    folder.parent.mkdir(parents=True)
    return folder


def _python(code: str, root: Path, resources: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code, str(root / "headless" / "rectify.py")],
        env=os.environ | {"BLENDER_USER_RESOURCES": str(resources)},
        capture_output=True,
        text=True,
    )


def test_an_older_extension_that_is_enabled_gives_way(root: Path, tmp_path: Path, extension: Path) -> None:
    extension.mkdir()
    (extension / "__init__.py").write_text(_OLDER)
    done = _python(_RUN, root, tmp_path)
    assert done.stdout.splitlines()[-1:] == ["origami.headless.command 85"], done.stdout + done.stderr


def test_the_extension_itself_runs_under_its_own_name(root: Path, tmp_path: Path, extension: Path) -> None:
    extension.symlink_to(root)
    done = _python(_RUN, root, tmp_path)
    name = "bl_ext.user_default.origami.headless.command"
    assert done.stdout.splitlines()[-1:] == [f"{name} 85"], done.stdout + done.stderr


def test_another_package_of_the_name_is_reported_in_a_sentence(root: Path, tmp_path: Path) -> None:
    done = _python(_OTHER_LOADED, root, tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: This Python has already loaded another package origami, /elsewhere")
    assert done.stderr.count("\n") == 1
