"""The project's manifest, checked by Blender's own tool."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest


@pytest.fixture
def extension_tool() -> Path:
    """The script behind `blender --command extension`."""
    import bpy

    return next(Path(bpy.utils.resource_path("LOCAL")).rglob("bl_pkg/cli/blender_ext.py"))


def test_blender_accepts_the_manifest(root: Path, extension_tool: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(extension_tool), "validate", str(root)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_changelog_has_the_version(root: Path) -> None:
    version = tomllib.loads((root / "blender_manifest.toml").read_text(encoding="utf-8"))["version"]
    assert f"\n## {version}" in (root / "CHANGELOG.md").read_text(encoding="utf-8")
