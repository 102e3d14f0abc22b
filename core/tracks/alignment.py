"""How far one picture's print is from another's, cell by cell: the least squares of Lucas and Kanade in windows.

B. D. Lucas and T. Kanade, "An iterative image registration technique with an application to stereo vision", IJCAI
1981; with the template's gradients alone, as S. Baker and I. Matthews, "Lucas-Kanade 20 years on", IJCV 2004.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..numeric.image import gaussian_mean, shrink, whole_blocks
from ..numeric.threads import in_threads
from ..page.page_cells import enlarge
from ..watch import SILENT, Watch
from .page_print import CELL, PagePrint, Picture, at_pixels

# The farthest shift to believe, as a part of the page's longer side: half the distance of two lines of text.
FARTHEST = 0.012

# Print counts from the one correlation with a template on, and fully from the other on. A choice.
_POOR, _GOOD = 0.6, 0.9
_ROUNDS_HALF = 5  # of alignment to the reference photo, at half size; a choice

# Standard deviation of the window, page pixels: a line of text high.
_WINDOW = 7.0
# Where print fixes the shift less than this part of the mean, the shift around counts as well, within this many windows
# (standard deviations). Choices; no measurement of them is recorded.
_WEAK, _AROUND = 0.02, 1.5
LONGEST_STEP = 1.5  # page pixels in one round, because the picture's slopes hold no farther; a choice
_LEAST_KNOWN = 1e-4  # share of the surroundings; if less is trusted, the nearest mean counts
# Noise of neighbouring page pixels is shared over about this many, because the print was smoothed. A choice.
SHARED_NOISE = 3.0
# Of the noise that the fit's deviation is computed from: the least share of a window that counts as shown, the least
# variance of a picture, the least gain and the least variance of the noise. They keep divisions finite where there is
# nothing to see, and such places are dropped by their correlation or share.
_LEAST_SHARE, _LEAST_VARIANCE, _LEAST_GAIN, _LEAST_NOISE = 1e-3, 1e-8, 0.2, 1e-6

# Means (h, w) of the products of the slopes in each window: across twice, across and down, down twice.
Tensor = tuple[Picture, Picture, Picture]


@dataclass(frozen=True)
class Fit:
    """How well pictures lie on each other in the window of each cell (h, w).

    Attributes
    ----------
    correlation : (h, w) array
        Zero-mean normalised, -1 to 1.
    deviation : (h, w) array
        Standard deviation of the shift that noise leads one to expect, page pixels.
    step : (h, w, 2) array
        What one more round would add to the shift, x first, page pixels.
    share : (h, w) array
        Part of the window that both pictures show.
    """

    correlation: Picture
    deviation: Picture
    step: Picture
    share: Picture

    @property
    def trust(self) -> Picture:
        """0 to 1 (h, w): whether the print lies where the template's does."""
        return np.clip((self.correlation - _POOR) / (_GOOD - _POOR), 0, 1)


class Template:
    """A picture (H, W) of the page's print, on which others are laid; ``known`` are its cells (h, w)."""

    def __init__(self, picture: Picture, known: NDArray[np.bool_]) -> None:
        self.picture, self.known = picture, known
        self.across, self.down = np.gradient(picture, axis=1), np.gradient(picture, axis=0)

    def align(
        self,
        filtered: Picture,
        known: NDArray[np.bool_],
        shift: Picture,
        limit: float,
        rounds: int,
        *,
        order: int,
    ) -> Picture:
        """The shifts (h, w, 2), x first, page pixels, at which a picture shows what the template does.

        Parameters
        ----------
        filtered : (H, W) array
            The picture, as for `shifted`.
        known : (h, w) bool array
            Cells that the picture shows.
        shift : (h, w, 2) float32 array
            To begin with.
        limit : float
            The longest one to believe.
        rounds : int
        order : int
            Of the spline between pixels, 1 or 3.
        """
        both = known & self.known
        inside = at_pixels(both)
        tensor = self._tensor(inside)
        weak = _weak(tensor, both)
        trust = np.clip(_determinant(tensor, 0) / _determinant(tensor, weak), 0, 1)
        for _ in range(rounds):
            off = (self.picture - shifted(filtered, shift, order)) * inside
            x, y = _window(self.across * off), _window(self.down * off)
            step = _step(tensor, weak, x, y)
            length = np.linalg.norm(step, axis=-1, keepdims=True)
            shift = shift + step * np.minimum(1, LONGEST_STEP / np.maximum(length, 1e-6))
            shift = with_those_around(shift, trust, _AROUND * _WINDOW / CELL, _LEAST_KNOWN)
            length = np.linalg.norm(shift, axis=-1, keepdims=True)
            shift = (shift * np.minimum(1, limit / np.maximum(length, 1e-6))).astype(np.float32)
        return shift

    def fit(self, moved: Picture, known: NDArray[np.bool_]) -> Fit:
        """How well a picture that was moved onto the template, and shows the cells ``known``, lies on it."""
        both = known & self.known
        inside = at_pixels(both)
        template, other = self.picture * inside, moved * inside
        share = _window(inside.astype(np.float32))
        count = np.maximum(share, _LEAST_SHARE)
        mean, other_mean = _window(template) / count, _window(other) / count
        variance = _window(template * template) / count - mean**2
        other_variance = _window(other * other) / count - other_mean**2
        common = _window(template * other) / count - mean * other_mean
        gain = np.maximum(common / np.maximum(variance, _LEAST_VARIANCE), _LEAST_GAIN)
        noise = np.maximum(other_variance - 2 * gain * common + gain**2 * variance, _LEAST_NOISE) / gain**2
        tensor = self._tensor(inside)
        off = (template - other / enlarge(gain, template.shape)) * inside
        x, y = _window(self.across * off), _window(self.down * off)
        spread = (tensor[0] + tensor[2]) / (_determinant(tensor, 0) + 1e-12)
        return Fit(
            correlation=common / np.sqrt(np.maximum(variance * other_variance, _LEAST_VARIANCE)),
            deviation=np.sqrt(SHARED_NOISE * noise * spread / (4 * np.pi * _WINDOW**2)),
            step=_step(tensor, _weak(tensor, both), x, y),
            share=share,
        )

    def _tensor(self, inside: NDArray[np.bool_]) -> Tensor:
        """Of the slopes of the pixels ``inside``."""
        across, down = self.across * inside, self.down * inside
        return _window(across * self.across), _window(across * self.down), _window(down * self.down)


