"""The sides of a page on the flat map: straight lines through them, and the rotation that aligns them with the axes.

The outline of a sheet scatters about its sides and is worse at corners, and the surface is least certain at the
margins. The page is only turned and cut: moving the margins onto the sides would bend the print.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..flat.sides import sides
from ..numeric.robust import MAD_TO_SIGMA
from ..sheet import Sheet

# Values without a figure are choices; no measurement of them is recorded.
# Sine of the angle by which two sides may deviate from perpendicular.
_MOST_SKEW = 0.05
# If this percentage of a side is not within this distance (of the page's length), it is torn or not a side: nothing is
# cut there. A corner may flare by more. Choices.
_OF_SIDE, _MOST_WAVE = 90, 0.02
# No outline follows a side better than this share of the page's length: 0.03 to 0.2 mm on the rendered letters.
_LEAST_SCATTER = 5e-4
# Cauchy's loss turns over at this many times the scatter.
_CAUCHY_SCALE = 2.0
# Rounds of reweighting; in turning, sides further than these angles from the mean of the last round do not vote.
_ITERATIONS = 30
_VOTING_WITHIN = (np.pi / 4, np.radians(10), np.radians(3))


def turn_to_sides(sheet: Sheet, uv: Array) -> Array:
    """Rotation (2, 2) that aligns the page's sides with the axes.

    Each side votes for an angle modulo 90 degrees, weighted by the certainty of the angle of a line through it. If a
    sheet does not show four sides at right angles, each piece of its edge votes with its length instead. The votes are
    averaged again around their mean without outliers, so torn or flared parts do not turn the page.

    Parameters
    ----------
    sheet : Sheet
    uv : (V, 2) array
        Flat coordinates.
    """
    lines = [_line_through(uv[run]) for run in sides(sheet)]
    directions = np.array([line.direction for line in lines])
    if _is_rectangle(directions):
        floor = _LEAST_SCATTER * max(line.length for line in lines)
        weight = np.array([(line.length / max(line.scatter, floor)) ** 2 for line in lines])
    else:
        directions = np.diff(uv[np.append(sheet.boundary, sheet.boundary[0])], axis=0)
        weight = np.linalg.norm(directions, axis=1)
    angle = np.arctan2(directions[:, 1], directions[:, 0])
    mean = 0.0
    for spread in _VOTING_WITHIN:
        apart = (angle - mean + np.pi / 4) % (np.pi / 2) - np.pi / 4
        mean += np.angle((weight * (np.abs(apart) <= spread) * np.exp(4j * apart)).sum()) / 4
    cosine, sine = np.cos(mean), np.sin(mean)
    return np.array([[cosine, sine], [-sine, cosine]])


def page_rectangle(sheet: Sheet, uv: Array) -> tuple[Array, Array]:
    """The corners of the page: its sides, or the extent of the sheet where there is no side.

    Parameters
    ----------
    sheet : Sheet
    uv : (V, 2) array
        Flat coordinates with the sides roughly along the axes.

    Returns
    -------
    low, high : (2,) arrays
    """
    low, high = uv.min(0), uv.max(0)
    length, middle = float((high - low).max()), (low + high) / 2
    found: dict[tuple[int, bool], float] = {}
    runs = sides(sheet)
    for run in runs:
        axis = 0 if np.ptp(uv[run, 1]) > np.ptp(uv[run, 0]) else 1
        place = float(np.median(uv[run, axis]))
        straight = np.percentile(np.abs(uv[run, axis] - place), _OF_SIDE) <= _MOST_WAVE * length
        found[axis, place > middle[axis]] = place if straight else np.nan
    if len(found) != 4:
        return low, high
    for (axis, is_high), place in found.items():
        if np.isfinite(place):
            (high if is_high else low)[axis] = place
    return low, high


@dataclass(frozen=True)
class _Line:
    """A unit vector along a side, the robust standard deviation of its vertices about the line, and its length."""

    direction: Array
    scatter: float
    length: float


def _line_through(points: Array) -> _Line:
    """Total least squares with Cauchy's loss."""
    weight = np.ones(len(points))
    for _ in range(_ITERATIONS):
        offset = points - weight @ points / weight.sum()
        direction = np.linalg.eigh((offset * weight[:, None]).T @ offset)[1][:, 1]
        across = np.abs(offset @ np.array([-direction[1], direction[0]]))
        scatter = MAD_TO_SIGMA * float(np.median(across))
        weight = 1 / (1 + (across / max(_CAUCHY_SCALE * scatter, 1e-300)) ** 2)
    return _Line(direction, scatter, float(np.ptp(offset @ direction)))


def _is_rectangle(directions: Array) -> bool:
    """Whether unit vectors along the sides of a page, in order, are nearly perpendicular."""
    if len(directions) != 4:
        return False
    return bool((np.abs((directions * np.roll(directions, -1, axis=0)).sum(1)) < _MOST_SKEW).all())
