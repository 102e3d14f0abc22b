"""The command line and its script as modules, and one finished run of the example for all tests here."""

from __future__ import annotations

import importlib
import importlib.util
from pathlib import Path
from types import ModuleType

import pytest
from PIL import Image
from run_once import FinishedRun


@pytest.fixture(scope="session")
def command() -> ModuleType:
    """`headless/command.py`."""
    return importlib.import_module("origami.headless.command")


@pytest.fixture(scope="session")
def script(root: Path) -> ModuleType:
    """`headless/rectify.py`."""
    spec = importlib.util.spec_from_file_location("rectify", root / "headless" / "rectify.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def finished_run(command: ModuleType, example_photos: Path, tmp_path_factory: pytest.TempPathFactory) -> FinishedRun:
    """The example rectified once, as Letter paper."""
    out = tmp_path_factory.mktemp("run") / "out"
    return FinishedRun(out, command.main([str(example_photos), "-o", str(out), "--paper", "Letter", "-q"]))


@pytest.fixture(scope="session")
def small_photos(example_photos: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example's photos, so small that reading them takes no time."""
    folder = tmp_path_factory.mktemp("small")
    for path in example_photos.iterdir():
        with Image.open(path) as photo:
            photo.thumbnail((300, 300))
            photo.save(folder / path.name)
    return folder


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    """A folder with three small pictures."""
    folder = tmp_path / "photos"
    folder.mkdir()
    for number in range(3):
        Image.new("RGB", (300, 200), (number, 0, 0)).save(folder / f"{number}.png")
    return folder
