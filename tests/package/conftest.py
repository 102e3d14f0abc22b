"""The script that builds the extension's zips, and Blender's own tool, as modules."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest


def load(name: str, path: Path) -> ModuleType:
    """A script as a module."""
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def extension(root: Path) -> Any:
    """`.ci/extension.py`."""
    return load("extension_script", root / ".ci" / "extension.py")


@pytest.fixture(scope="session")
def blenders_tool(extension: Any) -> Any:
    """The script behind `blender --command extension`."""
    return load("blender_ext", extension.blender_scripts() / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py")
