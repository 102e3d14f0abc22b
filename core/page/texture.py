"""The page image as a noun: its pixels, and where each is from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .photo_colors import Photo


@dataclass(frozen=True)
class PageTexture:
    """The page image and where it comes from.

    Attributes
    ----------
    image : (H, W, 3) array
        Of the reference photo's type; white where no photo shows the page.
    photo : (H, W) int16 array
        Which photo each pixel is from (the one with the most weight where two are blended), -1 for none.
    position : (H, W, 2) float32 array
        Where in that photo, distorted pixels; NaN for none.
    blank_share : float
        Share of the page's pixels that are in no photo or outside the mesh.
    """

    image: Photo
    photo: NDArray[np.int16]
    position: NDArray[np.float32]
    blank_share: float
