"""Which way up a page is read, from its print."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from .camera import Array

_LONGEST = 2000  # pixels to which the page is reduced
_FEWEST_WORDS = 12
_CHUNK = 12  # letter heights: print is looked at in pieces no longer than this, so that a slight slant does no harm


def reading_direction(page_grey: NDArray[np.number]) -> tuple[int, float]:
    """Find the rotation after which lines of Latin-like print run across the page and stand upright.

    Lines are rows of letters with gaps between rows. Which way up they stand shows in the letters: more of them reach
    above the others (b d f h k l t and capitals) than below (g p q y).

    Parameters
    ----------
    page_grey : (H, W) array
        Brightness of the flat page, dark print on lighter paper or the reverse.

    Returns
    -------
    quarter_turns : int
        Clockwise quarter turns to apply, 0 to 3: ``np.rot90(page, -quarter_turns)`` is upright.
    confidence : float
        0 to 1. Below 0.5 the print does not tell.
    """
    ink = _ink(np.asarray(page_grey, float))
    height = _letter_height(ink)
    if height is None:
        return 0, 0.0
    candidates = []
    for turns in (0, 1):
        evidence = _line_evidence(np.rot90(ink, -turns), height)
        candidates.append(evidence)
    rows, columns = (len(evidence) for evidence in candidates)
    turns = int(columns > rows)
    words = candidates[turns]
    share = len(words) / max(rows + columns, 1)
    if len(words) < _FEWEST_WORDS:
        return turns, 0.0
    total = words.sum(axis=0)
    asymmetry = (total[0] - total[1]) / max(total[0] + total[1], 1e-9)
    difference = words[:, 0] - words[:, 1]
    spread = difference.std() / np.sqrt(len(words)) + 1e-9
    score = abs(difference.mean()) / spread
    upside_down = asymmetry < 0
    across = np.clip((share - 0.6) / 0.3, 0, 1)
    upright = np.clip(abs(asymmetry) / 0.3, 0, 1) * np.clip((score - 1) / 6, 0, 1)
    return turns + 2 * int(upside_down), float(across * upright)


def _ink(page: Array) -> Array:
    """How much each pixel stands out from the paper around it, 0 to 1."""
    step = max(1.0, max(page.shape) / _LONGEST)
    if step > 1:
        page = ndimage.zoom(ndimage.gaussian_filter(page, 0.5 * (step - 1)), 1 / step, order=1)
    page = page / max(float(np.ptp(page)), 1e-9)
    paper = ndimage.gaussian_filter(ndimage.median_filter(page[::4, ::4], 15), 4)
    paper = ndimage.zoom(paper, np.array(page.shape) / paper.shape, order=1)
    contrast = np.abs(paper - page)
    strong = np.quantile(contrast, 0.98)
    return np.clip(contrast / max(strong, 0.02), 0, 1)


def _letter_height(ink: Array) -> float | None:
    """The usual height of a letter in pixels, whichever way it is turned; None where there are no letters."""
    parts, count = ndimage.label(ink > 0.4, np.ones((3, 3)))
    if count == 0:
        return None
    boxes = ndimage.find_objects(parts)
    sizes = np.array([[s.stop - s.start for s in box] for box in boxes])
    letters = (sizes.min(axis=1) >= 3) & (sizes.max(axis=1) <= 60) & (sizes.max(axis=1) <= 4 * sizes.min(axis=1))
    if letters.sum() < 3 * _FEWEST_WORDS:
        return None
    return float(np.median(np.sqrt(sizes[letters].prod(axis=1))))


def _line_evidence(ink: Array, height: float) -> Array:
    """Ink above and below the body of the letters in each piece of a line of print, as shares of the body's, (N, 2)."""
    dark = ink > 0.4
    # Letters of one line run together; lines stay apart.
    smeared = ndimage.uniform_filter1d(dark.astype(float), max(3, int(1.5 * height)), axis=1) > 0.15
    lines, _ = ndimage.label(smeared)
    evidence = []
    for number, box in enumerate(ndimage.find_objects(lines), 1):
        tall, wide = (s.stop - s.start for s in box)
        if not (0.7 * height <= tall <= 4 * height and wide >= 4 * tall):
            continue
        pieces = max(1, round(wide / (_CHUNK * height)))
        edges = np.linspace(box[1].start, box[1].stop, pieces + 1).astype(int)
        top = max(0, box[0].start - int(height))
        bottom = min(len(ink), box[0].stop + int(height))
        for left, right in zip(edges[:-1], edges[1:], strict=True):
            mine = lines[top:bottom, left:right]
            profile = np.where((mine == number) | (mine == 0), ink[top:bottom, left:right], 0).sum(axis=1)
            found = _above_and_below(profile)
            if found is not None:
                evidence.append(found)
    return np.array(evidence).reshape(-1, 2)


def _above_and_below(profile: Array) -> tuple[float, float] | None:
    """Ink above and below the rows that most letters fill, as shares of the ink in them."""
    peak = np.sort(profile)[-3:].mean()
    body = np.flatnonzero(profile >= 0.5 * peak)
    top, bottom = body[0], body[-1] + 1
    size = bottom - top
    if size < 4 or len(body) < 0.7 * size:
        return None
    gap, reach = max(1, round(0.15 * size)), max(2, round(0.65 * size))
    inside = profile[top:bottom].sum()
    above = profile[max(0, top - reach) : max(0, top - gap)].sum() / inside
    below = profile[bottom + gap : bottom + reach].sum() / inside
    return float(above), float(below)
