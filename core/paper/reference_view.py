"""Choose the reference photo: the one that shows the whole sheet best, over which the surface is built."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import perceptual, sharpness
from ..numeric.polygon import signed_area
from ..sparse_model import FEWEST_VIEWS, SparseModel

# The values below are choices; no measurement of them is recorded.
# Standard deviation of the weight of a point by its distance from the photo's centre, in widths and heights of the
# photo: the aimed-at sheet usually fills at least the middle half.
_CENTRAL = 0.25
# The sheet's outline, this much enlarged, should still lie in the frame: there must be background to see the edge.
_MARGIN = 1.04
# The score of a photo is a product, so a photo that fails in one respect loses: the side of the sheet (pixels) times
# the share of its points in view, the root of its sharpness, and powers of two factors. The share within the frame
# counts most (0.81 with 5 % outside), because the page lacks what the reference cuts off.
_OF_WHOLE, _OF_FACING = 4, 2


def prominence(model: SparseModel) -> Array:
    """How likely each point is part of the photographed object, shape (N,), 0 to 1.

    All photos have the sheet in their middle, so a point counts more the nearer it is to the centre of the photos that
    show it, and the more photos show it. Points with fewer than three views do not count.
    """
    size = np.array([[camera.width, camera.height] for camera in model.cameras], float)[model.observed_camera]
    off_centre = ((model.observed_pixel / size - 0.5) ** 2).sum(axis=1)
    nearness = np.bincount(model.observed_point, np.exp(-off_centre / (2 * _CENTRAL**2)), len(model.points))
    return np.where(model.views_per_point() >= FEWEST_VIEWS, nearness / len(model.cameras), 0.0)


def rank_references(
    model: SparseModel, photos: Sequence[NDArray[np.float32]], outline: Array, on_sheet: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """The cameras, best reference first.

    A photo scores by the sheet's size and sharpness in it, by how much of the sheet is in the frame with some margin,
    by how directly it is seen, and by how little of it folds hide.

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
    return float(area * np.sqrt(sharp) * whole**_OF_WHOLE * _facing(camera, outline) ** _OF_FACING * seen)


def _facing(camera: Camera, outline: Array) -> float:
    """Cosine of the angle between the normal of the sheet's mean plane and the view."""
    middle = outline.mean(axis=0)
    normal = np.linalg.svd(outline - middle, full_matrices=False)[2][2]
    view = middle - camera.center
    return abs(float(normal @ view)) / float(np.linalg.norm(view))


def _sharpness(photo: NDArray[np.float32], pixels: Array, camera: Camera) -> float:
    lightness = perceptual(photo)[..., 0]
    return sharpness(lightness, pixels / round(camera.width / photo.shape[1]))
