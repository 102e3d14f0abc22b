"""The colours of a photo between its pixels, and of photos reduced as far as they are sampled more coarsely."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Photo = NDArray[np.unsignedinteger[Any]]
Weights = NDArray[np.float32]

_KERNEL = 4  # pixels around a position that its colour depends on, with one to spare
# Up to 1.2 photo pixels from one page pixel to the next the photo itself is sampled: it hardly aliases, and half of the
# page of most photos lies there.
_UNREDUCED = 0.25
# Positions sampled at once, each from sixteen pixels: their temporaries fit about into the processor's cache.
_SAMPLED_AT_ONCE = 1 << 14
_WHITE = {np.dtype(np.uint8): 255, np.dtype(np.uint16): 65535}


def sample(photo: Photo, positions: NDArray[np.float32], method: str = "bicubic") -> Photo:
    """Colours of a photo at given positions.

    Parameters
    ----------
    photo : (h, w, 3) uint8 or uint16 array
    positions : (H, W, 2) array
        Pixels of the photo, neighbours in the array being neighbours on the page.
    method : str
        ``"bicubic"``: Keys' kernel; where the page has fewer pixels than the photo, a reduced photo is used to avoid
        aliasing. ``"linear"``: only the four nearest pixels, as a render engine samples.

    Returns
    -------
    (H, W, 3) array of the photo's type
        White where the position is not finite.
    """
    if method not in ("bicubic", "linear"):
        raise ValueError(f"method must be 'bicubic' or 'linear', not {method!r}")
    out: Photo = np.full((*positions.shape[:2], 3), _WHITE[photo.dtype], photo.dtype)
    known = np.isfinite(positions[..., 0])
    if not known.any():
        return out
    if method == "linear":
        _sample_level(*_around(photo, positions, 1), known, 1.0, out, _linear_weights)
        return out
    level = reduction_level(positions)
    level = np.where(level < 1, np.maximum(level - _UNREDUCED, 0) / (1 - _UNREDUCED), level)
    coarsest = min(int(np.ceil(np.nanmax(level, initial=0))), int(np.log2(max(min(photo.shape[:2]), 1))))
    photo, positions = _around(photo, positions, 2**coarsest)
    for k in range(coarsest + 1):
        # Between two reduced photos the result is blended, because a hard switch would be visible as a line.
        share = np.clip(1 - np.abs(np.minimum(level, coarsest) - k), 0, 1)
        here = share > 0
        if k == 0:
            _sample_level(photo, positions, here, 1.0, out, _cubic_weights)
        elif here.any():
            finer = out[here].astype(np.float32)
            _sample_level(photo, positions, here, 0.5**k, out, _cubic_weights)
            coarser_share = np.where(level[here] < k, share[here], 1)[:, None].astype(np.float32)
            out[here] = np.rint(finer + coarser_share * (out[here] - finer)).astype(out.dtype)
        if k < coarsest:
            photo = halve(photo)
    return out


def _around(photo: Photo, positions: NDArray[np.float32], step: int) -> tuple[Photo, NDArray[np.float32]]:
    """The part of a photo around positions, and these in it: a band of a page needs little of the photo.

    It is cut at multiples of ``step`` pixels, so that reduced by that factor it is a part of the reduced photo.
    """
    ends = np.stack([np.nanmin(positions, axis=(0, 1)), np.nanmax(positions, axis=(0, 1))])
    low, high = np.clip(np.floor(ends / step).astype(int), 0, np.array(photo.shape[1::-1]) // step)
    left, top = np.maximum(low - _KERNEL, 0) * step
    right, bottom = (high + _KERNEL) * step
    return photo[top:bottom, left:right], positions - np.array([left, top], positions.dtype)


def reduction_level(positions: NDArray[np.float32]) -> NDArray[np.float32]:
    """How often to halve the photo for neighbours on the page to be neighbours in it, (H, W); 0 if never.

    The longer step of the two directions counts. NaN where the position is not finite.
    """
    longest = np.zeros(positions.shape[:2], np.float32)
    with np.errstate(invalid="ignore"):
        for axis in (0, 1):
            if positions.shape[axis] < 2:
                continue
            step = np.hypot(*np.moveaxis(np.diff(positions, axis=axis), -1, 0))
            ahead, behind = (np.insert(step, at, np.nan, axis=axis) for at in (step.shape[axis], 0))
            longest = np.fmax(longest, np.fmin(ahead, behind))
        level = np.log2(np.maximum(longest, 1))
    level[~np.isfinite(positions[..., 0])] = np.nan
    return level


def halve(photo: Photo) -> Photo:
    """Means of 2x2 pixels; an odd last row or column is repeated."""
    if photo.shape[0] % 2 or photo.shape[1] % 2:
        photo = np.pad(photo, ((0, photo.shape[0] % 2), (0, photo.shape[1] % 2), (0, 0)), mode="edge")
    wide = np.uint16 if photo.dtype == np.uint8 else np.uint32
    rows = np.add(photo[::2], photo[1::2], dtype=wide)
    total = rows[:, ::2] + rows[:, 1::2]
    return ((total + wide(2)) // wide(4)).astype(photo.dtype)


def _cubic_weights(t: Weights) -> list[Weights]:
    """Keys' kernel (a = -1/2) for the pixels at -1, 0, 1, 2 beside the fraction ``t``."""
    return [
        ((-0.5 * t + 1.0) * t - 0.5) * t,
        (1.5 * t - 2.5) * t * t + 1.0,
        ((-1.5 * t + 2.0) * t + 0.5) * t,
        (0.5 * t - 0.5) * t * t,
    ]


