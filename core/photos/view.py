"""What a photo shows, in short: how sharp it is, and a small picture to compare it with others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import fft

from ..arrays import Array
from ..numeric.image import Image, sharpness, shrink

# The long side of a photo whose sharpness is measured: the blur that spoils print shows at this size.
SHARPNESS_SIDE = 1280  # pixels
# Sharpness is measured in squares around places so far apart, with sides twice the second; they cover the photo.
_APART, _AROUND = 16, 12  # pixels
# The long side of a thumbnail. Print melts into grey at this size, while the sheet's edges still move by about a pixel
# where the camera moves by 2 % of its distance.
_THUMBNAIL = 64  # pixels
# A hand that holds the camera still turns it by a degree or so, which moves the picture but shows nothing new.
_TURN = 4  # pixels of the thumbnail


@dataclass(frozen=True)
class View:
    """What a photo shows, in short.

    Attributes
    ----------
    sharpness : float
        As `image.sharpness` gives it for the whole photo.
    thumbnail : (h, w) array
        Lightness; fades to its mean at the border, has mean 0 and norm 1 (a photo of one tone is 0 everywhere).
    """

    sharpness: float
    thumbnail: Array


def view_of(photo: Image) -> View:
    """Look at a photo.

    Parameters
    ----------
    photo : (h, w, 3) uint8 or uint16 array
    """
    longest = max(photo.shape[:2])
    lightness = shrink(photo, -(-longest // SHARPNESS_SIDE)).mean(axis=2)
    rows, columns = (np.arange(0, side, _APART) for side in lightness.shape)
    places = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2).astype(float)
    small = shrink(lightness, max(1, -(-max(lightness.shape) // _THUMBNAIL))).astype(float)
    window = np.outer(*(np.hanning(side + 2)[1:-1] for side in small.shape))
    faded = window * (small - (window * small).sum() / window.sum())
    norm = np.linalg.norm(faded)
    return View(sharpness(lightness, places, _AROUND), faded / norm if norm > 0 else faded)


def likeness(first: View, second: View) -> float:
    """How alike two views are: at most 1, for equal ones that differ by a small turn of the camera; 0 across formats.

    The highest correlation of the thumbnails over the shifts that an unsteady hand causes.
    """
    shape = first.thumbnail.shape
    if second.thumbnail.shape != shape:
        return 0.0
    # Padded, so that what leaves on one side does not come back on the other.
    padded = [side + _TURN for side in shape]
    correlation = fft.irfft2(fft.rfft2(first.thumbnail, padded) * np.conj(fft.rfft2(second.thumbnail, padded)), padded)
    shifts = np.arange(-_TURN, _TURN + 1)
    return float(correlation[np.ix_(shifts, shifts)].max())
