"""The worker from the side of Blender's process: starts, follows and ends it, and reads its arrays."""

from __future__ import annotations

import json
import os
import signal
import sys
import zipfile
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
from .colmap_cameras import to_camera

WORKER = Path(__file__).with_name("worker.py")
_POLL_SECONDS = 0.1


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
    try:
        while worker.code is None:
            watch.step(fraction, text)
            for message in worker.messages(_POLL_SECONDS):
                if "progress" in message:
                    fraction, text = float(message["progress"]), str(message["text"])
                    watch.step(fraction, text)
    finally:
        code = worker.end()
    if code != 0 or not (folder / "result.json").exists():
        raise StepFailed(_crash_sentence(code, log))


def _crash_sentence(code: int, log: Path) -> str:
    tail = log.read_text("utf-8", "replace")
    if "No module named 'pycolmap'" in tail:
        return "This Python has no pycolmap, which places the photos: install it, or use an existing COLMAP model."
    if "No space left on device" in tail or "database or disk is full" in tail:
        return f"The disk is full: make room on the disk of {log.parent} and run again."
    if code in (-signal.SIGTERM, -9, 137):
        return (
            "Another program ended structure from motion, most likely because memory ran out: "
            "run again with one thread or a smaller matching size."
        )
    return f"Structure from motion stopped unexpectedly (code {code}): run again; {log} says where."


def read_result(folder: Path) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    try:
        result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        with np.load(folder / "model.npz") as stored:
            return result, dict(stored)
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        (folder / "result.json").unlink(missing_ok=True)
        raise StepFailed(f"The kept model in {folder} is damaged ({error}): run again to recompute it.") from error


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
