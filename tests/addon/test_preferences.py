"""The add-on's preferences: they say what is missing, and can clear kept results."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest


@pytest.fixture
def work(tmp_path, monkeypatch) -> Path:
    """A work folder with 3000 bytes in it."""
    from origami.origami_addon import work_folder

    folder = tmp_path / "work"
    (folder / "model" / "0").mkdir(parents=True)
    (folder / "model" / "0" / "points3D.bin").write_bytes(bytes(2000))
    (folder / "sheet-0123.npz").write_bytes(bytes(1000))
    monkeypatch.setattr(work_folder, "work_folder", lambda: folder)
    return folder


class Layout:
    """Records what is drawn."""

    def __init__(self, said: list[str]) -> None:
        self.said = said

    def label(self, text: str = "", icon: str = "") -> None:
        self.said.append(f"{icon} {text}")

    def operator(self, name: str, text: str = "", icon: str = "") -> None:
        self.said.append(name)

    def row(self) -> Layout:
        return self


def drawn() -> list[str]:
    from origami.origami_addon.preferences import OrigamiPreferences

    said: list[str] = []
    OrigamiPreferences.draw(SimpleNamespace(layout=Layout(said)), None)
    return said


def test_what_is_installed_is_listed_with_its_version(add_on):
    import scipy

    said = drawn()
    assert f"CHECKMARK scipy {scipy.__version__}" in said
    assert any(line.startswith("CHECKMARK pycolmap ") for line in said)
    assert "origami.clear_work" in said


def test_what_is_missing_is_reported(add_on, monkeypatch):
    from origami.origami_addon import dependencies

    found = dependencies.metadata.version

    def version(package: str) -> str:
        if package == "pycolmap":
            raise dependencies.metadata.PackageNotFoundError
        return found(package)

    monkeypatch.setattr(dependencies.metadata, "version", version)
    said = drawn()
    assert "ERROR There is no pycolmap for this system" in said
    assert any(line.startswith("BLANK1 Use an existing COLMAP model") for line in said)
    assert any(line.startswith("CHECKMARK scipy ") for line in said)


WITHOUT_SCIPY = """
import importlib.metadata, importlib.util, pathlib, sys

found = importlib.metadata.version

def version(package):
    if package == "scipy":
        raise importlib.metadata.PackageNotFoundError
    return found(package)

importlib.metadata.version = version
sys.modules["scipy"] = None
root = pathlib.Path(sys.argv[1])
spec = importlib.util.spec_from_file_location("origami", root / "__init__.py", submodule_search_locations=[str(root)])
sys.modules["origami"] = package = importlib.util.module_from_spec(spec)
spec.loader.exec_module(package)
import bpy

def state():
    preferences = bpy.types.AddonPreferences.bl_rna_get_subclass_py("OrigamiPreferences")
    return preferences is not None, bool(dir(bpy.ops.origami)), hasattr(bpy.types.Scene, "origami")

package.register()
there = state()
package.unregister()
print(there, state())
"""


def test_without_scipy_the_preferences_are_there_to_say_so(root):
    done = subprocess.run([sys.executable, "-c", WITHOUT_SCIPY, str(root)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "(True, False, False) (False, False, False)"


def test_kept_results_are_measured_and_cleared(add_on, work):
    import bpy
    from origami.origami_addon.work_folder import kept_bytes

    assert kept_bytes() == 3000
    assert bpy.ops.origami.clear_work() == {"FINISHED"}
    assert work.is_dir() and not list(work.iterdir())
    assert kept_bytes() == 0
    assert bpy.ops.origami.clear_work() == {"FINISHED"}


def test_nothing_is_cleared_while_a_job_runs(add_on, work):
    import bpy
    from origami.origami_addon.jobs import running

    job = SimpleNamespace(kill=lambda: None, remove_folder=lambda: None)
    running.begin(running.Running(job, "Rectify Photos"))
    try:
        with pytest.raises(RuntimeError, match="A job is running"):
            bpy.ops.origami.clear_work()
    finally:
        running.end()
    assert (work / "sheet-0123.npz").exists()


def test_what_cannot_be_cleared_is_reported(add_on, work, monkeypatch):
    import bpy
    from origami.origami_addon import work_folder

    def in_use(path: Path) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(work_folder.shutil, "rmtree", in_use)
    with pytest.raises(RuntimeError, match=r"model in .* could not be removed"):
        bpy.ops.origami.clear_work()
