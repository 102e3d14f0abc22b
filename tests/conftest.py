"""Loads the checkout as the package `origami`, and isolates Blender from the user's own settings."""

from __future__ import annotations

import os
import runpy
import sys
import tempfile
from collections.abc import Generator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

# Before anything imports bpy, which reads this once; inside a Blender, its caller has chosen.
if "bpy" not in sys.modules:
    _blender_resources = tempfile.TemporaryDirectory(prefix="origami-blender-")
    os.environ["BLENDER_USER_RESOURCES"] = _blender_resources.name


runpy.run_path(str(ROOT / "headless" / "checkout.py"))["load_checkout"]()


@pytest.fixture(scope="session")
def root() -> Path:
    """The checkout."""
    return ROOT


@pytest.fixture(scope="session")
def example_photos(root: Path) -> Path:
    """The folder of photos that ships with the project."""
    return root / "examples" / "trifold_letter"


@pytest.fixture
def empty_scene() -> None:
    """A Blender file with nothing in it."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Escape halves of characters in what a test said: names of files may have them, reports of workers must not."""
    report = yield
    report.sections = [(title, text.encode(errors="backslashreplace").decode()) for title, text in report.sections]
    return report
