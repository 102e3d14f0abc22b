"""Results of steps kept on disk, named after a hash of their inputs: a second run reuses what is unchanged."""

from __future__ import annotations

import hashlib
import json
import logging
import zipfile
from collections.abc import Callable, Container
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .atomic import replacing

Arrays = dict[str, NDArray[Any]]

log = logging.getLogger("origami")


def key_of(*depends: Any) -> str:
    """A name that changes with any of ``depends``, which must be writable as JSON."""
    return hashlib.sha256(json.dumps(depends, sort_keys=True).encode()).hexdigest()[:16]


def digest_of(*arrays: NDArray[Any]) -> str:
    """A text for `key_of` that changes with the shape and content of arrays."""
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(str(array.shape).encode() + np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def kept_file(folder: Path, name: str, key: str) -> Path:
    """Where `kept` keeps a result."""
    return folder / f"{name}-{key}.npz"


def drop_superseded(folder: Path, name: str, used: Container[Path]) -> None:
    """Remove a step's kept results that are not among those used; one that another program has open stays."""
    for path in folder.glob(f"{name}-*.npz"):
        if path not in used:
            with suppress(OSError):
                path.unlink()


def kept(
    folder: Path, name: str, key: str, compute: Callable[[], tuple[Arrays, dict[str, Any]]]
) -> tuple[Arrays, dict[str, Any]]:
    """The result of ``compute``, or the result that an earlier run kept under the same key.

    Parameters
    ----------
    folder : Path
        Created if missing.
    name : str
        Of the step.
    key : str
        From `key_of`.
    compute : callable
        Returns arrays, and figures and notes that can be written as JSON.

    Raises
    ------
    StepFailed
        If the result cannot be written, and whatever ``compute`` raises.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = kept_file(folder, name, key)
    if path.exists():
        try:
            with np.load(path) as stored:
                arrays = dict(stored)
            log.info("%s: kept from an earlier run", name)
            return arrays, json.loads(str(arrays.pop("notes")))
        except (OSError, ValueError, KeyError, zipfile.BadZipFile):
            log.info("%s: the result kept from an earlier run is damaged and is recomputed", name)
    arrays, notes = compute()
    with replacing(path) as unfinished:
        np.savez(unfinished, notes=np.array(json.dumps(notes)), **arrays)  # type: ignore[arg-type, unused-ignore]
    return arrays, notes
