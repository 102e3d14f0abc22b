"""Find which way up a page is, from its print."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array

# The values below are choices; no measurement of them is recorded.
_LONGEST = 2000  # pixels to which the page's longer side is reduced
# Ink: the paper's brightness is the median and mean of such neighbourhoods on every so many pixels, wider than letters.
# The contrast of print is that quantile of all contrast, but at least this share of the brightness range; what has less
# than the share of it below is paper, and what has more than the last share is part of a letter.
_EVERY, _MEDIAN, _MEAN = 4, 15, 4
_PRINT_QUANTILE, _LEAST_PRINT = 0.98, 0.02
_NOISE, _LETTER_INK = 0.2, 0.25
# Letters: their least and largest side in pixels, and the largest ratio of their sides.
_SMALLEST_LETTER, _LARGEST_LETTER, _MOST_OBLONG = 3, 60, 4
_FEWEST_LINES, _LETTERS = 15, 3  # pieces of lines, and letters that there must be for each
_STRIP = 15  # letter heights: so narrow that a slanted line stays in its rows
_LINE_DISTANCE = 6  # letter heights over which ink comes and goes from line to line
# A line: its fullest row within this many letter heights holds at least this share of ink, and its body is the rows
# with this share of that, between these heights, pixels and letter heights.
_FULLEST_WITHIN, _LEAST_INK, _BODY = 2, 0.05, 0.5
_LEAST_BODY, _LOWEST_BODY, _HIGHEST_BODY = 4, 0.4, 2
# Ascenders and descenders are measured from the one distance from the body to the other, in heights of the body.
_GAP, _REACH = 0.15, 0.65
# Confidence: begins at this ratio of the contrasts of rows and columns and is full this much above; it is also
# proportional to the asymmetry of ascenders and descenders up to this one, and to its significance (standard errors),
# which begins at the first and is full this much above.
_ACROSS_BEGINS, _ACROSS_FULL = 1.2, 0.6
_FULL_ASYMMETRY, _SIGNIFICANCE_BEGINS, _SIGNIFICANCE_FULL = 0.2, 2, 4


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
        0 to 1. Below 0.5 the print does not show the direction.
    """
    ink = _ink(np.asarray(page_grey, float))
    height = _letter_height(ink)
    if height is None:
        return 0, 0.0
    profiles = [_strip_profiles(np.rot90(ink, -turns), height) for turns in (0, 1)]
    contrast = [_line_contrast(profile, height) for profile in profiles]
    turns = int(contrast[1] > contrast[0])
    across = contrast[turns] / max(contrast[1 - turns], 1e-9)
    lines = np.array([line for strip in profiles[turns] for line in _lines(strip, height)]).reshape(-1, 2)
    if len(lines) < _FEWEST_LINES:
        return turns, 0.0
    above, below = lines.sum(axis=0)
    asymmetry = (above - below) / max(above + below, 1e-9)
    difference = lines[:, 0] - lines[:, 1]
    significance = abs(difference.mean()) * np.sqrt(len(lines)) / max(difference.std(), 1e-9)
    sure_across = np.clip((across - _ACROSS_BEGINS) / _ACROSS_FULL, 0, 1)
    sure_upright = np.clip(abs(asymmetry) / _FULL_ASYMMETRY, 0, 1)
    sure_upright *= np.clip((significance - _SIGNIFICANCE_BEGINS) / _SIGNIFICANCE_FULL, 0, 1)
    return turns + 2 * int(asymmetry < 0), float(sure_across * sure_upright)


def _ink(page: Array) -> Array:
    """How much each pixel stands out from the paper around it, 0 to 1."""
    step = max(1.0, max(page.shape) / _LONGEST)
    if step > 1:
        page = ndimage.zoom(ndimage.gaussian_filter(page, 0.5 * (step - 1)), 1 / step, order=1)
    page = page / max(float(np.ptp(page)), 1e-9)
    paper = ndimage.gaussian_filter(ndimage.median_filter(page[::_EVERY, ::_EVERY], _MEDIAN), _MEAN)
    paper = ndimage.zoom(paper, np.array(page.shape) / paper.shape, order=1)
    contrast = np.abs(paper - page)
    strong = max(float(np.quantile(contrast, _PRINT_QUANTILE)), _LEAST_PRINT)
    return np.clip(contrast / strong - _NOISE, 0, 1)


def _letter_height(ink: Array) -> float | None:
    """The usual height of a letter in pixels, whichever way it is turned; None where there are no letters."""
    parts, count = ndimage.label(ink > _LETTER_INK, np.ones((3, 3)))
    if count == 0:
        return None
    boxes = ndimage.find_objects(parts)
    sizes = np.array([[s.stop - s.start for s in box] for box in boxes])
    shorter, longer = sizes.min(axis=1), sizes.max(axis=1)
    letters = (shorter >= _SMALLEST_LETTER) & (longer <= _LARGEST_LETTER) & (longer <= _MOST_OBLONG * shorter)
    if letters.sum() < _LETTERS * _FEWEST_LINES:
        return None
    return float(np.median(np.sqrt(sizes[letters].prod(axis=1))))


def _strip_profiles(ink: Array, height: float) -> Array:
    """Ink in each row (S, H) of upright strips of the page, narrow enough that a slight slant does no harm."""
    count = max(1, round(ink.shape[1] / (_STRIP * height)))
    edges = np.linspace(0, ink.shape[1], count + 1).astype(int)
    return np.array([ink[:, left:right].mean(axis=1) for left, right in itertools.pairwise(edges)])


def _line_contrast(profiles: Array, height: float) -> float:
    """How much the ink comes and goes from row to row within a few lines."""
    around = ndimage.uniform_filter1d(profiles, max(3, round(_LINE_DISTANCE * height)), axis=1)
    return float(((profiles - around) ** 2).mean())


def _lines(profile: Array, height: float) -> Iterator[tuple[float, float]]:
    """Ink above and below the body of the letters of each line of a strip, as shares of the ink in the body."""
    peak = ndimage.maximum_filter1d(profile, max(3, round(_FULLEST_WITHIN * height)))
    body = (profile >= _BODY * peak) & (peak >= _LEAST_INK)
    starts, stops = np.flatnonzero(np.diff(body.astype(int), prepend=0, append=0)).reshape(-1, 2).T
    for number, (top, bottom) in enumerate(zip(starts, stops, strict=True)):
        size = bottom - top
        if not max(_LEAST_BODY, _LOWEST_BODY * height) <= size <= _HIGHEST_BODY * height:
            continue
        gap, reach = max(1, round(_GAP * size)), max(2, round(_REACH * size))
        # not beyond the middle between two lines, where the other line begins
        ceiling = (stops[number - 1] + top) // 2 if number > 0 else 0
        floor = (bottom + starts[number + 1] + 1) // 2 if number + 1 < len(starts) else len(profile)
        room = min(reach, top - ceiling, floor - bottom)
        if room <= gap:
            continue
        inside = profile[top:bottom].sum()
        above = profile[top - room : top - gap].sum() / inside
        below = profile[bottom + gap : bottom + room].sum() / inside
        yield float(above), float(below)
