"""Align the print of several photos, which a slightly wrong surface displaces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..camera import Camera
from ..sheet import FlatMap, Sheet
from ..watch import SILENT, Watch
from .page_cells import CELLS, EDGE_CELLS, LEAST_WEIGHT, ReadPhoto, brightness, log_brightness
from .registration import FARTHEST, displacement
from .warp import page_lookup, photo_positions, sample

_ALIGNED_AT = 1000  # pixels of the page's longer side at which photos are aligned; a choice


def align_photos(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    weight: NDArray[np.float32],
    longest: int,
    watch: Watch = SILENT,
) -> NDArray[np.float32]:
    """Find how far the print of each photo is displaced from the reference's.

    The surface is never exact: if a point of it is a little too high, each photo shows another place there.

    Parameters
    ----------
    sheet : Sheet
    flat : FlatMap
    cameras : sequence of Camera
    read_photo : callable
        As for `render.render_page`.
    reference : int
        Index of the reference photo.
    weight : (n, h, w) array
        How much of each photo is taken; photos of which nothing is taken are skipped.
    longest : int
        The page image's longer side in pixels.
    watch : Watch

    Returns
    -------
    (n, h, w, 2) float32 array
        In widths and heights of the page.

    Raises
    ------
    Cancelled
    """
    shift = np.zeros((*weight.shape, 2), np.float32)
    longest = min(longest, _ALIGNED_AT)
    scale = longest / max(flat.width, flat.height)
    size = (max(2, round(flat.width * scale)), max(2, round(flat.height * scale)))
    lookup = page_lookup(sheet, flat, size)
    # At the very edge, the table would be aligned with the table.
    inner = ndimage.binary_erosion(lookup.triangle >= 0, iterations=max(1, round(EDGE_CELLS * longest / CELLS)))

    def page_of(index: int) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        position = photo_positions(sheet, lookup, cameras[index])
        page = log_brightness(brightness(sample(read_photo(index), position)).mean(axis=2))
        return page, np.isfinite(position[..., 0]) & inner

    used = [k for k in range(len(cameras)) if k != reference and weight[k].max() > LEAST_WEIGHT]
    if not used:
        return shift
    fixed, fixed_known = page_of(reference)
    for done, index in enumerate(used):
        watch.step(done / len(used), "Aligning the photos")
        moving, known = page_of(index)
        moved = displacement(fixed, moving, known & fixed_known, FARTHEST * longest)
        zoom = (weight.shape[1] / size[1], weight.shape[2] / size[0])
        for axis in (0, 1):
            coarse = ndimage.zoom(moved[..., axis] / size[axis], zoom, order=1, grid_mode=True, mode="nearest")
            shift[index, ..., axis] = coarse
    return shift
