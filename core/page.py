"""From the flat map to the page: straight sides, true size, the right way up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .camera import Array, Camera
from .sheet import FlatMap, Sheet
from .sides import sides


@dataclass(frozen=True)
class PaperSize:
    """What the user knows of the paper.

    Attributes
    ----------
    width : float
        Millimetres; of a sheet whose height is known too, either way round.
    height : float or None
        Millimetres; None for paper from a roll.
    """

    width: float
    height: float | None = None


def lay_out(
    sheet: Sheet,
    uv: Array,
    reference: Camera,
    up: Array,
    paper: PaperSize | None = None,
    *,
    quarter_turns: int = 0,
) -> FlatMap:
    """Turn, place and scale a flat map so that it is a page.

    Parameters
    ----------
    sheet : Sheet
    uv : (V, 2) array
        As from `flatten`.
    reference : Camera
    up : (2,) array
        Direction in the reference photo, in pixels (y down), that is to point upwards on the page.
    paper : PaperSize, optional
    quarter_turns : int
        Turns by 90 degrees, clockwise, that the page needs after that for its text to stand upright.

    Returns
    -------
    FlatMap
        Holding the whole sheet: nothing of the mesh lies outside the page.
    """
    upright = uv @ _turn_to_sides(sheet, uv).T
    quarters = _quarters_to(_photo_direction(sheet, upright, reference, up)) + quarter_turns
    for _ in range(quarters % 4):
        upright = np.stack([-upright[:, 1], upright[:, 0]], axis=1)
    low, high = upright.min(0), upright.max(0)
    millimetres = None if paper is None else _millimetres_per_unit(sheet, upright, paper)
    scale = millimetres or 1 / (high[1] - low[1])
    width, height = (high - low) * scale
    unit = "page heights" if millimetres is None else "mm"
    return FlatMap((upright - low) * scale, float(width), float(height), unit, millimetres)


def side_lengths(sheet: Sheet, uv: Array) -> tuple[float, float]:
    """Width and height between opposite sides of a page whose sides lie along the axes.

    Sides are taken in their middle, by the median: a ragged edge or a flared corner does not count. A sheet that
    does not show four corners is measured between its extremes.
    """
    runs = sides(sheet)
    if len(runs) != 4:
        width, height = np.ptp(uv, axis=0)
        return float(width), float(height)
    places = []
    for run in runs:
        across = 0 if np.ptp(uv[run, 1]) > np.ptp(uv[run, 0]) else 1
        places.append((across, float(np.median(uv[run, across]))))
    lengths = []
    for axis in (0, 1):
        along = [place for across, place in places if across == axis]
        lengths.append(max(along) - min(along) if len(along) == 2 else float(np.ptp(uv[:, axis])))
    return lengths[0], lengths[1]


def _millimetres_per_unit(sheet: Sheet, uv: Array, paper: PaperSize) -> float:
    """Scale that gives the page its known size: by the width alone, or by the area where both are known."""
    width, height = side_lengths(sheet, uv)
    if paper.height is None:
        return paper.width / min(width, height)
    return float(np.sqrt(paper.width * paper.height / (width * height)))


def _turn_to_sides(sheet: Sheet, uv: Array) -> Array:
    """Rotation (2, 2) that lays the page's sides along the axes.

    Each piece of the edge votes with its length for an angle modulo 90 degrees. The votes are averaged again around
    their mean with the stragglers left out, so that torn or flared parts do not turn the page.
    """
    edge = uv[np.append(sheet.boundary, sheet.boundary[0])]
    if len(runs := sides(sheet)) == 4:
        pieces = np.array([uv[run[-1]] - uv[run[0]] for run in runs])
    else:
        pieces = np.diff(edge, axis=0)
    length = np.linalg.norm(pieces, axis=1)
    angle = np.arctan2(pieces[:, 1], pieces[:, 0])
    mean = 0.0
    for spread in (np.pi / 4, np.radians(10), np.radians(3)):
        apart = (angle - mean + np.pi / 4) % (np.pi / 2) - np.pi / 4
        weight = length * (np.abs(apart) <= spread)
        mean += np.angle((weight * np.exp(4j * apart)).sum()) / 4
    cosine, sine = np.cos(mean), np.sin(mean)
    return np.array([[cosine, sine], [-sine, cosine]])


def _photo_direction(sheet: Sheet, uv: Array, camera: Camera, direction: Array) -> Array:
    """Where a direction in the photo points on the page, (2,), by the affine map that fits best."""
    pixels = camera.project(sheet.vertices)
    design = np.column_stack([pixels, np.ones(len(pixels))])
    affine = np.linalg.lstsq(design, uv, rcond=None)[0]
    return direction @ affine[:2]


def _quarters_to(up: Array) -> int:
    """Clockwise quarter turns after which a direction on the page (v down) points most nearly up."""
    return int(np.round(np.degrees(np.arctan2(-up[0], -up[1])) / 90)) % 4
