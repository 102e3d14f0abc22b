"""Draws antialiased lines into a picture."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array


def draw_line(picture: NDArray[np.float32], line: Array, color: Sequence[float], width: float) -> None:
    """Draw a line of straight pieces into a picture, in place.

    Each pixel is blended by the share of it that the line covers.

    Parameters
    ----------
    picture : (h, w, c) float32 array
    line : (K, 2) array
        Its corners x, y in pixels, the first pixel's centre at (0.5, 0.5). They may be outside.
    color : sequence of c floats
    width : float
        Pixels, at least 1.
    """
    height, across = picture.shape[:2]
    distance = np.full((height, across), np.inf, np.float32)
    reach = width / 2 + 0.5
    for start, end in pairwise(line):
        low = np.floor(np.minimum(start, end) - reach).clip(0, (across, height)).astype(int)
        high = np.ceil(np.maximum(start, end) + reach).clip(0, (across, height)).astype(int)
        here = np.s_[low[1] : high[1], low[0] : high[0]]
        place = np.stack(np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1])), -1) + 0.5 - start
        span = end - start
        share = (place @ span / max(float(span @ span), 1e-12)).clip(0, 1)
        apart = np.linalg.norm(place - share[..., None] * span, axis=-1)
        distance[here] = np.minimum(distance[here], apart)
    near = distance < reach
    covered = (reach - distance[near]).clip(0, 1)[:, None]
    picture[near] += covered * (np.asarray(color, np.float32) - picture[near])
