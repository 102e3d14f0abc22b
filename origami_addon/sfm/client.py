"""Places photos by structure from motion: starts the worker, which does the work, and judges its model."""

from __future__ import annotations

import hashlib
import json
import logging
import shutil
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ...core.errors import UnusablePhotos
from ...core.placing import checks
from ...core.placing.causes import possible_causes
from ...core.placing.causes_in_matches import mirrored_photos, too_near, unconnected
from ...core.placing.result import SfmResult, SfmSettings
from ...core.placing.trial import Trial, agreeing_matches, lenses_may_differ, measure, prefer_own_lenses
from ...core.placing.verdict import failure, result_of
from ...core.watch import SILENT, Watch
from ..files.atomic import replacing
from ..files.decoded_photo import Image
from ..files.photos import Photo, read_pixels
from .colmap_model import load_model
from .worker_process import WorkerCrashed, read_result, result_of_worker, to_model, worker_source

__all__ = ["SfmResult", "SfmSettings", "load_model", "place_photos"]

# Start and end of each usual step as shares of the time; attempts after a failure come at the end.
_STAGING, _PLACED, _TRIED = 0.08, 0.96, 0.99

# The content and the arrays of what the worker wrote.
Result = tuple[dict[str, Any], dict[str, NDArray[Any]]]

log = logging.getLogger("origami")


def place_photos(
    photos: Sequence[Photo], work_dir: Path, settings: SfmSettings | None = None, watch: Watch = SILENT
) -> SfmResult:
    """Where each photo was taken, and the points that several of them see.

    Parameters
    ----------
    photos : sequence of Photo
        At least three.
    work_dir : Path
        Database and model are kept in a subfolder named after the photos' content and the settings: a second run reuses
        the model, and an interrupted one continues from the database.

    Raises
    ------
    Cancelled
        Within a second of ``watch.cancelled()``; the worker has then ended.
    UnusablePhotos
        If the photos do not show one rigid sheet from several places.
    StepFailed
        If the worker crashed.
    """
    settings = settings or SfmSettings()
    folder = Path(work_dir) / _key(photos, settings)
    begun = folder.exists()
    try:
        return _placed(photos, folder, settings, watch)
    except WorkerCrashed:
        if not begun:
            raise
    # A power failure can leave any damage in the database.
    log.warning("structure from motion could not go on from what %s holds, and begins again", folder)
    shutil.rmtree(folder)
    result = _placed(photos, folder, settings, watch)
    warning = f"The photos were placed again, because what an earlier run had kept in {folder} was damaged."
    return replace(result, warnings=(warning, *result.warnings))


def _placed(photos: Sequence[Photo], folder: Path, settings: SfmSettings, watch: Watch) -> SfmResult:
    """Place the photos, or go on from what the folder holds."""
    folder.mkdir(parents=True, exist_ok=True)
    asked = {"photos": _camera_groups(photos), "settings": asdict(settings)}
    result = read_result(folder)
    if result is None:
        for tried in ("own_lenses", "look_closer"):
            shutil.rmtree(folder / tried, ignore_errors=True)
        _stage(photos, folder, settings, watch.part(0, _STAGING))
        result = result_of_worker({"do": "place"} | asked, folder, watch.part(_STAGING, _PLACED))
    arrays = result[1]
    shared = _trial(result, photos, None)
    trials = [shared]
    if lenses_may_differ(shared, photos, arrays) and too_near(photos, arrays) is None:
        own_result = _asked_again({"do": "own_lenses"} | asked, folder, watch.part(_PLACED, _TRIED))
        trials.append(_trial(own_result, photos, arrays))
    own = trials[1] if len(trials) > 1 else None
    chosen = own if own is not None and prefer_own_lenses(shared, own, len(photos)) else shared
    agreeing = agreeing_matches(arrays, len(photos))
    look: dict[str, Any] = {"mirrored": []}
    if not chosen.serves(len(photos)) or len(chosen.placed) < len(photos) or unconnected(chosen.placed, agreeing):
        look = _look_closer(agreeing, asked, folder, watch.part(_TRIED, 1))
    mirrored = mirrored_photos(agreeing, look["mirrored"])
    for trial in trials:
        log.info("tried: %s", json.dumps(trial.figures()))
    if chosen.serves(len(photos)) and chosen.placed.isdisjoint(mirrored):
        return result_of(photos, agreeing, trials, chosen, mirrored)
    possible = possible_causes(photos, arrays, shared, own, look)
    for cause in possible:
        log.info("likely %.2f times its limit: %s %s", cause.likelihood, cause.claim, json.dumps(cause.evidence))
    raise UnusablePhotos(failure(photos, chosen, possible))


def _trial(result: Result, photos: Sequence[Photo], matches: dict[str, NDArray[Any]] | None) -> Trial:
    """The worker's result, measured against ``matches`` (its own if None)."""
    content, arrays = result
    model = to_model(arrays, [photo.name for photo in photos])
    placed = arrays["photo"].tolist() if "photo" in arrays else []
    way = f"{content['way']}, own lenses" if matches is not None else content["way"]
    return measure(way, model, arrays if matches is None else matches, placed)


def _asked_again(request: dict[str, Any], folder: Path, watch: Watch) -> Result:
    """Have the worker do more with its result in ``folder``; a subfolder keeps the new result."""
    inside = folder / request["do"]
    inside.mkdir(exist_ok=True)
    return read_result(inside) or result_of_worker(request, inside, watch)


def _look_closer(agreeing: NDArray[np.int64], asked: dict[str, Any], folder: Path, watch: Watch) -> dict[str, Any]:
    """What the features show of photos that have too little in common."""
    first, second = np.nonzero(np.triu(agreeing < checks.OVERLAP_MATCHES, 1))
    pairs = np.stack([first, second], 1).tolist()
    return _asked_again({"do": "look_closer", "pairs": pairs} | asked, folder, watch)[0]


def _key(photos: Sequence[Photo], settings: SfmSettings) -> str:
    """A key that changes with everything on which the result depends: photos, settings, and the worker's source."""
    depends = [[photo.sha256, photo.name] for photo in photos], asdict(settings) | {"threads": settings.threads == 1}
    return hashlib.sha256(json.dumps(depends).encode() + worker_source()).hexdigest()[:16]


def _camera_groups(photos: Sequence[Photo]) -> list[dict[str, Any]]:
    """Photos of one camera share its lens; portrait photos of a camera mostly held landscape are marked as turned."""
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
    """Decode the photos that have no features yet, shrunk to the worker's size."""
    for index, photo in enumerate(photos):
        watch.step(index / len(photos), f"Reading {photo.name}")
        target = folder / f"{index:04d}.ppm"
        if target.exists() or (folder / f"colors_{index:04d}.npy").exists():
            continue
        write_picture(target, read_pixels(photo), settings.max_image_size)


def write_picture(target: Path, pixels: Image, long_side: int) -> None:
    """Write a picture as the worker reads it: 8 bits, its longer side at most ``long_side`` pixels."""
    shift = 8 * (pixels.dtype.itemsize - 1)
    small = _shrink((pixels >> shift).astype(np.uint8), long_side)
    with replacing(target) as unfinished, unfinished.open("wb") as file:
        file.write(b"P6\n%d %d\n255\n" % (small.shape[1], small.shape[0]))
        file.write(np.ascontiguousarray(small).data)


def _shrink(pixels: NDArray[np.uint8], long_side: int) -> NDArray[np.uint8]:
    """The picture at ``long_side`` pixels, filtered with a triangle two pixels wide; never enlarged."""
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
