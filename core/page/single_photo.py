"""The page image from the reference photo alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..camera import Camera
from ..sheet import FlatMap, Sheet
from .page_cells import ReadPhoto
from .photo_colors import sample
from .raster import page_lookup
from .texture import PageTexture
from .warp import photo_positions


def page_of_photo(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    size_px: tuple[int, int],
) -> PageTexture:
    """Make the page image from the reference photo, whose colours stay untouched.

    Parameters
    ----------
    sheet : Sheet
    flat : FlatMap
    cameras : sequence of Camera
    read_photo : callable
        ``read_photo(index)`` gives the pixels (h, w, 3), uint8 or uint16, of ``cameras[index]``.
    reference : int
        Index of the reference photo.
    size_px : (width, height)
        Of the page image.
    """
    position = photo_positions(sheet, page_lookup(sheet, flat, size_px), cameras[reference])
    image = sample(read_photo(reference), position)
    covered = np.isfinite(position[..., 0])
    photo = np.where(covered, reference, -1).astype(np.int16)
    return PageTexture(image, photo, position, float(1 - covered.mean()))
