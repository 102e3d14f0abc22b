"""Loads an existing COLMAP model instead of running structure from motion."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy import ndimage

from ...core.arrays import Array
from ...core.camera import Camera
from ...core.errors import UnusablePhotos
from ...core.placing.checks import figures_of, useful_points
from ...core.placing.photo import FEWEST_PHOTOS
from ...core.placing.result import SfmResult
from ...core.sparse_model import FEWEST_VIEWS, SparseModel
from ...core.watch import SILENT, Watch
from ..files.decoded_photo import Image
from ..files.photos import Photo, read_pixels
from .colmap_files import check_files, model_folder
from .worker_process import WorkerCrashed, result_of_worker, to_model

# Bytes of addresses that the worker may take to read a model, at least and for each byte of its files. Measured: 0.4 GB
# for a small one, and twice the size of the files for 300 000 points; more for the arrays that are made of it.
_MEMORY, _MEMORY_PER_BYTE = 2 << 30, 50
# Largest mean reprojection error, relative to the photo's long side, and at least in pixels. Measured: nine good sets
# at most 0.00044; a sheet that moved or bent in half of the photos 0.0015 to 0.0018 (0.94 to 1.16 pixels in photos of
# 640).
_LARGEST_RESIDUAL = 0.00075
_LARGEST_RESIDUAL_PIXELS = 0.7
# A dot's contrast is its difference from its surroundings, which are this share of the long side wide.
_SURROUNDINGS = 0.01
# Correlation of a dot's contrast in one photo with its contrast in the photos that see its point. Measured in photos
# that see the point themselves: at least 0.93 in good sets, at most 0.02 with photos of another set or in another
# order.
_LEAST_CORRELATION = 0.5
# Measured in photos that do not see it: at least 0.84 in good sets (some points are hidden there); with the sheet bent
# in half of the photos 0.64, moved 0.14.
_LEAST_CORRELATION_UNSEEN = 0.65
_FEWEST_UNSEEN = 100


def load_model(model_dir: Path, photos: Sequence[Photo], work_dir: Path, watch: Watch = SILENT) -> SfmResult:
    """An existing COLMAP model, binary or text, as ``place_photos`` would return it.

    The model's images are found among ``photos`` by file name; a model made of the same photos at another size is
    rescaled.

    Parameters
    ----------
    model_dir : Path
        Folder with ``cameras``, ``images`` and ``points3D``, ``.bin`` or ``.txt``, or one with such a folder as
        ``sparse/0``, ``sparse`` or ``0``.
    photos : sequence of Photo
        The photos from which the model was made.
    work_dir : Path
        For the worker's files.

    Raises
    ------
    UnusablePhotos
        If the model does not belong to the photos, cannot be read, or has lenses that must be undistorted first.
    StepFailed
        If this Python has no pycolmap.
    """
    model_dir = model_folder(Path(model_dir))
    size = check_files(model_dir)
    folder = Path(work_dir) / "loaded_model"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "result.json").unlink(missing_ok=True)
    request = {"do": "load", "model": str(model_dir.absolute()), "most_memory": _MEMORY + _MEMORY_PER_BYTE * size}
    try:
        result, arrays = result_of_worker(request, folder, watch.part(0, 0.5))
        readable = result["placed"]
    except WorkerCrashed:
        readable = False
    if not readable:
        raise UnusablePhotos(f"The COLMAP model in {model_dir} cannot be read: export it again from COLMAP.")
    photo_of_camera = _find_photos(result["names"], photos, model_dir)
    model = to_model(arrays, result["names"])
    assert model is not None
    model = _fitted(model, [photos[i] if i is not None else None for i in photo_of_camera], model_dir)
    _check_residual(model, model_dir)
    useful = useful_points(model)
    _check_prints(useful, {photo.name: photo for photo in photos}, model_dir, watch.part(0.5, 1))
    named = {camera.name for camera in model.cameras}
    dropped = {photo.name: "it is not in the COLMAP model" for photo in photos if photo.name not in named}
    warnings = [f"{name} is left out: {why}." for name, why in dropped.items()]
    missing = [name for name, index in zip(result["names"], photo_of_camera) if index is None]
    if missing:
        warnings.append(f"These images of the COLMAP model are not among the photos: {', '.join(missing)}.")
    return SfmResult(useful, tuple(warnings), figures_of(useful, dropped))


def _find_photos(names: Sequence[str], photos: Sequence[Photo], model_dir: Path) -> list[int | None]:
    """For each of the model's images the photo of the same name, with as many matching folders as possible."""
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
            f"({', '.join(names[:3])} ...) have the name of a photo; use the photos from which the model was made."
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
        # Allows for sizes rounded to whole pixels on either side.
        tolerance = 1 / min(camera.width, camera.height) + 1 / min(photo.width, photo.height)
        if abs(scale[0] / scale[1] - 1) > tolerance:
            raise UnusablePhotos(
                f"The COLMAP model in {model_dir} does not match the photos: {photo.name} has {photo.width} x "
                f"{photo.height} pixels, the model {camera.width} x {camera.height}; "
                "use the photos from which the model was made."
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


def _check_residual(model: SparseModel, model_dir: Path) -> None:
    sides = np.array([max(camera.width, camera.height) for camera in model.cameras])
    allowed = np.maximum(_LARGEST_RESIDUAL * sides, _LARGEST_RESIDUAL_PIXELS)[model.observed_camera]
    errors = model.reprojection_errors()
    # A point behind a camera that sees it counts as off by the whole photo.
    errors = np.where(np.isfinite(errors), errors, sides[model.observed_camera])
    if len(errors) and (errors / allowed).mean() > 1:
        raise UnusablePhotos(_moved(model_dir, f"its points are {errors.mean():.1f} pixels off on average"))


def _check_prints(model: SparseModel, photos: dict[str, Photo], model_dir: Path, watch: Watch) -> None:
    """At a point of the model, all photos must show the same dot of print, whether the model sees it there or not.

    A model of other photos fails where points are seen. A model of a sheet that moved or bent contains the sheet more
    than once, each copy seen only in the photos of one state: it fails where points are not seen.
    """
    contrast = np.full((len(model.cameras), len(model.points)), np.nan)
    seen = np.zeros(contrast.shape, bool)
    for index, camera in enumerate(model.cameras):
        watch.step(index / len(model.cameras), f"Comparing the model with {camera.name}")
        pixels = camera.project(model.points)
        mine = model.observed_camera == index
        pixels[model.observed_point[mine]] = model.observed_pixel[mine]
        seen[index, model.observed_point[mine]] = True
        contrast[index] = _local_contrast(read_pixels(photos[camera.name]), pixels)
    in_photo = np.isfinite(contrast)
    views = (seen & in_photo).sum(0)
    total = np.where(seen & in_photo, contrast, 0).sum(0)
    elsewhere = (total - np.where(seen, contrast, 0)) / np.maximum(views - seen, 1)
    compared = in_photo & (views >= FEWEST_VIEWS)
    where_seen, where_not = compared & seen, compared & ~seen
    if _correlation(contrast[where_seen], elsewhere[where_seen]) < _LEAST_CORRELATION:
        raise UnusablePhotos(
            f"The COLMAP model in {model_dir} does not match the photos: the photos show different things at the same "
            "point of the model; use the photos from which the model was made."
        )
    if (
        np.count_nonzero(where_not) > _FEWEST_UNSEEN
        and _correlation(contrast[where_not], elsewhere[where_not]) < _LEAST_CORRELATION_UNSEEN
    ):
        raise UnusablePhotos(_moved(model_dir, "photos that do not see its points show something else there"))


def _moved(model_dir: Path, sign: str) -> str:
    return (
        f"The COLMAP model in {model_dir} cannot be relied on: {sign}. The sheet seems to have moved or bent between "
        "the photos; photograph it again without touching it, or use a model of photos between which it did not move."
    )


def _local_contrast(photo: Image, pixels: Array) -> Array:
    """How much lighter the photo is at ``pixels`` (N, 2) than around them, shape (N,); NaN outside the photo."""
    grey = photo.mean(-1, dtype=np.float32) / np.iinfo(photo.dtype).max
    around = max(3, round(_SURROUNDINGS * max(grey.shape)))
    grey = ndimage.uniform_filter(grey, 3) - ndimage.uniform_filter(grey, around)
    contrast = np.full(len(pixels), np.nan)
    inside = ((pixels >= 0) & (pixels < [grey.shape[1], grey.shape[0]])).all(1)
    column, row = pixels[inside].astype(np.int64).T
    contrast[inside] = grey[row, column]
    return contrast


def _correlation(first: Array, second: Array) -> float:
    """Of two samples; 0 if they are empty or one is constant."""
    spread = float(first.std() * second.std()) if len(first) else 0.0
    return float(np.cov(first, second, bias=True)[0, 1]) / spread if spread else 0.0
