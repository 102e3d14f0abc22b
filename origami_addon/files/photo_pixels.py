"""The pixels of a model's photos, read on demand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...core.errors import UnusablePhotos
from ...core.numeric.image import reduced
from ...core.photos.view import sharpness_of
from ...core.sparse_model import SparseModel
from .decoded_photo import Image
from .photos import Photo, read_pixels

Reduced = NDArray[np.float32]


class PhotoPixels(Sequence[Image]):
    """The pixels of the photos of a model's cameras, read when asked for and not kept.

    Raises
    ------
    UnusablePhotos
        If a camera's photo is gone or has another size.
    """

    def __init__(self, photos: Sequence[Photo], model: SparseModel) -> None:
        by_name = {photo.name: photo for photo in photos}
        for camera in model.cameras:
            photo = by_name.get(camera.name)
            if photo is None:
                raise UnusablePhotos(
                    f"The photo {camera.name} was placed and can no longer be used: put its file back as it was, or "
                    "leave it out and place the photos again."
                )
            if (photo.width, photo.height) != (camera.width, camera.height):
                raise UnusablePhotos(
                    f"The photo {camera.name} has {photo.width} x {photo.height} pixels, and had {camera.width} x "
                    f"{camera.height} when it was placed: put its file back as it was, or place the photos again."
                )
        self.photos = [by_name[camera.name] for camera in model.cameras]

    def __len__(self) -> int:
        return len(self.photos)

    def __getitem__(self, index: int) -> Image:  # type: ignore[override]  # nobody slices it
        return read_pixels(self.photos[index])


class JudgedPixels(PhotoPixels):
    """As `PhotoPixels`, and how sharp each photo is that was read.

    Attributes
    ----------
    sharpness : dict of str to float
        By the photo's name, as `image.sharpness` gives it for the whole photo.
    """

    def __init__(self, photos: Sequence[Photo], model: SparseModel) -> None:
        super().__init__(photos, model)
        self.sharpness: dict[str, float] = {}

    def __getitem__(self, index: int) -> Image:  # type: ignore[override]  # nobody slices it
        photo = super().__getitem__(index)
        self.sharpness[self.photos[index].name] = sharpness_of(photo)
        return photo


class ReducedPhotos(Sequence[Reduced]):
    """Photos as `image.reduced` gives them, each made when it is first asked for, and kept."""

    def __init__(self, photos: Sequence[Image]) -> None:
        self._photos = photos
        self._reduced: dict[int, Reduced] = {}

    def __len__(self) -> int:
        return len(self._photos)

    def __getitem__(self, index: int) -> Reduced:  # type: ignore[override]  # nobody slices it
        if index not in self._reduced:
            self._reduced[index] = reduced(self._photos[index])
        return self._reduced[index]