def _weak(tensor: Tensor, both: NDArray[np.bool_]) -> float:
    """What is added to the tensor's diagonal, so that a step is short where hardly any print fixes it."""
    return _WEAK * float(np.mean((tensor[0] + tensor[2])[both])) + 1e-12 if both.any() else 1.0


def _determinant(tensor: Tensor, weak: float) -> Picture:
    xx, xy, yy = tensor
    return np.asarray((xx + np.float32(weak)) * (yy + np.float32(weak)) - xy**2)


def _step(tensor: Tensor, weak: float, x: Picture, y: Picture) -> Picture:
    """The shift (h, w, 2) that solves each window's two equations, whose right-hand sides are ``x`` and ``y``."""
    xx, xy, yy = tensor[0] + np.float32(weak), tensor[1], tensor[2] + np.float32(weak)
    return np.asarray(np.stack([yy * x - xy * y, xx * y - xy * x], axis=-1) / _determinant(tensor, weak)[..., None])


def align_prints(prints: Sequence[PagePrint], reference: int, threads: int = 1, watch: Watch = SILENT) -> list[Picture]:
    """Shifts (h, w, 2) of all photos' prints onto the reference photo's, to half a page pixel.

    Raises
    ------
    Cancelled
    """
    fixed = Template(*half_size(prints[reference]))
    limit = FARTHEST * max(fixed.picture.shape)

    def align(print_: PagePrint) -> Picture:
        if print_ is prints[reference] or not print_.known.any():
            return np.zeros((*print_.known.shape, 2), np.float32)
        moving, known = half_size(print_)
        coarse = fixed.align(moving, known, np.zeros((*known.shape, 2), np.float32), limit, _ROUNDS_HALF, order=1)
        return 2 * enlarge(coarse, print_.known.shape)

    shifts: list[Picture] = []
    for shift in in_threads(align, prints, threads):
        shifts.append(shift)
        watch.step(len(shifts) / len(prints), "Laying the photos on each other")
    return shifts


def with_those_around(shift: Picture, trust: Picture, sigma: float, least: float) -> Picture:
    """Shifts (h, w, 2) as far as they are trusted (h, w), 0 to 1; for the rest the mean of the trusted ones around.

    ``sigma`` and ``least`` are those of `numeric.image.gaussian_mean`.
    """
    around, _ = gaussian_mean(shift, trust, sigma, least)
    return np.asarray(trust[..., None] * shift + (1 - trust[..., None]) * around)


def half_size(print_: PagePrint) -> tuple[Picture, NDArray[np.bool_]]:
    """The print at half size, and its cells."""
    return shrink(print_.picture, 2), whole_blocks(print_.known, 2)


def shifted(filtered: Picture, shift: Picture, order: int) -> Picture:
    """A picture (H, W), as `ndimage.spline_filter` of that order leaves it, moved by the shifts (h, w, 2) of cells."""
    rows, columns = (np.arange(length, dtype=np.float32) for length in filtered.shape)
    at = np.empty((2, *filtered.shape), np.float32)
    at[0] = enlarge(shift[..., 1], filtered.shape) + rows[:, None]
    at[1] = enlarge(shift[..., 0], filtered.shape) + columns
    return np.asarray(ndimage.map_coordinates(filtered, at, order=order, mode="nearest", prefilter=False))


def _window(pixels: Picture) -> Picture:
    """Weighted mean (h, w) of pixels (H, W) in the window about each cell's centre."""
    # the blocks' own width is part of the window: the variance of a row of n numbers is (n^2 - 1) / 12
    sigma = np.sqrt(_WINDOW**2 - (CELL**2 - 1) / 12) / CELL
    return np.asarray(ndimage.gaussian_filter(shrink(pixels, CELL), sigma))
