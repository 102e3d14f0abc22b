"""Which points of a sparse model lie on the sheet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..arrays import Array
from ..numeric.local_fit import local_fits
from ..numeric.polygon import inside_polygon
from ..numeric.robust import MAD_TO_SIGMA
from ..sparse_model import FEWEST_VIEWS, SparseModel
from .outline import Outline

_NEIGHBOURS = 16


def points_on_sheet(model: SparseModel, reference: int, outline: Outline) -> NDArray[np.bool_]:
    """The points of the sheet, without those of the desk beside it or under it.

    What was seen in the reference photo inside the outline is on the sheet: the paper hides what lies behind it. A
    point that was not seen there, though it falls inside, counts if it lies on the surface that the others around it
    make.

    Parameters
    ----------
    model : SparseModel
    reference : int
        Index into ``model.cameras`` of the photo that the outline is of.
    outline : Outline

    Returns
    -------
    (N,) bool array
        Only points seen in at least three photos.
    """
    camera = model.cameras[reference]
    often = model.views_per_point() >= FEWEST_VIEWS
    in_camera = camera.to_camera_frame(model.points)
    pixels = camera.project(model.points)
    candidate = often & np.isfinite(pixels).all(axis=1)
    candidate[candidate] = inside_polygon(pixels[candidate], outline.polygon)
    seen = np.zeros(len(model.points), bool)
    seen[model.observed_point[model.observed_camera == reference]] = True
    core = candidate & seen
    if core.sum() <= _NEIGHBOURS:
        return core
    inverse_depth = 1 / np.where(candidate, in_camera[:, 2], 1.0)
    misfit, _ = _misfit(pixels[core], inverse_depth[core], pixels[core], inverse_depth[core], skip=1)
    noise = MAD_TO_SIGMA * float(np.median(misfit))
    result = core.copy()
    rest = candidate & ~seen
    if rest.any():
        off, spread = _misfit(pixels[core], inverse_depth[core], pixels[rest], inverse_depth[rest], skip=0)
        # Wide, for points beside a crease lie off every plane and are those that show where it is.
        result[rest] = off < np.clip(4 * spread, 6 * noise, 50 * noise)
    return result


def _misfit(known: Array, values: Array, asked: Array, asked_values: Array, skip: int) -> tuple[Array, Array]:
    """Distance of each asked value from the robust plane through its nearest known ones, and these ones' own scatter.

    Inverse depth over pixels is a plane where the surface is one, so planes serve well over short distances.
    """
    tree = cKDTree(known)
    _, near = tree.query(asked, k=_NEIGHBOURS + skip)
    near = near[:, skip:]
    offset = known[near] - asked[:, None]
    scale = np.abs(offset).max(axis=(1, 2), keepdims=True)
    basis = np.concatenate([np.ones_like(offset[..., :1]), offset / np.maximum(scale, 1e-12)], axis=2)
    value = values[near]
    unit = MAD_TO_SIGMA * np.median(np.abs(value - np.median(value, axis=1, keepdims=True)), axis=1, keepdims=True)

    def reweighed(residual: Array) -> Array:
        trust = 1 / np.maximum(residual, 1e-3 * unit + 1e-15)
        return trust / trust.max(axis=1, keepdims=True)

    plane, residual = local_fits(basis, value[..., None], np.ones_like(value), reweighed, rounds=5, ridge=1e-6)
    return np.abs(asked_values - plane[:, 0, 0]), MAD_TO_SIGMA * np.median(residual, axis=1)
