"""Places photos by structure from motion: the worker does it, this starts it and judges its model."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ...core.watch import SILENT, Watch
from ..files.atomic import replacing
from ..files.photos import Photo, read_pixels
from . import checks
from .colmap_model import load_model
from .result import SfmResult, SfmSettings
from .worker_process import WORKER, read_result, run_worker, to_model

__all__ = ["SfmResult", "SfmSettings", "load_model", "place_photos"]

_STAGING = 0.08


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
        run_worker(request, folder, watch.part(_STAGING, 1))
    result, arrays = read_result(folder)
    return checks.judge(photos, result, arrays, to_model(arrays, [photo.name for photo in photos]))


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
        requests.append(
            {
                "width": photo.width,
                "height": photo.height,
                "group": numbers[key],
                "turned": turned,
                "focal_length": checks.believable_focal_length(photo),
            }
        )
    return requests


def _stage(photos: Sequence[Photo], folder: Path, settings: SfmSettings, watch: Watch) -> None:
    """Decode the photos that have no features yet, shrunk to the size at which the worker looks at them."""
    for index, photo in enumerate(photos):
        watch.step(index / len(photos), f"Reading {photo.name}")
        target = folder / f"{index:04d}.ppm"
        if target.exists() or (folder / f"colors_{index:04d}.npy").exists():
            continue
        pixels = read_pixels(photo)
        shift = 8 * (pixels.dtype.itemsize - 1)
        small = _shrink((pixels >> shift).astype(np.uint8), settings.max_image_size)
        with replacing(target) as unfinished, unfinished.open("wb") as file:
            file.write(b"P6\n%d %d\n255\n" % (small.shape[1], small.shape[0]))
            file.write(np.ascontiguousarray(small).data)


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
    ratio = before / after
    centers = (np.arange(after) + 0.5) * ratio - 0.5
    reach = np.arange(int(2 * ratio) + 2)
    at = np.floor(centers - ratio).astype(int)[:, None] + reach
    weights = np.clip(1 - np.abs(at - centers[:, None]) / ratio, 0, None).astype(np.float32)
    weights /= weights.sum(1, keepdims=True)
    rows = np.repeat(np.arange(after), len(reach))
    return sparse.csr_matrix((weights.ravel(), (rows, at.clip(0, before - 1).ravel())), (after, before))
