"""The page image from the photos: from the reference photo alone, or from the best one for each region."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from scipy import ndimage

from ..camera import Camera
from ..sheet import FlatMap, Sheet
from ..watch import SILENT, Watch
from .page_cells import EDGE_CELLS, ReadPhoto
from .page_light import even_light
from .photo_alignment import align_photos
from .photo_blending import Blend, blend_photos
from .photo_choice import photo_weights, view_cells
from .texture import PageTexture
from .warp import page_lookup, photo_positions, sample

Source = Literal["reference", "best"]


def render_page(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    size_px: tuple[int, int],
    source: Source = "reference",
    watch: Watch = SILENT,
) -> PageTexture:
    """Make the page image.

    Parameters
    ----------
    sheet : Sheet
    flat : FlatMap
    cameras : sequence of Camera
    read_photo : callable
        ``read_photo(index)`` gives the pixels (h, w, 3), uint8 or uint16, of ``cameras[index]``. Photos are asked for
        one by one and not kept.
    reference : int
        Index of the reference photo.
    size_px : (width, height)
        Of the page image.
    source : {"reference", "best"}
        ``"reference"``: from the reference photo alone, whose colours stay untouched. ``"best"``: each region from
        the photo that shows most of it, by projected area times sharpness, with the light evened between photos.
    watch : Watch

    Raises
    ------
    Cancelled
    """
    if source not in ("reference", "best"):
        raise ValueError(f"source must be 'reference' or 'best', not {source!r}")
    lookup = page_lookup(sheet, flat, size_px)
    watch.step(0.1, "Sampling the photo")
    if source == "reference" or len(cameras) == 1:
        position = photo_positions(sheet, lookup, cameras[reference])
        image = sample(read_photo(reference), position)
        covered = np.isfinite(position[..., 0])
        photo = np.where(covered, reference, -1).astype(np.int16)
        return PageTexture(image, photo, position, float(1 - covered.mean()))
    blend = _blend_of_best(sheet, flat, cameras, read_photo, reference, max(size_px), watch.part(0.1, 0.5))
    return blend_photos(sheet, lookup, cameras, read_photo, blend, watch.part(0.5, 1))


def _blend_of_best(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    longest: int,
    watch: Watch,
) -> Blend:
    """Each region from the photo that shows most of it, in one light, with the print of all where the reference has it.

    ``longest`` is the page image's longer side in pixels.
    """
    views = view_cells(sheet, flat, cameras, read_photo, reference, watch.part(0, 0.6))
    weight = photo_weights(views)
    inner = ndimage.binary_erosion(views.page, iterations=EDGE_CELLS)
    gain = even_light(views.color, views.visible & inner, reference)
    shift = align_photos(sheet, flat, cameras, read_photo, reference, weight, longest, watch.part(0.6, 1))
    return Blend(weight, gain, shift)
