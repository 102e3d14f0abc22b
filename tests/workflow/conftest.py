"""The scripts of the workflow as modules; they import each other by their bare names."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

NAMES = ("options", "documents", "record", "costs", "summary_page", "summary")


@pytest.fixture(scope="session")
def scripts(root: Path) -> Iterator[dict[str, ModuleType]]:
    """Each script by its name."""
    before = {name: sys.modules.pop(name, None) for name in NAMES}
    sys.path.insert(0, str(root / "workflow" / "scripts"))
    yield {name: importlib.import_module(name) for name in NAMES}
    sys.path.remove(str(root / "workflow" / "scripts"))
    for name, module in before.items():
        sys.modules.pop(name, None)
        if module is not None:
            sys.modules[name] = module
