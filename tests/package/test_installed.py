"""The zip for this platform and Python, installed into a temporary Blender that has neither scipy nor pycolmap."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import photo_scene
import pytest

pytestmark = pytest.mark.download


@dataclass(frozen=True)
class Blender:
    """Blender as a Python module, with its own settings, in a Python with only Blender's own packages."""

    packages: Path
    resources: Path

    def run(self, *arguments: object) -> subprocess.CompletedProcess[str]:
        """Run a script; `-S` leaves out the environment's packages."""
        return subprocess.run(
            [sys.executable, "-S", *map(str, arguments)],
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONPATH": str(self.packages), "BLENDER_USER_RESOURCES": str(self.resources)},
        )

    def install(self, archive: Path, *options: str) -> dict[str, Any]:
        """The output of `in_blender.py`."""
        done = self.run(Path(__file__).with_name("in_blender.py"), "--", archive, *options)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "Traceback" not in done.stderr, done.stderr  # of errors that Blender catches during registration
        states: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
        return states


@pytest.fixture(scope="module")
def archive(root: Path, extension: Any, blenders_tool: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The zip, just built."""
    target = extension.Target(blenders_tool.platform_from_this_system(), "{}.{}".format(*sys.version_info))
    assert target in extension.TARGETS
    wheels = [wheel for wheel in extension.pinned_wheels() if wheel.fits(target)]
    extension.fetch(wheels, root / "wheels")
    path: Path = extension.build(root, target, wheels, tmp_path_factory.mktemp("dist"))
    return path


@pytest.fixture
def blender(tmp_path: Path) -> Blender:
    packages = tmp_path / "packages"
    packages.mkdir()
    for path in Path(sysconfig.get_path("purelib")).iterdir():
        if not path.name.startswith(("scipy", "pycolmap")):
            (packages / path.name).symlink_to(path)
    resources = tmp_path / "resources"
    resources.mkdir()
    return Blender(packages, resources)


def test_comes_and_goes(blender: Blender, archive: Path) -> None:
    states = blender.install(archive)
    before, removed = states["before"], states["removed"]
    assert before["packages"]["scipy"] is None
    assert before["packages"]["pycolmap"] is None
    for name in ("installed", "enabled again"):
        state = states[name]
        assert state["enabled"]
        extensions = blender.resources / "extensions"
        assert Path(state["module"]) == extensions / "user_default" / "origami" / "__init__.py"
        for package in ("scipy", "pycolmap"):
            assert extensions / ".local" in Path(state["packages"][package]).parents
        assert state["packages"]["numpy"] == before["packages"]["numpy"]
        assert Path(state["manual page"]) == extensions / "user_default" / "origami" / "docs" / "quick_start.html"
    assert states["installed"]["registered"] == states["enabled again"]["registered"]
    for state in (states["disabled"], removed):
        assert not state["enabled"]
        assert state["registered"] == before["registered"]
        assert state["packages"] == before["packages"]
        assert state["manual page"] is None
    assert not [name for name in states["left behind"] if not name.startswith(".cache/")]


def test_rectifies(blender: Blender, archive: Path, tmp_path: Path) -> None:
    blender.install(archive, "keep")
    photo_scene.photo_set(tmp_path / "photos")
    out = tmp_path / "out"
    script = blender.resources / "extensions" / "user_default" / "origami" / "headless" / "rectify.py"
    done = blender.run(script, tmp_path / "photos", "-o", out)
    assert done.returncode == 0, done.stdout + done.stderr
    versions = json.loads((out / "report.json").read_text(encoding="utf-8"))["versions"]
    assert {f"{name}-{versions[name]}" for name in ("scipy", "pycolmap")} == {
        "-".join(path.name.split("-")[:2]) for path in (script.parent.parent / "wheels").iterdir()
    }
