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

# A point is compared with the robust plane through this many neighbours, found in this many rounds of least squares, in
# which residuals below this share of the scatter count alike. Choices; no measurement of them is recorded.
_NEIGHBOURS, _ROUNDS, _SMALL = 16, 5, 1e-3
_RIDGE = 1e-6  # on the diagonal of the normal equations: neighbours in a row determine no plane
# A point that the reference photo does not show may be this many times the scatter of its neighbours off their plane,
# but at least and at most this many times the noise of all points. Wide, because points beside a crease are off every
# plane and show where it is (XII: 1.04 px with a strict limit, 0.81 px with this one).
_OF_SCATTER, _LEAST_OF_NOISE, _MOST_OF_NOISE = 4, 6, 50


def points_on_sheet(model: SparseModel, reference: int, outline: Outline) -> NDArray[np.bool_]:
    """The points of the sheet, without those of the table beside or under it.

    A point that the reference photo shows inside the outline is on the sheet, because paper hides what is behind it.
    Other points that project into the outline count if they are on the surface of the points around them. Print that
    repeats, as a calibration target's, can leave the reference photo with hardly a point on the sheet; then those count
    that lie in one plane with most of the others.

    Parameters
    ----------
    model : SparseModel
    reference : int
        Index into ``model.cameras`` of the photo that the outline is of.
    outline : Outline

    Returns
    -------
    (N,) bool array
        True only for points seen in at least three photos.
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
    inverse_depth = 1 / np.where(candidate, in_camera[:, 2], 1.0)
    if core.sum() <= _NEIGHBOURS:
        core[candidate] |= _on_one_plane(pixels[candidate], inverse_depth[candidate])
        return core
    misfit, _ = _misfit(pixels[core], inverse_depth[core], pixels[core], inverse_depth[core], skip=1)
    noise = MAD_TO_SIGMA * float(np.median(misfit))
    result = core.copy()
    rest = candidate & ~seen
    if rest.any():
        off, spread = _misfit(pixels[core], inverse_depth[core], pixels[rest], inverse_depth[rest], skip=0)
        result[rest] = off < np.clip(_OF_SCATTER * spread, _LEAST_OF_NOISE * noise, _MOST_OF_NOISE * noise)
    return result


def _misfit(known: Array, values: Array, asked: Array, asked_values: Array, skip: int) -> tuple[Array, Array]:
    """Distance of each asked value from the robust plane through its nearest known ones, and these ones' own scatter.

    Inverse depth over pixels is a plane where the surface is one, so planes serve well over short distances.
    """
    tree = cKDTree(known)
    _, near = tree.query(asked, k=_NEIGHBOURS + skip)
    near = near[:, skip:]
    at_asked, residual = _planes(known[near] - asked[:, None], values[near])
    return np.abs(asked_values - at_asked), MAD_TO_SIGMA * np.median(residual, axis=1)


def _on_one_plane(pixels: Array, inverse_depth: Array) -> NDArray[np.bool_]:
    """Which points (N, 2) are on the robust plane through most of them; none if so few are there that all would be."""
    if len(pixels) <= _NEIGHBOURS:
        return np.zeros(len(pixels), bool)
    _, residual = _planes((pixels - pixels.mean(axis=0))[None], inverse_depth[None])
    return residual[0] < _LEAST_OF_NOISE * MAD_TO_SIGMA * np.median(residual)


def _planes(offset: Array, value: Array) -> tuple[Array, Array]:
    """Robust planes through ``value`` (M, K) at ``offset`` (M, K, 2): their values at 0 (M,), and residuals (M, K)."""
    scale = np.abs(offset).max(axis=(1, 2), keepdims=True)
    basis = np.concatenate([np.ones_like(offset[..., :1]), offset / np.maximum(scale, 1e-12)], axis=2)
    unit = MAD_TO_SIGMA * np.median(np.abs(value - np.median(value, axis=1, keepdims=True)), axis=1, keepdims=True)

    def reweighed(residual: Array) -> Array:
        trust = 1 / np.maximum(residual, _SMALL * unit + 1e-15)
        return trust / trust.max(axis=1, keepdims=True)

    plane, residual = local_fits(basis, value[..., None], np.ones_like(value), reweighed, rounds=_ROUNDS, ridge=_RIDGE)
    return plane[:, 0, 0], residual
