"""The files that the worker leaves behind, each complete or absent."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

import numpy as np


def save(folder: Path, arrays: dict[str, np.ndarray], content: dict[str, Any]) -> None:
    """Write the result: the arrays and, with a hash of both, the content."""
    unfinished = folder / "unfinished.npz"
    np.savez(unfinished, **arrays)
    digest = hashlib.sha256(unfinished.read_bytes() + json.dumps(content, sort_keys=True).encode("ascii"))
    put(unfinished, folder / "model.npz")
    unfinished = folder / "unfinished.json"
    unfinished.write_text(json.dumps({"sha256": digest.hexdigest(), "content": content}, indent=1), encoding="utf-8")
    put(unfinished, folder / "result.json")


def put(unfinished: Path, target: Path) -> None:
    """Rename a file once its content is on the disk, so that it is complete or absent even if the power fails."""
    with unfinished.open("rb+") as file:
        os.fsync(file.fileno())
    os.replace(unfinished, target)
