"""Small image helpers: linear light, grey, a perceptual colour space, shrinking, smoothing, sampling, sharpness."""

from __future__ import annotations

import typing
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array

Image = NDArray[np.uint8] | NDArray[np.uint16]

# Ottosson, "A perceptual color space for image processing", 2020: linear sRGB to cone responses, and these to Oklab.
_LINEAR_TO_CONES = np.array(
    [[0.4122214708, 0.5363325363, 0.0514459929],
     [0.2119034982, 0.6806995451, 0.1073969566],
     [0.0883024619, 0.2817188376, 0.6299787005]]
)  # fmt: skip
_CONES_TO_LAB = np.array(
    [[0.2104542553, 0.7936177850, -0.0040720468],
     [1.9779984951, -2.4285922050, 0.4505937099],
     [0.0259040371, 0.7827717662, -0.8086757660]]
)  # fmt: skip


_BAND = 1 << 20  # pixels that are decoded at once
# Weights of lightness and of both opponent colours where colours are compared: a shadow changes lightness alone, so the
# others count double. A choice; no measurement of it is recorded.
COLOR_WEIGHTS = np.array([1.0, 2.0, 2.0], np.float32)
# Scales of the two kinds of detail whose ratio is sharpness (standard deviations, pixels): one octave apart, so that
# the ratio depends on blur and not on print.
_FINE, _COARSE = 1.0, 2.0
# Above this mean, all pixels of a block are in a mask: one of 100 and more is missing otherwise only from rounding.
_WHOLE = 0.99


def linear_light(photo: Image) -> NDArray[np.float32]:
    """Decode sRGB.

    Parameters
    ----------
    photo : (h, w, 3) or (h, w) uint8 or uint16 array
        sRGB. Grey pictures become three equal channels.

    Returns
    -------
    (h, w, 3) float32 array
        Linear light, 0 to 1.

    Raises
    ------
    ValueError
        If the array is of another type or shape.
    """
    if photo.dtype not in (np.uint8, np.uint16) or photo.ndim not in (2, 3):
        raise ValueError(f"a photo is an (h, w, 3) array of uint8 or uint16, not {photo.shape} of {photo.dtype}")
    if photo.ndim == 2:
        photo = np.repeat(photo[..., None], 3, axis=2)
    levels = np.arange(np.iinfo(photo.dtype).max + 1) / np.iinfo(photo.dtype).max
    table = np.where(levels <= 0.04045, levels / 12.92, ((levels + 0.055) / 1.055) ** 2.4)
    return np.asarray(table.astype(np.float32)[photo[..., :3]])


def encoded(light: NDArray[np.float32], dtype: np.dtype[np.unsignedinteger[Any]]) -> Image:
    """Linear light (..., 3) in sRGB, the inverse of `linear_light`; beyond 0 and 1 it is cut off.

    Examples
    --------
    >>> levels = np.arange(256, dtype=np.uint8).reshape(1, -1, 1).repeat(3, axis=2)
    >>> bool((encoded(linear_light(levels), levels.dtype) == levels).all())
    True
    """
    steps = (1 << 16) - 1
    fine = np.arange(steps + 1) / steps
    # The root of light is nearly even in sRGB: 65536 steps of it are finer than those of 16 bits but for the darkest.
    table = np.where(fine**2 <= 0.0031308, 12.92 * fine**2, 1.055 * fine ** (2 / 2.4) - 0.055)
    table = np.rint(table * np.iinfo(dtype).max).astype(dtype)
    root = np.sqrt(np.clip(light, 0, 1))
    return typing.cast(Image, table[np.rint(root * np.float32(steps)).astype(np.uint16)])


def shrink(image: NDArray[np.float32] | Image, factor: int) -> NDArray[np.float32]:
    """Mean over blocks of ``factor`` x ``factor`` pixels; incomplete blocks at the right and lower edge are dropped.

    Pixel ``(x, y)`` of the result is at ``(x, y) * factor`` of the original (pixel centres at +0.5 in both).
    """
    rows, columns = image.shape[0] // factor, image.shape[1] // factor
    # adding whole rows, then whole columns, takes a sixth of the time of a mean over the blocks' two axes
    high = np.zeros((rows, columns * factor, *image.shape[2:]), np.float32)
    for row in range(factor):
        high += image[row : rows * factor : factor, : columns * factor]
    mean = np.zeros((rows, columns, *image.shape[2:]), np.float32)
    for column in range(factor):
        mean += high[:, column::factor]
    mean /= np.float32(factor * factor)
    return mean


def whole_blocks(mask: NDArray[np.bool_], factor: int) -> NDArray[np.bool_]:
    """Which blocks of ``factor`` x ``factor`` pixels lie in a mask whole, as `shrink` counts them."""
    return np.asarray(shrink(mask.astype(np.float32), factor) > _WHOLE)


