"""The command line and its script as modules, and one finished run of the example for all tests here."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest
from command_line import USED
from origami.core.errors import StepFailed
from origami.origami_addon import run
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


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with three photos."""
    folder = tmp_path_factory.mktemp("good")
    for number in range(3):
        Image.new("RGB", (160, 120), (number, 0, 0)).save(folder / f"{number}.png")
    return folder


@pytest.fixture
def ends(
    command: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str]]:
    """Runs the command up to the structure from motion; returns its exit code and what it says.

    Structure from motion is a stand-in that fails, so an input that is used ends with exit code 5 and its sentence.
    """

    def place(*_: object) -> None:
        raise StepFailed(USED)

    monkeypatch.setattr(run.steps, "place_photos", place)
    monkeypatch.setattr(command, "start_empty", lambda: None)

    def rectify(*arguments: object) -> tuple[int, str]:
        code = command.main([*map(str, arguments), "-q"])
        said = capsys.readouterr().err
        assert code != 3, said
        assert "Traceback" not in said
        assert code == 0 or said.endswith(".\n") or "usage:" in said, said
        return code, said

    return rectify
