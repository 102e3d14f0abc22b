"""What a photo shows, in short: how sharp it is, and a small picture to compare it with others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage

from ..arrays import Array
from ..numeric.image import Image, sharpness, shrink

# Values without a figure are choices; no measurement of them is recorded.
# The long side of a photo whose sharpness is measured: the blur that spoils print shows at this size.
SHARPNESS_SIDE = 1280  # pixels
# Sharpness is measured in squares around places so far apart, with sides twice the second; they cover the photo.
_APART, _AROUND = 16, 12  # pixels
# The long side of a thumbnail. Print melts into grey at this size, while the sheet's edges still move by about a pixel
# where the camera moves by 2 % of its distance.
_THUMBNAIL = 64  # pixels
# Only what is smaller than this counts (standard deviation), because a pale sheet on a dark table is much alike from
# everywhere.
_LARGEST_DETAIL = 8  # pixels of the thumbnail
# A hand that holds the camera still turns it by a degree or so, which moves the picture but shows nothing new.
_TURN, _STEPS = 4, 4  # pixels of the thumbnail, and steps of each in which shifts are tried

_NOTHING = 1e-9  # grey levels: the thumbnail of a photo of one tone has less


@dataclass(frozen=True)
class View:
    """What a photo shows, in short.

    Attributes
    ----------
    sharpness : float
        As `image.sharpness` gives it for the whole photo.
    thumbnail : (h, w) array
        Lightness without its coarse shades; fades to 0 at the border, has norm 1 (a photo of one tone is 0 everywhere).
    """

    sharpness: float
    thumbnail: Array


def view_of(photo: Image) -> View:
    """Look at a photo.

    Parameters
    ----------
    photo : (h, w, 3) uint8 or uint16 array
    """
    lightness = _lightness(photo)
    small = shrink(lightness, max(1, -(-max(lightness.shape) // _THUMBNAIL))).astype(float)
    small -= ndimage.gaussian_filter(small, _LARGEST_DETAIL)
    small *= np.outer(*(np.hanning(side + 2)[1:-1] for side in small.shape))
    return View(_sharpness(lightness), small / max(float(np.linalg.norm(small)), _NOTHING))


def sharpness_of(photo: Image) -> float:
    """How sharp a photo (h, w, 3) is on the whole, as `image.sharpness` gives it."""
    return _sharpness(_lightness(photo))


def _lightness(photo: Image) -> NDArray[np.float32]:
    return np.asarray(shrink(photo, -(-max(photo.shape[:2]) // SHARPNESS_SIDE)).mean(axis=2))


def _sharpness(lightness: NDArray[np.float32]) -> float:
    rows, columns = (np.arange(0, side, _APART) for side in lightness.shape)
    places = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2).astype(float)
    return sharpness(lightness, places, _AROUND)


def likeness(first: View, second: View) -> float:
    """How alike two views are: at most 1, for equal ones that differ by a small turn of the camera; 0 across formats.

    The highest correlation of the thumbnails over the shifts that an unsteady hand causes.
    """
    if first.thumbnail.shape != second.thumbnail.shape:
        return 0.0
    # Padded, so that what leaves on one side does not come back on the other.
    shape = [side + _TURN for side in first.thumbnail.shape]
    spectrum = fft.fft2(first.thumbnail, shape) * np.conj(fft.fft2(second.thumbnail, shape))
    # The correlation at fractions of a pixel is that of a spectrum with zeros around it.
    between = [(_STEPS - 1) * side for side in shape]
    padding = [(total // 2, total - total // 2) for total in between]
    fine = fft.ifft2(fft.ifftshift(np.pad(fft.fftshift(spectrum), padding))).real * _STEPS**2
    shifts = np.arange(-_TURN * _STEPS, _TURN * _STEPS + 1)
    return float(fine[np.ix_(shifts, shifts)].max())
