"""The photo in which the sheet is best seen as a whole: the one its depth map is made in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import perceptual, sharpness
from ..numeric.polygon import signed_area
from ..sparse_model import FEWEST_VIEWS, SparseModel

# The sheet's outline, this much enlarged, should still lie in the frame.
_MARGIN = 1.04


def prominence(model: SparseModel) -> Array:
    """How much each point belongs to what the photos are of, shape (N,), 0 to 1.

    The sheet is what all photos have in their middle: a point counts more the nearer it is to the centre of the photos
    that it was seen in and the more photos saw it. Points of fewer than three views count nothing.
    """
    size = np.array([[camera.width, camera.height] for camera in model.cameras], float)[model.observed_camera]
    off_centre = ((model.observed_pixel / size - 0.5) ** 2).sum(axis=1)
    nearness = np.bincount(model.observed_point, np.exp(-off_centre / (2 * 0.25**2)), len(model.points))
    return np.where(model.views_per_point() >= FEWEST_VIEWS, nearness / len(model.cameras), 0.0)


def rank_references(
    model: SparseModel, photos: Sequence[NDArray[np.float32]], outline: Array, on_sheet: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """The cameras, best reference first.

    What counts is the sheet's area in the photo, how sharp it is there, whether it lies in the frame with some margin
    around it, that it is not seen too obliquely, and that folds hide nothing of it.

    Parameters
    ----------
    model : SparseModel
    photos : sequence of (h, w, 3) float32 arrays
        One for each camera of the model, as `image.reduced` gives it.
    outline : (K, 3) array
        World points along the sheet's edge.
    on_sheet : (N,) bool array
        The points of the model that lie on the sheet.

    Returns
    -------
    (C,) int array
        Indices into ``model.cameras``.

    Raises
    ------
    ValueError
        If photos and cameras differ in number.
    """
    if len(photos) != len(model.cameras):
        raise ValueError(f"{len(photos)} photos for {len(model.cameras)} cameras")
    scores = [_score(model, index, photo, outline, on_sheet) for index, photo in enumerate(photos)]
    return np.argsort(-np.array(scores), kind="stable")


def _score(
    model: SparseModel, index: int, photo: NDArray[np.float32], outline: Array, on_sheet: NDArray[np.bool_]
) -> float:
    camera = model.cameras[index]
    edge = camera.project(outline)
    if not np.isfinite(edge).all():
        return 0.0
    # where a sheet just touches the frame, there is no background against which to see its edge
    middle = edge.mean(axis=0)
    beyond = middle + _MARGIN * (edge - middle)
    frame = np.array([camera.width, camera.height])
    whole = float(((beyond > 0) & (beyond < frame)).all(axis=1).mean())
    area = np.sqrt(abs(signed_area(np.clip(edge, 0, frame))))
    mine = (model.observed_camera == index) & on_sheet[model.observed_point]
    if not mine.any():
        return 0.0
    seen = mine.sum() / on_sheet.sum()
    sharp = _sharpness(photo, model.observed_pixel[mine], camera)
    return float(area * np.sqrt(sharp) * whole**4 * _facing(camera, outline) ** 2 * seen)


def _facing(camera: Camera, outline: Array) -> float:
    """Cosine of the angle between the sheet's mean plane and the plane at right angles to the view."""
    middle = outline.mean(axis=0)
    normal = np.linalg.svd(outline - middle, full_matrices=False)[2][2]
    view = middle - camera.center
    return abs(float(normal @ view)) / float(np.linalg.norm(view))


def _sharpness(photo: NDArray[np.float32], pixels: Array, camera: Camera) -> float:
    lightness = perceptual(photo)[..., 0]
    return sharpness(lightness, pixels / round(camera.width / photo.shape[1]))
