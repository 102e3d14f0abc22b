"""How a page looks beside its flat original: the evenness of its light, its colours, its sharpness and its noise.

The page is first laid onto the original, by matched features and dense flow, so that its geometry does not count. All
is measured with the original scaled to 2000 px height. After one gain means: each channel is multiplied by one number
in linear light that gives blank paper the original's colour, so exposure and white balance do not count either.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..core.flat.distortion import apply_affine, fit_affine
from ..core.numeric.cielab import cielab
from ..core.numeric.image import encoded, linear_light
from ..core.numeric.robust import MAD_TO_SIGMA
from . import metrics
from .metrics import Image, NoMatch

Values = NDArray[np.float32]
Mask = NDArray[np.bool_]

HEIGHT = 2000
# Cycles per pixel at which sharpness is measured; fine print lies between the first and the second.
FREQUENCIES = {"1/8": 1 / 8, "1/4": 1 / 4, "3/8": 3 / 8}
_RING = 0.03  # cycles per pixel to either side of them
_TILE = 64  # pixels: frequencies are told apart by 1/64
_LEAST_CONTRAST = 0.03  # standard deviation of a tile of print, share of white
_PREFILTER = 0.45  # pixels of the result, standard deviation: a larger page is smoothed before it is made smaller
# Blank paper: levels of 255 by which its surroundings of this many pixels, and it from the paper's level, may differ.
_EVEN, _SURROUNDINGS, _PAPER = 12, 9, 10
_MARGIN, _FROM_EDGE = 20, 30  # px around what the page does not cover, and along the original's edge, that do not count
_LEAST_BLANK = 5000  # px
_LIGHT, _GRAIN = 4.0, 4.0  # px, standard deviations: light is smoother than this, and grain finer
_FOLLOWED, _NEARBY = 400.0, (4.0, 6.0)  # squared slope of print that flow follows; px over which it is averaged
_WINDOW, _SSIM = 1.5, ((0.01 * 255) ** 2, (0.03 * 255) ** 2)  # Wang et al. (2004)


@dataclass(frozen=True)
class Laid:
    """A page on its original, which is `HEIGHT` px high; both as OpenCV has them.

    Attributes
    ----------
    original, page : (h, w, 3) uint8 array
    covered : (h, w) bool array
        Where the page is.
    """

    original: Image
    page: Image
    covered: Mask


def score_light(original: Image, page: Image) -> dict[str, object]:
    """Figures of a page beside its flat original, both as read by OpenCV.

    ``paper_L`` and ``chroma_paper`` are L* and C* of blank paper, of page and original. ``unevenness_L`` is the spread
    of L* over blank paper after one gain, 5th to 95th percentile. ``delta_e`` is CIE76 after one gain, away from edges.
    ``mtf`` is the contrast of detail, page over original, by cycles per pixel; ``noise_L`` the standard deviation of L*
    on blank paper, finer than its light. ``psnr`` (decibels) and ``ssim`` are after one gain too, at half the size,
    which is about that of the published comparisons (1000 px high).

    Raises
    ------
    NoMatch
        If the page shows something else, or there is hardly any blank paper.
    """
    original = _scaled(original)
    laid = lay_on(original, page)
    inner = _inner(laid.covered)
    blank, even = (mask & inner for mask in _blank_and_even(original))
    if blank.sum() < _LEAST_BLANK:
        raise NoMatch("there is hardly any blank paper to judge the light by")
    there, here = (linear_light(image[..., ::-1]) for image in (original, laid.page))
    gain = np.median(there[blank] / np.maximum(here[blank], 1e-3), axis=0)
    evened = np.clip(here * gain, 0, 1).astype(np.float32)
    lab_there, lab_here, lab_evened = (cielab(image) for image in (there, here, evened))
    grain = (lab_here[..., 0] - cv2.GaussianBlur(lab_here[..., 0], (0, 0), _GRAIN))[blank]
    different = np.linalg.norm(lab_evened - lab_there, axis=-1)[even]
    chroma = [float(np.median(np.hypot(lab[..., 1], lab[..., 2])[blank])) for lab in (lab_here, lab_there)]
    return {
        "paper_L": [float(np.median(lab[..., 0][blank])) for lab in (lab_here, lab_there)],
        "chroma_paper": chroma,
        "unevenness_L": _unevenness(lab_evened[..., 0], blank),
        "delta_e": {"mean": float(different.mean()), "p95": float(np.percentile(different, 95))},
        "mtf": transfer(laid),
        "noise_L": float(MAD_TO_SIGMA * np.median(np.abs(grain))),
        **_likeness(original, np.ascontiguousarray(encoded(evened, np.dtype(np.uint8))[..., ::-1]), inner),
    }


def own_unevenness(original: Image) -> float:
    """The unevenness that a flat original has itself, because its light is smoothed over the print beside blank paper.

    Evenly lit pages have about as much; the figure of a page without any shade is no lower.
    """
    original = _scaled(original)
    blank, _ = _blank_and_even(original)
    return _unevenness(cielab(linear_light(original[..., ::-1]))[..., 0], blank & _inner(np.ones(blank.shape, bool)))


def _scaled(original: Image) -> Image:
    """The original at `HEIGHT`."""
    size = (round(original.shape[1] * HEIGHT / original.shape[0]), HEIGHT)
    shrinking = original.shape[0] > HEIGHT
    return np.asarray(cv2.resize(original, size, interpolation=cv2.INTER_AREA if shrinking else cv2.INTER_CUBIC))


def _unevenness(lightness: Values, blank: Mask) -> float:
    """The spread of L* (h, w) over blank paper, 5th to 95th percentile."""
    light = cv2.GaussianBlur(lightness, (0, 0), _LIGHT)[blank]
    return float(np.subtract(*np.percentile(light, [95, 5])))


def lay_on(original: Image, page: Image) -> Laid:
    """Lay a page onto its original, which is `HEIGHT` px high, as its print has it.

    Raises
    ------
    NoMatch
        If the page shows something else.
    """
    height, width = original.shape[:2]
    half = cv2.resize(original, (round(width / 2), height // 2), interpolation=cv2.INTER_AREA)
    fine = cv2.resize(half, None, fx=1.5, fy=1.5, interpolation=cv2.INTER_CUBIC)
    target = metrics.find_features(fine)
    target = metrics.Features(target.points * (np.array(half.shape[1::-1]) / fine.shape[1::-1]), target.descriptors)
    shrink = min(1.0, 2400 / max(page.shape[:2]))
    reduced = page if shrink == 1 else cv2.resize(page, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    here, there = metrics.match(metrics.find_features(reduced), target)
    to_page = fit_affine(2 * there, here / shrink)
    scale = 1 / np.sqrt(abs(np.linalg.det(to_page[:, :2])))
    if scale < 0.95:
        page = cv2.GaussianBlur(page, (0, 0), _PREFILTER * np.sqrt(1 / scale**2 - 1))
    y, x = np.mgrid[:height, :width] + 0.5
    places = np.stack([x, y], axis=-1)
    once, _ = _sampled(page, to_page, places)
    sampled, covered = _sampled(page, to_page, places + _flow(original, once))
    return Laid(original, sampled, covered)


def _sampled(page: Image, to_page: NDArray[np.float64], places: NDArray[np.float64]) -> tuple[Image, Mask]:
    """The page at places (h, w, 2) of the original, and where it is there."""
    at = apply_affine(to_page, places.reshape(-1, 2)).reshape(places.shape)
    covered = ((at > 1) & (at < np.array(page.shape[1::-1]) - 1)).all(axis=-1)
    return cv2.remap(page, *(np.float32(at[..., k] - 0.5) for k in (0, 1)), cv2.INTER_CUBIC), covered


def _flow(original: Image, page: Image) -> NDArray[np.float32]:
    """Where the page has the original's print, px (h, w, 2); on blank paper, where flow is noise, as nearby."""
    size = original.shape[1::-1]
    there, here = (
        metrics.even_contrast(cv2.resize(image, (size[0] // 2, size[1] // 2), interpolation=cv2.INTER_AREA))
        for image in (original, page)
    )
    flow = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    flow.setFinestScale(0)
    found = flow.calc(there, here, None)
    slope = sum(cv2.Sobel(there, cv2.CV_32F, *order) ** 2 for order in ((1, 0), (0, 1)))
    slope = cv2.GaussianBlur(slope, (0, 0), _NEARBY[0])
    weight = slope / (slope + _FOLLOWED)
    total, share = (cv2.GaussianBlur(part, (0, 0), _NEARBY[1]) for part in (found * weight[..., None], weight))
    return 2 * cv2.resize(total / (share[..., None] + 1e-3), size, interpolation=cv2.INTER_LINEAR)


def _blank_and_even(original: Image) -> tuple[Mask, Mask]:
    """Where the original is blank paper, and where it is away from edges."""
    grey = cv2.cvtColor(original, cv2.COLOR_BGR2GRAY).astype(np.float32)
    square = np.ones((_SURROUNDINGS, _SURROUNDINGS))
    even = cv2.dilate(grey, square) - cv2.erode(grey, square) < _EVEN
    return even & (np.abs(grey - np.percentile(grey, 90)) < _PAPER), even


def _inner(covered: Mask) -> Mask:
    side = 2 * _MARGIN + 1
    inner = cv2.erode(covered.astype(np.uint8), np.ones((side, side))) > 0
    frame = np.zeros_like(inner)
    frame[_FROM_EDGE:-_FROM_EDGE, _FROM_EDGE:-_FROM_EDGE] = True
    return inner & frame


def transfer(laid: Laid) -> dict[str, float | None]:
    """Contrast of the page's detail over the original's at each of `FREQUENCIES`; None where the original has none.

    From the cross spectrum of tiles, each at its own light: noise, which the original does not have, does not count.
    """
    original, page = (
        cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(np.float32) / 255 for image in (laid.original, laid.page)
    )
    window = np.outer(np.hanning(_TILE), np.hanning(_TILE))
    cross, power = np.zeros((_TILE, _TILE)), np.zeros((_TILE, _TILE))
    for top in range(0, original.shape[0] - _TILE, _TILE // 2):
        for left in range(0, original.shape[1] - _TILE, _TILE // 2):
            tile = np.s_[top : top + _TILE, left : left + _TILE]
            there, here = original[tile], page[tile]
            if not laid.covered[tile].all() or there.std() < _LEAST_CONTRAST:
                continue
            level = max(np.percentile(here, 90), 0.05) / max(np.percentile(there, 90), 0.05)
            spectrum, other = (np.fft.fft2((part - part.mean()) * window) for part in (there, here / level))
            cross += (other * spectrum.conj()).real
            power += np.abs(spectrum) ** 2
    cycles = np.hypot(*np.meshgrid(np.fft.fftfreq(_TILE), np.fft.fftfreq(_TILE)))
    rings = {name: np.abs(cycles - centre) < _RING for name, centre in FREQUENCIES.items()}
    return {
        name: float(cross[ring].sum() / power[ring].sum()) if power[ring].any() else None
        for name, ring in rings.items()
    }


def _likeness(original: Image, page: Image, inner: Mask) -> dict[str, float]:
    """Peak signal to noise ratio of the colours, and structural similarity of the greys, at half the size."""
    size = (original.shape[1] // 2, original.shape[0] // 2)
    there, here = (
        cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.float64) for image in (original, page)
    )
    counts = cv2.resize(inner.astype(np.uint8), size, interpolation=cv2.INTER_AREA) > 0
    error = ((there - here)[counts] ** 2).mean()
    a, b = (cv2.cvtColor(image.astype(np.float32), cv2.COLOR_BGR2GRAY).astype(np.float64) for image in (there, here))

    def mean(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return cv2.GaussianBlur(values, (11, 11), _WINDOW)

    mean_a, mean_b = mean(a), mean(b)
    spread = mean(a * a) - mean_a**2 + mean(b * b) - mean_b**2
    common = mean(a * b) - mean_a * mean_b
    first, second = _SSIM
    alike = (2 * mean_a * mean_b + first) * (2 * common + second)
    alike /= (mean_a**2 + mean_b**2 + first) * (spread + second)
    return {"psnr": float(10 * np.log10(255**2 / max(error, 1e-6))), "ssim": float(alike[counts].mean())}
