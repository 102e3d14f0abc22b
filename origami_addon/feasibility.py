"""Whether what the settings ask of the photos can be done at all, before anything is computed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..core.errors import UsageError
from ..core.page.resolution import MILLIMETRES_PER_INCH
from .files.photos import Photo, read_pixels
from .settings import RunSettings

# What a TIFF can point to, less its header and colour profile.
_MOST_PAGE_BYTES = 2**32 - 2**24


def check_reference(photos: Sequence[Photo], settings: RunSettings) -> Photo | None:
    """The reference photo that the settings name; None where they name none.

    Raises
    ------
    UsageError
        If it is not one of the photos, could be several of them, or the settings' outline or creases leave it.
    """
    if settings.reference is None:
        return None
    named = [photo for photo in photos if photo.name == settings.reference]
    parts = Path(settings.reference).parts
    named = named or [photo for photo in photos if photo.path.parts[-len(parts) :] == parts]
    if not named:
        names = ", ".join(photo.name for photo in photos)
        raise UsageError(f"There is no photo {settings.reference} to be the reference; choose one of {names}.")
    if len(named) > 1:
        names = " or ".join(photo.name for photo in named)
        raise UsageError(f"{len(named)} photos are called {settings.reference}; say which is the reference: {names}.")
    (photo,) = named
    size = np.array([photo.width, photo.height])
    corners = np.array(settings.outline or ((0.0, 0.0),))
    if (corners < 0).any() or (corners > size).any():
        raise UsageError(
            f"The outline leaves the photo {photo.name}, which has {photo.width} x {photo.height} pixels; give its "
            "corners in pixels of the file as stored, before any rotation that its EXIF asks for."
        )
    ends = np.array(settings.creases or ((0.0, 0.0),)).reshape(-1, 2)
    if (ends < 0).any() or (ends > size).any():
        raise UsageError(
            f"A crease leaves the photo {photo.name}, which has {photo.width} x {photo.height} pixels; give the "
            "creases' ends in pixels of the file as stored, before any rotation that its EXIF asks for."
        )
    return photo


def check_page_size(photos: Sequence[Photo], settings: RunSettings) -> None:
    """Look whether a page of known size in pixels could be written, before anything is computed.

    Raises
    ------
    UsageError
        If it has too many bytes.
    """
    size, dpi = settings.page.paper_size_mm, settings.image.dpi
    if size is None or size[1] is None or dpi is None:
        return
    reference = check_reference(photos, settings)
    width, height = (round(side * dpi / MILLIMETRES_PER_INCH) for side in (size[0], size[1]))
    check_page_bytes(width, height, photos if reference is None else [reference])


def check_page_bytes(width: int, height: int, photos: Sequence[Photo]) -> None:
    """Refuse a page with more bytes than a TIFF may have, if each of the photos that it could be made of is so deep.

    Raises
    ------
    UsageError
    """
    samples = 3 * width * height
    if samples * 2 <= _MOST_PAGE_BYTES:
        return
    if samples > _MOST_PAGE_BYTES or all(read_pixels(photo).dtype == np.uint16 for photo in photos):
        raise UsageError(
            f"The page would be {width} x {height} pixels, more than 4 GiB, which a TIFF cannot hold; "
            "choose a smaller resolution (--dpi, or Resolution in Blender)."
        )
