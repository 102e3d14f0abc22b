"""Pictures in another light laid on a print: the shift is right whatever the light makes of the print."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.tracks.page_print import CELL, PagePrint
from origami.core.tracks.toned_alignment import TonedTemplate
from scipy import ndimage

SHAPE = (250, 350)
SHIFT = np.array([0.6, -0.4])


def text(shift: tuple[float, float] | np.ndarray = (0.0, 0.0)) -> np.ndarray:
    """Lines of strokes, 0 to 1, dark on bright, moved by ``shift``, x first."""
    random = np.random.default_rng(2)
    fine = np.ones((4 * SHAPE[0], 4 * SHAPE[1]))
    for top in range(40, SHAPE[0] - 40, 24):
        for left in range(40, SHAPE[1] - 40, 9):
            height, width = random.integers(5, 12), random.integers(2, 5)
            fine[4 * top : 4 * (top + height), 4 * left : 4 * (left + width)] = 0
    fine = ndimage.gaussian_filter(fine, 5)
    moved = ndimage.shift(fine, (4 * shift[1], 4 * shift[0]), order=1, mode="nearest")
    return moved.reshape(SHAPE[0], 4, SHAPE[1], 4).mean(axis=(1, 3))


LIGHTS = {
    "as it is": lambda print_: print_,
    "inverted": lambda print_: 1 - print_,
    "inverted, thick and soft": lambda print_: ndimage.gaussian_filter(1 - print_**3, 1.0),
    "hardly to be seen, on uneven ground": lambda print_: 0.2 * print_ + np.linspace(0, 0.1, SHAPE[1]),
}


def print_of(picture: np.ndarray) -> PagePrint:
    known = np.ones((SHAPE[0] // CELL, SHAPE[1] // CELL), bool)
    noise = np.random.default_rng(3).normal(scale=0.005, size=SHAPE)
    return PagePrint((4 * (picture + noise - picture.mean())).astype(np.float32), np.zeros((*known.shape, 2)), known)


@pytest.mark.parametrize("light", LIGHTS)
def test_the_shift_is_found_in_any_light(light: str) -> None:
    start = np.zeros((SHAPE[0] // CELL, SHAPE[1] // CELL, 2), np.float32)
    shift, fit = TonedTemplate(print_of(text())).align(print_of(LIGHTS[light](text(SHIFT))), start)
    off = np.linalg.norm(shift - SHIFT, axis=-1)[8:-8, 8:-8]
    assert np.median(off) < 0.05
    assert np.quantile(off, 0.95) < 0.15
    assert np.quantile(fit.correlation[8:-8, 8:-8], 0.1) > 0.8
    assert np.median(fit.deviation[8:-8, 8:-8]) < 0.05


def test_another_print_does_not_fit() -> None:
    start = np.zeros((SHAPE[0] // CELL, SHAPE[1] // CELL, 2), np.float32)
    _, fit = TonedTemplate(print_of(text())).align(print_of(np.fliplr(text().T[:, ::-1].T)), start)
    assert np.median(fit.correlation[8:-8, 8:-8]) < 0.5
