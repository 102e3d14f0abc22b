"""Loads the checkout that contains this file; scripts outside the package run it."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

# Threads of the libraries under numpy wait by spinning: on two busy cores, tests of the outline took over ten minutes
# with them and one without. What Origami computes in threads, it computes in its own.
os.environ.setdefault("OMP_NUM_THREADS", "1")


class OtherPackage(ImportError):
    """Another package `origami` is loaded; the message is a sentence."""


def load_checkout() -> None:
    """Make the checkout importable as `origami`, unless it is already.

    Raises
    ------
    OtherPackage
    """
    loaded = sys.modules.get("origami")
    if loaded is not None:
        place = Path(loaded.__file__ or "").resolve()
        if place != ROOT / "__init__.py":
            raise OtherPackage(
                f"This Python has already loaded another package origami, {place}; run {ROOT} in a Python of its own."
            )
        return
    spec = importlib.util.spec_from_file_location(
        "origami", ROOT / "__init__.py", submodule_search_locations=[str(ROOT)]
    )
    assert spec is not None and spec.loader is not None
    package = importlib.util.module_from_spec(spec)
    sys.modules["origami"] = package
    spec.loader.exec_module(package)
