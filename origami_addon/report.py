"""The report of a run: report.json with figures, times and warnings."""

from __future__ import annotations

import hashlib
import json
import logging
import math
import platform
import time
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import bpy

from .costs import Costs
from .files.atomic import replacing
from .files.content_hash import sha256_of

ROOT = Path(__file__).resolve().parent.parent
MANIFEST = ROOT / "blender_manifest.toml"

log = logging.getLogger("origami")


@dataclass
class Report:
    """Collects the content of the report during a run.

    Attributes
    ----------
    settings : dict
        As JSON.
    inputs : list of dict
        One for each photo, and for each file of a COLMAP model.
    stages : list of dict
        One for each step, in order: name, seconds, costs (see `Costs`), figures, warnings.
    warnings : list of str
        Of all steps.
    tried : list of dict
        If a step's result was not plausible: each way that was tried, in order. ``way`` describes it in words and
        ``taken`` says whether it was kept; failed ones also have ``stage``, ``gate`` (what was measured), ``figure``,
        ``limit`` and ``cause``. Empty if the first way was plausible.
    outputs : dict
        Maps file names in the output folder to size and hash.
    number : str
        Of the folder of the results, as in its marker.
    sheets : list of dict
        In a run of every sheet, one entry for each: ``folder``, which has its own report, and ``failure``, the error
        message or None.
    stopped_after : str
        The step after which the run was asked to stop, as the report names it; empty for a run to the end.
    """

    settings: dict[str, Any]
    inputs: list[dict[str, Any]] = field(default_factory=list)
    stages: list[dict[str, Any]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    tried: list[dict[str, Any]] = field(default_factory=list)
    outputs: dict[str, dict[str, Any]] = field(default_factory=dict)
    number: str = ""
    sheets: list[dict[str, Any]] = field(default_factory=list)
    stopped_after: str = ""
    started: float = field(default_factory=time.time)

    @contextmanager
    def stage(self, name: str) -> Iterator[dict[str, Any]]:
        """Time a step; the block receives a dict for its figures."""
        figures: dict[str, Any] = {}
        begun, costs, warned = time.perf_counter(), Costs(), len(self.warnings)
        log.info("%s ...", name)
        yield figures
        seconds = round(time.perf_counter() - begun, 3)
        stage = {"name": name, "seconds": seconds, **costs.figures()}
        self.stages.append(stage | {"figures": figures, "warnings": self.warnings[warned:]})
        log.info("%s: %.1f s, %s", name, seconds, json.dumps(plain(figures), ensure_ascii=False))

    def warn(self, *sentences: str) -> None:
        """Note something that the user should know although the run continues."""
        for sentence in sentences:
            if sentence not in self.warnings:
                self.warnings.append(sentence)
                log.warning(sentence)

    def mark(self) -> tuple[int, int]:
        """The number of stages and warnings, for `since` and `forget`."""
        return len(self.stages), len(self.warnings)

    def since(self, mark: tuple[int, int]) -> Report:
        """The stages and warnings after a mark."""
        return Report(self.settings, stages=self.stages[mark[0] :], warnings=self.warnings[mark[1] :])

    def forget(self, mark: tuple[int, int]) -> None:
        """Drop the stages and warnings after a mark, because their results were not kept."""
        del self.stages[mark[0] :]
        del self.warnings[mark[1] :]

    def add_output(self, out: Path, name: str) -> None:
        """Note a file that the run has written into its folder."""
        path = out / name
        self.outputs[name] = {"bytes": path.stat().st_size, "sha256": sha256_of(path)}

    def write(self, path: Path) -> None:
        """Write the report atomically: if this file exists, the run has finished."""
        content = {
            "versions": versions(),
            "number": self.number,
            "started": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(self.started)),
            "seconds": round(time.time() - self.started, 1),
            "inputs": self.inputs,
            "settings": self.settings,
            "stages": self.stages,
            "warnings": self.warnings,
            "tried": self.tried,
            "outputs": self.outputs,
        }
        if self.sheets:
            content["sheets"] = self.sheets
        if self.stopped_after:
            content["stopped_after"] = self.stopped_after
        with replacing(path) as unfinished:
            text = json.dumps(plain(content), indent=2, ensure_ascii=False, allow_nan=False)
            unfinished.write_text(text + "\n", encoding="utf-8")


def version() -> str:
    """The version of Origami, from the manifest."""
    with MANIFEST.open("rb") as file:
        return str(tomllib.load(file)["version"])


def versions() -> dict[str, str]:
    """Versions of everything that a result depends on; "missing" for a package that is not installed."""
    found = {
        "origami": version(),
        "code": _code(),
        "blender": bpy.app.version_string,
        "python": platform.python_version(),
        "system": platform.platform(),
    }
    for package in ("numpy", "scipy", "pycolmap"):
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "missing"
    return found


@cache
def _code() -> str:
    """Hash of all sources that a run uses."""
    return hash_of(sorted(path for folder in ("core", "origami_addon") for path in (ROOT / folder).rglob("*.py")))


def hash_of(paths: Sequence[Path]) -> str:
    """Hash of the content of several files, hexadecimal."""
    digest = hashlib.sha256()
    for path in paths:
        digest.update(path.read_bytes())
    return digest.hexdigest()


def plain(value: Any) -> Any:
    """``value`` in a form for JSON: numpy's numbers and arrays as plain ones, non-finite numbers as null.

    What is not text in a file's name is escaped.
    """
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, str):
        return value.encode(errors="backslashreplace").decode()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
