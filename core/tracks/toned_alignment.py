"""How far a picture in another light is from a print, cell by cell.

Another light is another tone curve: what is dark in one may be bright in the other, strokes look thicker or thinner,
and the picture is more or less sharp. Each window's least squares therefore have an unknown for each of these beside
the shift. Without them, strokes that look thicker seem to be moved to both sides wherever a window cuts a line of text:
on a rendered letter in a simulated ultraviolet light, the shifts were .44 pixels of the page off, and .09 with them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..numeric.image import gaussian_mean, shrink
from .alignment import LONGEST_STEP, SHARED_NOISE, shifted
from .page_print import CELL, PagePrint, Picture, at_pixels

# Standard deviation of the window, page pixels: on that letter the shifts were .08 page pixels off with 12, .05 with 18
# and .04 with 25, and a crease is as sharp as the window.
_WINDOW = 20.0
_ROUNDS = 5  # of alignment; a choice
# Added to the diagonal of the normal equations, whose terms have variance 1: terms that are alike share what they
# explain. This and the next three are choices.
_HELD = 1e-2
# Squared contrast, as a share of the template's, at which a step is half as long: with less it is noise.
_FAINT = 0.02
# Share of the mean detail of the print below which a place has no shift of its own.
_LEAST_DETAIL = 1e-2
# Least share of a window that counts as shown, least variance of a picture, and least contrast, which keep divisions
# finite where there is nothing to see.
_LEAST_SHARE, _LEAST_VARIANCE, _LEAST_CONTRAST = 1e-3, 1e-8, 1e-3
_GRADIENT = 2  # the last terms are the template's two slopes


@dataclass(frozen=True)
class TonedFit:
    """How well a picture in another light lies on a print.

    Attributes
    ----------
    correlation : (h, w) array
        With the print in the picture's tones, 0 to 1.
    deviation : (h, w) array
        Standard deviation of the shift that noise leads one to expect, page pixels.
    """

    correlation: Picture
    deviation: Picture


class TonedTemplate:
    """A print of the page, on which pictures in any light are laid."""

    def __init__(self, print_: PagePrint) -> None:
        self.known = print_.known
        picture = print_.picture
        across, down = np.gradient(picture, axis=1), np.gradient(picture, axis=0)
        # level, contrast, tone curve, width of the strokes, sharpness, shift
        terms = np.ones_like(picture), picture, picture**2, np.hypot(across, down), ndimage.laplace(picture)
        self._terms = (*terms, across, down)

    def align(self, print_: PagePrint, shift: Picture) -> tuple[Picture, TonedFit]:
        """The shifts (h, w, 2), x first, page pixels, at which a picture shows what the template does.

        Parameters
        ----------
        print_ : PagePrint
        shift : (h, w, 2) float32 array
            To begin with, right to about a pixel.
        """
        both = print_.known & self.known
        inside = at_pixels(both).astype(np.float32)
        normal, scale = self._normal(inside)
        detail = both * (normal[..., -1, -1] + normal[..., -2, -2])
        for _ in range(_ROUNDS):
            # the windows do not see what is finer than they are
            shift, _ = gaussian_mean(shift, detail, _WINDOW / CELL, _LEAST_DETAIL)
            moved = shifted(print_.filtered, shift, 3) * inside
            right = np.stack([_window(term * moved) for term in self._terms], axis=-1) / scale
            factor = np.linalg.solve(normal, right[..., None])[..., 0]
            contrast = factor[..., 1:2] / scale[1]
            step = -factor[..., -_GRADIENT:] / scale[-_GRADIENT:] * contrast / (contrast**2 + _FAINT)
            length = np.linalg.norm(step, axis=-1, keepdims=True)
            shift = (shift + step * np.minimum(1, LONGEST_STEP / np.maximum(length, 1e-6))).astype(np.float32)
        return shift, self._fit(normal, scale, right, factor, moved, inside)

    def _normal(self, inside: Picture) -> tuple[Picture, Picture]:
        """The normal equations (h, w, n, n) of terms of variance 1, and the scale (n,) that makes them so."""
        count = len(self._terms)
        normal = np.empty((*self.known.shape, count, count), np.float32)
        for i, first in enumerate(self._terms):
            first = first * inside
            for j, second in enumerate(self._terms[: i + 1]):
                normal[..., i, j] = normal[..., j, i] = _window(first * second)
        mean = np.diagonal(normal, axis1=-2, axis2=-1).mean(axis=(0, 1))
        scale = np.sqrt(np.maximum(mean, 1e-12)).astype(np.float32)
        return normal / scale[:, None] / scale + np.float32(_HELD) * np.eye(count, dtype=np.float32), scale

    def _fit(
        self, normal: Picture, scale: Picture, right: Picture, factor: Picture, moved: Picture, inside: Picture
    ) -> TonedFit:
        share = np.maximum(_window(inside), _LEAST_SHARE)
        energy = _window(moved**2)
        level = right[..., 0] * scale[0]
        variance = np.maximum(energy - level**2 / share, _LEAST_VARIANCE)
        rest = np.clip(energy - (factor * right).sum(axis=-1), _LEAST_VARIANCE, variance)
        spread = np.diagonal(np.linalg.inv(normal), axis1=-2, axis2=-1)[..., -_GRADIENT:] / scale[-_GRADIENT:] ** 2
        contrast = np.abs(factor[..., 1]) / scale[1]
        noise = SHARED_NOISE * rest / share * spread.sum(axis=-1) / (4 * np.pi * _WINDOW**2)
        return TonedFit(np.sqrt(1 - rest / variance), np.sqrt(noise) / np.maximum(contrast, _LEAST_CONTRAST))


def _window(pixels: NDArray[np.float32]) -> Picture:
    """Weighted mean (h, w) of pixels (H, W) in the window about each cell's centre."""
    return np.asarray(ndimage.gaussian_filter(shrink(pixels, CELL), _WINDOW / CELL))
