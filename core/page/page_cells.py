"""A page in coarse cells: which photos see a cell and how large, and the way back to full size."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import gaussian_mean
from ..sheet import FlatMap, Sheet
from .photo_colors import Photo
from .raster import PageLookup, interpolate, rasterize

ReadPhoto = Callable[[int], Photo]

# Values without a figure are choices; no measurement of them is recorded.
# Added to brightness before its logarithm: noise in the dark must not count as detail, nor slightly blacker print as
# shadow.
_DARKEST = 0.05

_FRAME_MARGIN = 0.01  # of the photo's longer side: its very edge is not used
_Z_BUFFER = 640  # pixels along the longer side
_BEHIND = 0.005  # of the sheet's extent, by which a hidden part lies at least behind another; a choice
_LEAST_KNOWN = 1e-4  # share of the surroundings; if less is known, the nearest mean counts


def projected_area(sheet: Sheet, flat: FlatMap, lookup: PageLookup, camera: Camera) -> NDArray[np.float32]:
    """Photo pixels per page area at each cell; 0 where the printed side is turned away or there is no sheet."""
    areas = []
    for corners in (camera.project(sheet.vertices)[sheet.triangles], flat.uv[sheet.triangles]):
        a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        areas.append(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    in_photo, on_page = areas
    density = np.nan_to_num(in_photo / np.where(on_page == 0, np.inf, on_page)).clip(min=0)
    return np.where(lookup.triangle >= 0, density[lookup.triangle], 0).astype(np.float32)


def visible_cells(sheet: Sheet, lookup: PageLookup, camera: Camera, position: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Which page cells the camera sees: inside its frame and not behind another part of the sheet."""
    margin = _FRAME_MARGIN * max(camera.width, camera.height)
    limits = np.array([camera.width, camera.height]) - margin
    with np.errstate(invalid="ignore"):
        inside = ((position > margin) & (position < limits)).all(axis=-1)
    facing = _facing(sheet, camera)
    if facing.all():  # then no part of the paper is behind another
        return inside & (lookup.triangle >= 0)
    scale = _Z_BUFFER / max(camera.width, camera.height)
    depth = camera.to_camera_frame(sheet.vertices)[:, 2:]
    far_to_near = np.argsort(-depth[sheet.triangles, 0].mean(axis=1), kind="stable")
    triangles = sheet.triangles[far_to_near]
    size = (int(np.ceil(camera.width * scale)), int(np.ceil(camera.height * scale)))
    nearest = interpolate(rasterize(camera.project(sheet.vertices) * scale, triangles, size), triangles, depth)
    # The surface may already be a little farther away beside a pixel: the farthest neighbour counts.
    nearest = ndimage.maximum_filter(np.nan_to_num(nearest[..., 0], nan=np.inf), 3)
    column, row = np.moveaxis(np.nan_to_num(position * scale).astype(int), -1, 0)
    own = interpolate(lookup, sheet.triangles, depth)[..., 0]
    tolerance = _BEHIND * np.ptp(sheet.vertices, axis=0).max()
    with np.errstate(invalid="ignore"):
        unhidden = own <= nearest[row.clip(0, size[1] - 1), column.clip(0, size[0] - 1)] + tolerance
    # A hidden part is enlarged by a cell, because the reconstructed edge may be slightly off.
    hidden = ndimage.binary_dilation(inside & ~unhidden)
    return inside & ~hidden & facing[lookup.triangle] & (lookup.triangle >= 0)


def _facing(sheet: Sheet, camera: Camera) -> NDArray[np.bool_]:
    """Which triangles turn their printed side to the camera, (F,)."""
    corner = sheet.vertices[sheet.triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return np.einsum("fi,fi->f", normal, camera.center - corner[:, 0]) > 0


def log_brightness(page: NDArray[np.float32]) -> NDArray[np.float32]:
    """Logarithm of brightness, which turns a change of exposure or light into a difference."""
    return np.log(page + np.float32(_DARKEST))


def smooth_known(values: NDArray[np.float32], known: NDArray[np.bool_], sigma: float) -> NDArray[np.float32]:
    """Gaussian mean of the known values (h, w) or (h, w, c); near unknown ones only the known count."""
    mean, share = gaussian_mean(values, known, sigma, _LEAST_KNOWN)
    nearest = ndimage.distance_transform_edt(share < _LEAST_KNOWN, return_distances=False, return_indices=True)
    return mean[tuple(nearest)]


def enlarge(coarse: NDArray[np.float32], shape: tuple[int, ...], rows: slice = slice(None)) -> NDArray[np.float32]:
    """Linear between the centres of the coarse cells: a picture of that shape, or some of its rows."""
    row = (np.arange(shape[0])[rows] + 0.5) * (coarse.shape[0] / shape[0]) - 0.5
    column = (np.arange(shape[1]) + 0.5) * (coarse.shape[1] / shape[1]) - 0.5
    return between_cells(coarse, row, column)


def enlarge_rows(cells: NDArray[np.float32], per_cell: float, rows: slice, width: int) -> NDArray[np.float32]:
    """Some rows of a picture of this width, linear between the centres of its cells of ``per_cell`` pixels."""
    row, column = ((np.arange(*ends) + 0.5) / per_cell - 0.5 for ends in ((rows.start, rows.stop), (0, width)))
    return between_cells(cells, row, column)


def between_cells(coarse: NDArray[np.float32], row: Array, column: Array) -> NDArray[np.float32]:
    """Values (H, W, ...) at rows (H,) and columns (W,), counted in cells from the first one's centre."""
    for axis, at in ((0, row), (1, column)):
        low = np.clip(np.floor(at).astype(int), 0, coarse.shape[axis] - 1)
        high = np.minimum(low + 1, coarse.shape[axis] - 1)
        part = np.clip(at - low, 0, 1).astype(np.float32)
        part = part.reshape([-1 if k == axis else 1 for k in range(coarse.ndim)])
        lower = np.take(coarse, low, axis=axis)
        coarse = lower + part * (np.take(coarse, high, axis=axis) - lower)
    return coarse
