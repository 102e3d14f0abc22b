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


@pytest.fixture(scope="session", params=["half as large", pytest.param("as shipped", marks=pytest.mark.slow)])
def finished_run(
    request: pytest.FixtureRequest, command: ModuleType, example_photos: Path, tmp_path_factory: pytest.TempPathFactory
) -> FinishedRun:
    """The example rectified once, as Letter paper."""
    folder = tmp_path_factory.mktemp("run")
    photos, out = example_photos, folder / "out"
    if request.param == "half as large":
        photos = shrunk(example_photos, folder / "photos", 1000)
    return FinishedRun(photos, out, command.main([str(photos), "-o", str(out), "--paper", "Letter", "-q"]))


@pytest.fixture(scope="session")
def small_photos(example_photos: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example's photos, so small that reading them takes no time."""
    return shrunk(example_photos, tmp_path_factory.mktemp("small") / "photos", 300)


def shrunk(photos: Path, target: Path, longest: int) -> Path:
    """Photos of a folder with at most ``longest`` pixels a side, in a new folder."""
    target.mkdir()
    for path in photos.iterdir():
        with Image.open(path) as photo:
            photo.thumbnail((longest, longest))
            photo.save(target / path.name, quality=95)
    return target


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    """A folder with three small pictures."""
    folder = tmp_path / "photos"
    folder.mkdir()
    for number in range(3):
        Image.new("RGB", (300, 200), (number, 0, 0)).save(folder / f"{number}.png")
    return folder