def reduced(photo: Image, longest: int = 1000) -> NDArray[np.float32]:
    """A photo in linear light, its long side shrunk to about ``longest`` pixels by a whole factor.

    It is shrunk in bands of rows, so that it is never whole in floating point.
    """
    factor = reduction_factor(photo, longest)
    rows = factor * max(1, _BAND // (factor * photo.shape[1]))
    return np.concatenate([shrink(linear_light(photo[top : top + rows]), factor) for top in range(0, len(photo), rows)])


def reduction_factor(photo: Image, longest: int) -> int:
    """The whole factor by which `reduced` shrinks a photo."""
    return max(1, round(max(photo.shape[:2]) / longest))


def perceptual(linear: NDArray[np.float32]) -> NDArray[np.float32]:
    """Linear sRGB (..., 3) to Oklab (..., 3), times 100: lightness 0 to 100, green-red, blue-yellow."""
    return (100 * np.cbrt(linear @ _LINEAR_TO_CONES.T.astype(np.float32))) @ _CONES_TO_LAB.T.astype(np.float32)


def gaussian_mean(
    values: NDArray[np.floating],
    weight: NDArray[np.floating] | NDArray[np.bool_],
    sigma: float,
    least: float = 1e-12,
    mode: str = "reflect",
) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Weighted Gaussian mean: the normalised convolution of Knutsson and Westin (1993).

    Parameters
    ----------
    values : (h, w) or (h, w, c) array
        Values without weight do not matter and may be NaN.
    weight : (h, w) array
        At least 0; a mask counts as ones and zeros.
    sigma : float
        Pixels.
    least : float
        Below this weight, the mean falls to zero with the weight.
    mode : str
        The values beyond the frame, named as in `scipy.ndimage`.

    Returns
    -------
    mean : array like ``values``
    share : (h, w) array
        Gaussian mean of the weight.

    Examples
    --------
    >>> mean, share = gaussian_mean(np.array([[4.0, np.nan, 4.0]]), np.array([[True, False, True]]), 1.0)
    >>> mean.round(6)
    array([[4., 4., 4.]])
    """
    channels = (..., None) if values.ndim == 3 else (...,)
    weight = weight.astype(values.dtype)
    counted = np.where(weight[channels] > 0, values, 0) * weight[channels]
    total = ndimage.gaussian_filter(counted, sigma, axes=(0, 1), mode=mode)
    share = ndimage.gaussian_filter(weight, sigma, mode=mode)
    return total / np.maximum(share, least)[channels], share


def gradient_magnitude(image: NDArray[np.float32], sigma: float) -> NDArray[np.float32]:
    """Length of the colour gradient (h, w) of an (h, w, c) image at the scale ``sigma`` pixels, per pixel."""
    squared = np.zeros(image.shape[:2], np.float32)
    for channel in range(image.shape[2]):
        for order in ((0, 1), (1, 0)):
            squared += ndimage.gaussian_filter(image[..., channel], sigma, order=order, mode="nearest") ** 2
    return np.sqrt(squared)


def sample_bilinear(image: NDArray[np.floating] | Image, pixels: Array) -> NDArray[np.float32]:
    """Values (..., c) of an (h, w, c) image at ``pixels`` (..., 2), x and y with pixel centres at +0.5.

    A photo, of unsigned integers, is sampled in linear light. Positions outside take the value of the nearest pixel.
    """
    height, width = image.shape[:2]
    x = np.clip(pixels[..., 0] - 0.5, 0, width - 1)
    y = np.clip(pixels[..., 1] - 0.5, 0, height - 1)
    left = np.clip(x.astype(np.int64), 0, max(width - 2, 0))
    top = np.clip(y.astype(np.int64), 0, max(height - 2, 0))
    right, bottom = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    across = (x - left).astype(np.float32)[..., None]
    down = (y - top).astype(np.float32)[..., None]

    def at(row: NDArray[np.int64], column: NDArray[np.int64]) -> NDArray[np.floating]:
        value = typing.cast(NDArray[Any], image[row, column])
        if value.dtype.kind != "u":
            return value
        return linear_light(value.reshape(1, -1, value.shape[-1])).reshape(value.shape)

    upper = at(top, left) * (1 - across) + at(top, right) * across
    lower = at(bottom, left) * (1 - across) + at(bottom, right) * across
    return np.asarray(upper * (1 - down) + lower * down)


def sharpness(image: NDArray[np.float32], pixels: Array, radius: int = 12) -> float:
    """How sharp an image is around given places, from 0 (nothing fine left) to about 1.

    The ratio of the finest detail to the detail at twice the size, which depends neither on the amount of print nor on
    its contrast.

    Parameters
    ----------
    image : (h, w) array
        Lightness.
    pixels : (N, 2) array
        The places, pixels.
    radius : int
        Half the side of the square around each place, pixels.
    """
    near = np.zeros(image.shape, bool)
    columns, rows = np.floor(pixels).astype(int).T
    inside = (columns >= 0) & (rows >= 0) & (columns < image.shape[1]) & (rows < image.shape[0])
    near[rows[inside], columns[inside]] = True
    near = ndimage.uniform_filter(near.astype(np.float32), 2 * radius + 1) > 0
    if not near.any():
        return 0.0
    smooth = ndimage.gaussian_filter(image, _FINE)
    fine = (image - smooth)[near]
    coarse = (smooth - ndimage.gaussian_filter(image, _COARSE))[near]
    return float(np.sqrt((fine**2).mean() / max((coarse**2).mean(), 1e-12)))
