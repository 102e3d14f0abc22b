"""The worker from the side of Blender's process: starts, follows and ends it, and reads its arrays."""

from __future__ import annotations

import hashlib
import io
import json
import os
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.camera import Camera
from ...core.errors import StepFailed
from ...core.sparse_model import SparseModel
from ...core.watch import Watch
from ..child_process import ChildProcess
from ..files.json_files import parsed_json
from .colmap_cameras import to_camera

WORKER = Path(__file__).with_name("worker.py")
_POLL_SECONDS = 0.1  # between two looks whether the user wants to stop
# The worker shows life every 5 s. It could not while pycolmap held Python's lock, but extraction, matching and mapping
# held it for less than 0.1 s at a time; the rest is for a computer that is short of memory.
_MOST_SILENT_SECONDS = 120.0


class WorkerCrashed(StepFailed):
    """The worker ended unexpectedly, neither because the disk is full nor because another program ended it."""


def worker_source() -> bytes:
    """The text of the worker's modules: what it makes depends on it."""
    here = Path(__file__).parent
    modules = (here / "worker.py", *sorted((here / "pycolmap_worker").glob("*.py")))
    return b"".join(module.read_bytes() for module in modules)


def run_worker(request: dict[str, Any], folder: Path, watch: Watch) -> None:
    """Run the worker to its end and pass on its progress."""
    (folder / "request.json").write_text(json.dumps(request, indent=1), encoding="utf-8")
    threads = request.get("settings", {}).get("threads", 1)
    path = os.pathsep.join(each for each in sys.path if each)
    log = folder / "worker.log"
    worker = ChildProcess(
        [sys.executable, str(WORKER), str(folder / "request.json")],
        log,
        {"PYTHONPATH": path, "OMP_NUM_THREADS": str(threads)},
    )
    fraction, text = 0.0, "Starting structure from motion"
    silent = 0.0  # counted in polls, because a suspended computer's clock runs on
    try:
        while worker.code is None:
            watch.step(fraction, text)
            silent += _POLL_SECONDS
            if silent > _MOST_SILENT_SECONDS:
                raise StepFailed(
                    f"Structure from motion showed no sign of life for {silent:.0f} seconds and was ended: another "
                    "program may have stopped it, or memory is short; run again, and if it happens again, with one "
                    "thread or a smaller matching size."
                )
            for message in worker.messages(_POLL_SECONDS):
                silent = 0.0
                if "progress" in message:
                    fraction, text = float(message["progress"]), str(message["text"])
                    watch.step(fraction, text)
    finally:
        code = worker.end()
    if code != 0 or not (folder / "result.json").exists():
        raise _crash(code, log)


def _crash(code: int, log: Path) -> StepFailed:
    tail = log.read_text("utf-8", "replace")
    if "No module named 'pycolmap'" in tail:
        return StepFailed(
            "This Python has no pycolmap, which places the photos: install it, or use an existing COLMAP model."
        )
    if "No space left on device" in tail or "database or disk is full" in tail:
        return StepFailed(f"The disk is full: make room on the disk of {log.parent} and run again.")
    if "bad_alloc" in tail or "MemoryError" in tail or "Unable to allocate" in tail:
        return StepFailed(_out_of_memory("Memory ran out in structure from motion"))
    if code in (-signal.SIGTERM, -9, 137):
        return StepFailed(
            _out_of_memory("Another program ended structure from motion, most likely because memory ran out")
        )
    return WorkerCrashed(f"Structure from motion stopped unexpectedly (code {code}): run again; {log} says where.")


def _out_of_memory(what: str) -> str:
    return f"{what}: run again with one thread or a smaller matching size."


def read_result(folder: Path) -> tuple[dict[str, Any], dict[str, NDArray[Any]]] | None:
    """The worker's result in a folder; None if there is none or it is damaged.

    Returns
    -------
    content : dict
    arrays : dict of arrays
    """
    try:
        stored = parsed_json(folder / "result.json")
        model, content = (folder / "model.npz").read_bytes(), stored["content"]
        digest = hashlib.sha256(model + json.dumps(content, sort_keys=True).encode("ascii")).hexdigest()
        if stored["sha256"] != digest:
            return None
    except (OSError, ValueError, KeyError, TypeError):
        return None
    with np.load(io.BytesIO(model)) as arrays:
        return content, dict(arrays)


def result_of_worker(request: dict[str, Any], folder: Path, watch: Watch) -> tuple[dict[str, Any], dict[str, Any]]:
    """Run the worker and read its result.

    Raises
    ------
    Cancelled, StepFailed
    """
    run_worker(request, folder, watch)
    result = read_result(folder)
    if result is None:
        raise StepFailed(f"What structure from motion wrote into {folder} is damaged: check that disk, and run again.")
    return result


def to_model(arrays: dict[str, NDArray[Any]], names: Sequence[str]) -> SparseModel | None:
    """The worker's arrays as a model with named cameras; None if it could not place any photo."""
    if "points" not in arrays:
        return None
    cameras: list[Camera] = []
    for index, kind, size, parameters, pose in zip(
        *(arrays[key] for key in ("photo", "camera_model", "camera_size", "camera_parameters", "poses"))
    ):
        cameras.append(to_camera(names[index], str(kind), size, parameters, pose))
    return SparseModel(
        tuple(cameras),
        arrays["points"],
        arrays["colors"],
        arrays["observed_point"],
        arrays["observed_camera"],
        arrays["observed_pixel"],
    )
