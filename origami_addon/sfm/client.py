"""Starts the structure-from-motion worker, follows it, ends it, and turns its arrays into a SparseModel."""

from __future__ import annotations

import hashlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
import zipfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.camera import Camera
from ...core.errors import StepFailed, UnusablePhotos
from ...core.sparse_model import SparseModel
from ...core.watch import SILENT, Watch
from ..photos import Photo, read_pixels
from . import checks
from .colmap_cameras import to_camera

WORKER = Path(__file__).with_name("worker.py")
_POLL_SECONDS = 0.1
_STAGING = 0.08


@dataclass(frozen=True)
class SfmSettings:
    """How photos are placed.

    Attributes
    ----------
    max_image_size : int
        Pixels of the long side at which features are found; 2000 needs about 0.9 GB for each thread.
    max_features : int
        In each photo.
    threads : int
        With 1, two runs give the same bits.
    seed : int
    """

    max_image_size: int = 2000
    max_features: int = 8192
    threads: int = 2
    seed: int = 0


@dataclass(frozen=True)
class SfmResult:
    """Where the photos were taken, and how well that is known.

    Attributes
    ----------
    model : SparseModel
        Its points were seen in at least three photos (in two, where three-photo points are too few).
    dropped : dict of str to str
        For each photo that could not be placed, its name and why.
    warnings : tuple of str
    figures : dict of str to float
        For the report.
    """

    model: SparseModel
    dropped: dict[str, str]
    warnings: tuple[str, ...]
    figures: dict[str, float] = field(default_factory=dict)


def place_photos(
    photos: Sequence[Photo], work_dir: Path, settings: SfmSettings | None = None, watch: Watch = SILENT
) -> SfmResult:
    """Where each photo was taken, and the points that several of them see.

    Parameters
    ----------
    photos : sequence of Photo
        At least three.
    work_dir : Path
        Database and model are kept in a folder in it, named by the photos' content and the settings: a second run
        takes the model from there, an interrupted one goes on from the database.

    Raises
    ------
    Cancelled
        Within a second of ``watch.cancelled()``; the worker is gone then.
    UnusablePhotos
        If the photos do not show one rigid sheet from several places.
    StepFailed
        If the worker crashed.
    """
    settings = settings or SfmSettings()
    folder = Path(work_dir) / _key(photos, settings)
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "result.json").exists():
        _stage(photos, folder, settings, watch.part(0, _STAGING))
        request = {"do": "place", "photos": _camera_groups(photos), "settings": asdict(settings)}
        _run_worker(request, folder, watch.part(_STAGING, 1))
    result, arrays = _read_result(folder)
    return checks.judged(photos, result, arrays, _to_model(arrays, [photo.name for photo in photos]))


def _key(photos: Sequence[Photo], settings: SfmSettings) -> str:
    """Changes with whatever the result depends on: photos, settings, and the worker's own text."""
    depends = [[photo.sha256, photo.name] for photo in photos], asdict(settings) | {"threads": settings.threads == 1}
    return hashlib.sha256(json.dumps(depends).encode() + WORKER.read_bytes()).hexdigest()[:16]


def _camera_groups(photos: Sequence[Photo]) -> list[dict[str, Any]]:
    """Photos of one camera share its lens; portrait photos of a camera held mostly landscape are marked as turned."""
    keys = [
        (*sorted((photo.width, photo.height)), photo.make, photo.model, photo.focal_length_pixels) for photo in photos
    ]
    numbers = {key: number for number, key in enumerate(dict.fromkeys(keys))}
    wide = Counter(key for key, photo in zip(keys, photos) if photo.width > photo.height)
    members = Counter(keys)
    requests = []
    for key, photo in zip(keys, photos):
        group_is_wide = 2 * wide[key] >= members[key]
        turned = photo.width != photo.height and (photo.width > photo.height) != group_is_wide
        low, high = checks.SANE_FOCAL_LENGTHS
        focal = photo.focal_length_pixels
        if focal is not None and not low < focal / max(photo.width, photo.height) < high:
            focal = None
        requests.append(
            {
                "width": photo.width,
                "height": photo.height,
                "group": numbers[key],
                "turned": turned,
                "focal_length": focal,
            }
        )
    return requests


def _stage(photos: Sequence[Photo], folder: Path, settings: SfmSettings, watch: Watch) -> None:
    """Decode the photos that have no features yet, shrunk to the size at which the worker looks at them."""
    for index, photo in enumerate(photos):
        watch.step(index / len(photos), f"Reading {photo.name}")
        target = folder / f"pixels_{index:04d}.npy"
        if target.exists() or (folder / f"colors_{index:04d}.npy").exists():
            continue
        pixels = read_pixels(photo)
        if pixels.dtype == np.uint16:
            pixels = (pixels >> 8).astype(np.uint8)
        unfinished = target.with_suffix(".unfinished.npy")
        np.save(unfinished, _shrink(pixels, settings.max_image_size))
        os.replace(unfinished, target)


