"""Results of steps kept on disk: a second run reuses what is unchanged.

A file is named after a hash of what its result depends on, and one of its own content, so damage is noticed.
"""

from __future__ import annotations

import hashlib
import io
import json
import logging
import os
import re
from collections.abc import Callable, Container
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .atomic import replacing
from .content_hash import sha256_of

Arrays = dict[str, NDArray[Any]]
# A step, what its result depends on, its content.
KEPT_FILE = re.compile(r"[a-z_]+-[0-9a-f]{16}(-[0-9a-f]{16})?\.npz")

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


def kept_as(name: str, key: str) -> str:
    """How the name of a kept result begins; a hash of its content follows."""
    return f"{name}-{key}"


def drop_superseded(folder: Path, name: str, used: Container[str]) -> None:
    """Remove a step's kept results that are not `kept_as` one of those used; one that is open elsewhere stays."""
    for path in folder.glob(f"{name}-*.npz"):
        if path.stem.rpartition("-")[0] not in used:
            with suppress(OSError):
                path.unlink()


def kept(
    folder: Path,
    name: str,
    key: str,
    compute: Callable[[], tuple[Arrays, dict[str, Any]]],
    warn: Callable[[str], None],
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
    warn : callable
        Takes a sentence if what an earlier run kept is damaged.

    Raises
    ------
    StepFailed
        If the result cannot be written, and whatever ``compute`` raises.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for path in folder.glob(f"{kept_as(name, key)}-*.npz"):
        try:
            content = path.read_bytes()
            if path.name == _named(name, key, hashlib.sha256(content).hexdigest()):
                with np.load(io.BytesIO(content)) as stored:
                    arrays = dict(stored)
                log.info("%s: kept from an earlier run", name)
                return arrays, json.loads(str(arrays.pop("notes")))
        except OSError:
            pass
        warn(f"{path}, kept from an earlier run, was damaged; its result was computed again.")
        path.unlink()
    arrays, notes = compute()
    unfinished = folder / f"{kept_as(name, key)}.npz"
    with replacing(unfinished) as writing:
        np.savez(writing, notes=np.array(json.dumps(notes)), **arrays)  # type: ignore[arg-type, unused-ignore]
    os.replace(unfinished, folder / _named(name, key, sha256_of(unfinished)))
    return arrays, notes


def _named(name: str, key: str, digest: str) -> str:
    """The name that a kept file must have by the hash of its content."""
    return f"{kept_as(name, key)}-{digest[:16]}.npz"
