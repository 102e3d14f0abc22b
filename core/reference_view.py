"""The photo in which the sheet is best seen as a whole: the one its depth map is made in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .camera import Array, Camera
from .errors import UnusablePhotos
from .image import Image, sharpness, shrink
from .sparse_model import SparseModel

_MIN_VIEWS = 3
_MIN_POINTS = 20
_COMPARED_SIDE = 1000


def prominence(model: SparseModel) -> Array:
    """How much each point belongs to what the photos are of, shape (N,), 0 to 1.

    The sheet is what all photos have in their middle: a point counts more the nearer it is to the centre of the photos
    that it was seen in and the more photos saw it. Points of fewer than three views count nothing.
    """
    size = np.array([[camera.width, camera.height] for camera in model.cameras], float)[model.observed_camera]
    off_centre = ((model.observed_pixel / size - 0.5) ** 2).sum(axis=1)
    nearness = np.bincount(model.observed_point, np.exp(-off_centre / (2 * 0.25**2)), len(model.points))
    return np.where(model.views_per_point() >= _MIN_VIEWS, nearness / len(model.cameras), 0.0)


def rank_references(model: SparseModel, photos: Sequence[Image]) -> NDArray[np.int64]:
    """The cameras, best reference first.

    What counts is the area of the content in the photo, how sharp it is there, whether the sheet lies in the frame
    with some margin around it, and that it is not seen too obliquely.

    Parameters
    ----------
    model : SparseModel
    photos : sequence of (h, w, 3) uint8 or uint16 arrays
        One for each camera of the model, in full size or all reduced alike.

    Returns
    -------
    (C,) int array
        Indices into ``model.cameras``.

    Raises
    ------
    UnusablePhotos
        If hardly any point was seen in three photos.
    ValueError
        If photos and cameras differ in number.
    """
    if len(photos) != len(model.cameras):
        raise ValueError(f"{len(photos)} photos for {len(model.cameras)} cameras")
    weights = prominence(model)
    if (weights > 0).sum() < _MIN_POINTS:
        raise UnusablePhotos(
            f"Fewer than {_MIN_POINTS} points of the sheet were seen in {_MIN_VIEWS} photos or more; "
            "take sharper photos that overlap more."
        )
    # squared, for the surroundings are often larger than the sheet
    weights = weights**2 / (weights**2).sum()
    scores = [_score(model, index, weights, photo) for index, photo in enumerate(photos)]
    return np.argsort(-np.array(scores), kind="stable")


def choose_reference(model: SparseModel, photos: Sequence[Image]) -> int:
    """The first of `rank_references`."""
    return int(rank_references(model, photos)[0])


def _score(model: SparseModel, index: int, weights: Array, photo: Image) -> float:
    camera = model.cameras[index]
    pixels = camera.project(model.points)
    counted = (weights > 0) & np.isfinite(pixels).all(axis=1)
    if counted.sum() < _MIN_POINTS:
        return 0.0
    share = weights[counted] / weights[counted].sum()
    pixels = pixels[counted]
    mean = share @ pixels
    spread = (pixels - mean).T @ ((pixels - mean) * share[:, None])
    area = float(np.sqrt(max(np.linalg.det(spread), 0.0)))
    # the paper ends some way outside the outermost print
    beyond = mean + 1.15 * (pixels - mean)
    frame = np.array([camera.width, camera.height])
    whole = float(share[((beyond > 0) & (beyond < frame)).all(axis=1)].sum())
    facing = _facing(camera, model.points[counted], share)
    mine = (model.observed_camera == index) & counted[model.observed_point]
    seen = share[np.cumsum(counted)[model.observed_point[mine]] - 1].sum()
    sharp = _sharpness(photo, model.observed_pixel[mine], camera)
    return float(area * np.sqrt(sharp) * whole**4 * facing**2 * seen)


def _facing(camera: Camera, points: Array, share: Array) -> float:
    """Cosine of the angle between the sheet's mean plane and the plane at right angles to the view."""
    mean = share @ points
    spread = (points - mean).T @ ((points - mean) * share[:, None])
    normal = np.linalg.eigh(spread)[1][:, 0]
    view = mean - camera.center
    return abs(float(normal @ view)) / float(np.linalg.norm(view))


def _sharpness(photo: Image, pixels: Array, camera: Camera) -> float:
    factor = max(1, round(max(photo.shape) / _COMPARED_SIDE))
    green = shrink(photo[..., 1] if photo.ndim == 3 else photo, factor)
    return sharpness(green, pixels * (photo.shape[1] / camera.width / factor))