def _shrink(pixels: NDArray[np.uint8], long_side: int) -> NDArray[np.uint8]:
    """The picture at ``long_side`` pixels, each the mean over a triangle as wide as two of them; never enlarged."""
    scale = long_side / max(pixels.shape[:2])
    if scale >= 1:
        return pixels
    height, width = (max(1, round(n * scale)) for n in pixels.shape[:2])
    rows, columns = _triangle_weights(pixels.shape[0], height), _triangle_weights(pixels.shape[1], width)
    small = np.empty((height, width, 3), np.uint8)
    for channel in range(3):
        plane = columns @ (rows @ pixels[..., channel].astype(np.float32)).T
        small[..., channel] = (plane.T + 0.5).clip(0, 255)
    return small


def _triangle_weights(before: int, after: int) -> Any:
    from scipy import sparse

    ratio = before / after
    centers = (np.arange(after) + 0.5) * ratio - 0.5
    reach = np.arange(int(2 * ratio) + 2)
    at = np.floor(centers - ratio).astype(int)[:, None] + reach
    weights = np.clip(1 - np.abs(at - centers[:, None]) / ratio, 0, None).astype(np.float32)
    weights /= weights.sum(1, keepdims=True)
    rows = np.repeat(np.arange(after), len(reach))
    return sparse.csr_matrix((weights.ravel(), (rows, at.clip(0, before - 1).ravel())), (after, before))


def _run_worker(request: dict[str, Any], folder: Path, watch: Watch) -> None:
    """Run the worker to its end, passing on its progress."""
    (folder / "request.json").write_text(json.dumps(request, indent=1), encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p), "PYTHONUTF8": "1"}
    threads = request.get("settings", {}).get("threads", 1)
    environment["OMP_NUM_THREADS"] = str(threads)
    log = folder / "worker.log"
    with open(log, "wb") as errors:
        worker = subprocess.Popen(
            [sys.executable, str(WORKER), str(folder / "request.json")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            env=environment,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
    lines: queue.Queue[bytes | None] = queue.Queue()
    threading.Thread(target=_pass_on, args=(worker.stdout, lines), daemon=True).start()
    fraction, text = 0.0, "Starting structure from motion"
    try:
        while True:
            watch.step(fraction, text)
            try:
                line = lines.get(timeout=_POLL_SECONDS)
            except queue.Empty:
                continue
            if line is None:
                break
            fraction, text = _progress(line, fraction, text)
        worker.wait()
    finally:
        worker.kill()
        worker.wait()
        assert worker.stdin is not None
        worker.stdin.close()
    if worker.returncode != 0 or not (folder / "result.json").exists():
        raise StepFailed(_crash_sentence(worker.returncode, log))


def _pass_on(stream: Any, lines: queue.Queue[bytes | None]) -> None:
    for line in stream:
        lines.put(line)
    lines.put(None)
    stream.close()


def _progress(line: bytes, fraction: float, text: str) -> tuple[float, str]:
    """What a line of the worker says; pycolmap may print lines of its own, which are passed over."""
    try:
        message = json.loads(line)
        return float(message["progress"]), str(message["text"])
    except (ValueError, KeyError, TypeError):
        return fraction, text


def _crash_sentence(code: int, log: Path) -> str:
    tail = log.read_text("utf-8", "replace")
    if "No module named 'pycolmap'" in tail:
        return "This Python has no pycolmap, which places the photos: install it, or give an existing COLMAP model."
    if "No space left on device" in tail or "database or disk is full" in tail:
        return f"The disk is full: make room where {log.parent} lies and run again."
    if code in (-signal.SIGTERM, -9, 137):
        return (
            "Structure from motion was ended from outside, most likely because memory ran out: "
            "run again with one thread or a smaller matching size."
        )
    return f"Structure from motion stopped unexpectedly (code {code}): {log} says where; run again."


def _read_result(folder: Path) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    try:
        result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        with np.load(folder / "model.npz") as stored:
            return result, dict(stored)
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        (folder / "result.json").unlink(missing_ok=True)
        raise StepFailed(f"The kept model in {folder} is damaged ({error}): run again to make it anew.") from error


def _to_model(arrays: dict[str, NDArray[Any]], names: Sequence[str]) -> SparseModel | None:
    """The worker's arrays as a model, its cameras named; None where it could not place any photo."""
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


def load_model(
    model_dir: Path, photos: Sequence[Photo], work_dir: Path, watch: Watch = SILENT
) -> SfmResult:
    """An existing COLMAP model, binary or text, in place of ``place_photos``.

    The model's images are found among ``photos`` by file name; a model made of the same photos at another size is
    rescaled.

    Raises
    ------
    UnusablePhotos
        If the model does not belong to the photos, cannot be read, or has lenses that must be undistorted first.
    """
    folder = Path(work_dir) / "loaded_model"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "result.json").unlink(missing_ok=True)
    model_dir = Path(model_dir)
    kinds = [kind for kind in (".bin", ".txt") if (model_dir / f"cameras{kind}").is_file()]
    if not kinds:
        raise UnusablePhotos(
            f"{model_dir} holds no COLMAP model: name the folder with cameras.bin, images.bin and points3D.bin (or .txt)."
        )
    try:
        _run_worker({"do": "load", "model": str(model_dir.absolute())}, folder, watch)
    except StepFailed as error:
        if "pycolmap" in str(error) and "no pycolmap" in str(error):
            raise
        raise UnusablePhotos(f"The COLMAP model in {model_dir} cannot be read: export it again from COLMAP.") from error
    result, arrays = _read_result(folder)
    return checks.judged_loaded(photos, result["names"], arrays, model_dir)
