"""Between a photo and the page: where a page pixel lies in a photo, and where a photo's pixels lie on the page."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..camera import Camera
from ..sheet import FlatMap, Sheet
from .raster import PageLookup, interpolate, rasterize

_BAND = 1 << 18  # pixels processed at once: their temporaries fit about into the processor's cache
_NO_AREA = 1e-9  # a triangle's area on the page, as a share of the largest, below which it shows nothing


def photo_positions(sheet: Sheet, lookup: PageLookup, camera: Camera) -> NDArray[np.float32]:
    """The place of each page pixel in a photo.

    The point of the sheet under the pixel is projected, with lens distortion. Interpolating the vertices' pixels
    instead would bend straight lines inside large triangles.

    Returns
    -------
    (H, W, 2) float32 array
        Distorted pixels; NaN where the page has no triangle, and where the point is behind the camera or outside
        the photo's frame.
    """
    shape = lookup.triangle.shape
    in_camera = camera.to_camera_frame(sheet.vertices)
    out = np.empty((lookup.triangle.size, 2), np.float32)
    rows = max(1, _BAND // shape[1])
    for begin in range(0, shape[0], rows):
        band = slice(begin, begin + rows)
        part = PageLookup(lookup.triangle[band], lookup.barycentric[band])
        point = interpolate(part, sheet.triangles, in_camera).reshape(-1, 3)
        with np.errstate(invalid="ignore", divide="ignore"):
            pixels = camera.distort(point[:, :2] / np.where(point[:, 2:] > 0, point[:, 2:], np.nan))
            x, y = pixels.T
            inside = (x >= 0) & (x <= camera.width) & (y >= 0) & (y <= camera.height)
        out[begin * shape[1] : begin * shape[1] + len(pixels)] = np.where(inside[:, None], pixels, np.nan)
    return out.reshape(*shape, 2)


def native_size(sheet: Sheet, flat: FlatMap, camera: Camera) -> float:
    """Page pixels per page unit at which the page has the photo's own pixel density.

    The density of a photo changes over the page, and with the direction where the sheet is seen at an angle. Of
    the two directions the denser counts; over the page it is the median.
    """
    pixels = camera.project(sheet.vertices)[sheet.triangles]
    page = flat.uv[sheet.triangles]
    edges_photo = np.stack([pixels[:, 1] - pixels[:, 0], pixels[:, 2] - pixels[:, 0]], axis=-1)
    edges_page = np.stack([page[:, 1] - page[:, 0], page[:, 2] - page[:, 0]], axis=-1)
    area = np.abs(np.linalg.det(edges_page))
    usable = np.isfinite(edges_photo).all(axis=(1, 2)) & (area > area.max() * _NO_AREA)
    jacobian = edges_photo[usable] @ np.linalg.inv(edges_page[usable])
    density = np.linalg.norm(jacobian, ord=2, axis=(1, 2))
    order = np.argsort(density)
    share = np.cumsum(area[usable][order])
    return float(density[order][np.searchsorted(share, share[-1] / 2)])


def photo_to_page(sheet: Sheet, flat: FlatMap, camera: Camera, step: int) -> NDArray[np.float32]:
    """The places of a photo's pixels on the page.

    Parameters
    ----------
    step : int
        Distance in pixels between two entries.

    Returns
    -------
    (ceil(h / step), ceil(w / step), 2) float32 array
        Entry ``[r, c]`` is for the photo's pixel position ``((c + 0.5) step, (r + 0.5) step)``: the u, v seen there in
        the flat map's unit, NaN outside the sheet.
    """
    pixels = camera.project(sheet.vertices) / step
    depth = camera.to_camera_frame(sheet.vertices)[:, 2]
    far_to_near = np.argsort(-depth[sheet.triangles].mean(axis=1), kind="stable")
    triangles = sheet.triangles[far_to_near]
    lookup = rasterize(pixels, triangles, (-(-camera.width // step), -(-camera.height // step)))
    return interpolate(lookup, triangles, flat.uv).astype(np.float32)