def _linear_weights(t: Weights) -> list[Weights]:
    """The pixels at 0, 1 beside the fraction ``t``; those at -1 and 2 do not count."""
    return [1 - t, t]


def _sample_level(
    photo: Photo,
    positions: NDArray[np.float32],
    where: NDArray[np.bool_],
    scale: float,
    out: Photo,
    weights: Callable[[Weights], list[Weights]],
) -> None:
    """Write into ``out[where]`` the photo, reduced by ``scale``, at ``positions * scale``."""
    height, width = photo.shape[:2]
    # Four channels in one word: one gather instead of three. Two rows and columns are repeated on every side.
    padded = np.zeros((height + 4, width + 4, 4), photo.dtype)
    padded[..., :3] = np.pad(photo, ((2, 2), (2, 2), (0, 0)), mode="edge")
    words = padded.view(np.uint32 if photo.dtype == np.uint8 else np.uint64).reshape(-1)
    flat_out = out.reshape(-1, 3)
    chosen = np.flatnonzero(where)
    for begin in range(0, len(chosen), _SAMPLED_AT_ONCE):
        index = chosen[begin : begin + _SAMPLED_AT_ONCE]
        xy = positions.reshape(-1, 2)[index].astype(np.float64) * scale - 0.5
        floor = np.floor(xy)
        fraction = (xy - floor).astype(np.float32)
        x, y = np.clip(floor.astype(np.int64) + 2, 1, (width + 1, height + 1)).T
        in_x, in_y = weights(fraction[:, :1]), weights(fraction[:, 1:])
        offset = 1 if len(in_x) == 4 else 0
        total = np.zeros((len(index), 4), np.float32)
        for j, weight_y in enumerate(in_y):
            line = np.zeros((len(index), 4), np.float32)
            base = (y + j - offset) * (width + 4) + x - offset
            for i, weight_x in enumerate(in_x):
                line += weight_x * words.take(base + i).view(photo.dtype).reshape(-1, 4)
            total += weight_y * line
        flat_out[index] = np.clip(np.rint(total[:, :3]), 0, _WHITE[photo.dtype]).astype(out.dtype)
