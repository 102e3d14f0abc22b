"""An existing COLMAP model in place of structure from motion of our own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.camera import Camera
from ...core.errors import UnusablePhotos
from ...core.sparse_model import SparseModel
from ...core.watch import SILENT, Watch
from ..photos import FEWEST_PHOTOS, Photo, read_pixels
from .checks import figures_of, useful_points
from .result import SfmResult
from .worker_process import read_result, run_worker, to_model

# Correlation of the points' colours with the photos: 0.88 to 0.98 with the right photos of nine sets, at most 0.35 with
# those of another set of the same size.
_LEAST_CORRELATION = 0.6


def load_model(model_dir: Path, photos: Sequence[Photo], work_dir: Path, watch: Watch = SILENT) -> SfmResult:
    """An existing COLMAP model, binary or text, as ``place_photos`` would return it.

    The model's images are found among ``photos`` by file name; a model made of the same photos at another size is
    rescaled.

    Parameters
    ----------
    model_dir : Path
        Folder with ``cameras``, ``images`` and ``points3D``, ``.bin`` or ``.txt``.
    photos : sequence of Photo
        Those that the model was made of.
    work_dir : Path
        For the worker's files.

    Raises
    ------
    UnusablePhotos
        If the model does not belong to the photos, cannot be read, or has lenses that must be undistorted first.
    StepFailed
        If this Python has no pycolmap.
    """
    model_dir = Path(model_dir)
    if not any((model_dir / f"cameras{kind}").is_file() for kind in (".bin", ".txt")):
        raise UnusablePhotos(
            f"{model_dir} holds no COLMAP model: name the folder with cameras, images and points3D (.bin or .txt)."
        )
    folder = Path(work_dir) / "loaded_model"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "result.json").unlink(missing_ok=True)
    run_worker({"do": "load", "model": str(model_dir.absolute())}, folder, watch.part(0, 0.5))
    result, arrays = read_result(folder)
    if not result["placed"]:
        raise UnusablePhotos(f"The COLMAP model in {model_dir} cannot be read: export it again from COLMAP.")
    photo_of_camera = _find_photos(result["names"], photos, model_dir)
    model = to_model(arrays, result["names"])
    assert model is not None
    model = _fitted(model, [photos[i] if i is not None else None for i in photo_of_camera], model_dir)
    _check_colors(model, {photo.name: photo for photo in photos}, model_dir, watch.part(0.5, 1))
    named = {camera.name for camera in model.cameras}
    dropped = {photo.name: "it is not in the COLMAP model" for photo in photos if photo.name not in named}
    warnings = [f"{name} is left out: {why}." for name, why in dropped.items()]
    missing = [name for name, index in zip(result["names"], photo_of_camera) if index is None]
    if missing:
        warnings.append(f"Of the COLMAP model's images these are not among the photos: {', '.join(missing)}.")
    model = useful_points(model)
    return SfmResult(model, dropped, tuple(warnings), figures_of(model, len(photos)))


def _find_photos(names: Sequence[str], photos: Sequence[Photo], model_dir: Path) -> list[int | None]:
    """For each of the model's images the photo of the same name: with as much of its folders as agrees."""
    found: list[int | None] = []
    for name in names:
        parts = tuple(name.replace("\\", "/").split("/"))
        same = [i for i, photo in enumerate(photos) if photo.path.name == parts[-1]]
        longer = [i for i in same if photos[i].path.parts[-len(parts) :] == parts]
        candidates = longer or same
        found.append(candidates[0] if len(candidates) == 1 else None)
    taken = [index for index in found if index is not None]
    if len(set(taken)) < FEWEST_PHOTOS or len(set(taken)) < len(taken):
        raise UnusablePhotos(
            f"The COLMAP model in {model_dir} does not match the photos: {len(set(taken))} of its {len(names)} images "
            f"({', '.join(names[:3])} ...) are among them by name; give the photos that the model was made of."
        )
    return found


def _fitted(model: SparseModel, photos: Sequence[Photo | None], model_dir: Path) -> SparseModel:
    """The model without the cameras that have no photo, in the pixels of the photos."""
    keep = np.array([photo is not None for photo in photos])
    cameras: list[Camera] = []
    scales = np.ones((len(photos), 2))
    for index, (camera, photo) in enumerate(zip(model.cameras, photos)):
        if photo is None:
            continue
        scale = np.array([photo.width / camera.width, photo.height / camera.height])
        # A size rounded to whole pixels on either side.
        tolerance = 1 / min(camera.width, camera.height) + 1 / min(photo.width, photo.height)
        if abs(scale[0] / scale[1] - 1) > tolerance:
            raise UnusablePhotos(
                f"The COLMAP model in {model_dir} does not match the photos: {photo.name} has {photo.width} x "
                f"{photo.height} pixels, the model {camera.width} x {camera.height}; "
                "give the photos that the model was made of."
            )
        scales[index] = scale
        cameras.append(
            Camera(
                photo.name,
                photo.width,
                photo.height,
                camera.focal_length * float(scale.mean()),
                camera.principal_point * scale,
                camera.distortion,
                camera.rotation,
                camera.translation,
            )
        )
    seen = keep[model.observed_camera]
    number = np.cumsum(keep) - 1
    camera_index = model.observed_camera[seen]
    return SparseModel(
        tuple(cameras),
        model.points,
        model.colors,
        model.observed_point[seen],
        number[camera_index],
        model.observed_pixel[seen] * scales[camera_index],
    )


def _check_colors(model: SparseModel, photos: dict[str, Photo], model_dir: Path, watch: Watch) -> None:
    """The points must have the colours that the photos show there; a model without colours passes."""
    if len(np.unique(model.colors.reshape(-1, 3), axis=0)) < 3:
        return
    told: list[NDArray[Any]] = []
    shown: list[NDArray[Any]] = []
    for index, camera in enumerate(model.cameras):
        watch.step(index / len(model.cameras), f"Comparing the model with {camera.name}")
        mine = model.observed_camera == index
        pixels = read_pixels(photos[camera.name]).mean(-1)
        column, row = model.observed_pixel[mine].astype(int).T
        inside = (column >= 0) & (row >= 0) & (column < camera.width) & (row < camera.height)
        told.append(model.colors[model.observed_point[mine]].mean(-1)[inside])
        shown.append(pixels[row[inside], column[inside]])
    correlation = np.corrcoef(np.concatenate(told), np.concatenate(shown))[0, 1]
    if correlation < _LEAST_CORRELATION:
        raise UnusablePhotos(
            f"The COLMAP model in {model_dir} does not match the photos: its points have other colours than the photos "
            "show there; give the photos that the model was made of."
        )
