"""The page in shades of grey: the luminance of its colours."""

from __future__ import annotations

import typing

import numpy as np

from ..numeric.image import Image, encoded, linear_light

_ROWS = 256  # of the page image at once


def greyscale(image: Image, luminance: tuple[float, float, float]) -> Image:
    """Luminance of each pixel, as a level of the same curve as the colours'.

    Light is added up, not levels: a pixel half covered by black ink and a screen of black dots keep their brightness.

    Parameters
    ----------
    image : (H, W, 3) uint8 or uint16 array
        With the tone curve of sRGB.
    luminance : tuple of float
        Shares of red, green and blue light in luminance; their sum is 1.

    Returns
    -------
    (H, W) array
        Of the image's type.

    Examples
    --------
    >>> colors = np.array([[[255, 255, 255], [100, 100, 100], [0, 255, 0]]], np.uint8)
    >>> greyscale(colors, (0.2126, 0.7152, 0.0722)).tolist()
    [[255, 100, 220]]
    """
    shares = np.array(luminance, np.float32)
    grey = np.empty(image.shape[:2], image.dtype)
    for top in range(0, len(image), _ROWS):
        rows = slice(top, top + _ROWS)
        grey[rows] = encoded(linear_light(image[rows]) @ shares, image.dtype)
    return typing.cast(Image, grey)
