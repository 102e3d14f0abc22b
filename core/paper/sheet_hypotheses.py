"""Regions of an orthophoto that may be a sheet: bounded by a rectangle of edges, or of one colour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..numeric.image import COLOR_WEIGHTS, shrink, whole_blocks
from ..numeric.morphology import Mask, dilated, eroded, fill_holes
from ..numeric.polygon import resample
from .contour import trace_mask
from .orthophoto import Orthophoto

# Cells of the map for one of the coarse map, in which regions are looked for.
COARSE = 3
# Values without a figure are choices; no measurement of each is recorded. Together they put both sheets among the
# hypotheses in 28 of 40 generated scenes with two (see `sheets_in_view.py`).
_ANGLE_STEP = 2.0  # degrees; half of it moves the ends of a side of 150 coarse cells by 1.3
_LINES = 14  # for each angle and axis
_RECTANGLES_PER_ANGLE = 40
_MOST_RECTANGLES = 80  # of all angles
_LEAST_EVEN = 0.05  # mean step, of 1 at most, along the faintest side
_LEAST_DISTANCE = 3.0  # coarse cells between the corners of two rectangles
# Lengths of the windows in which parts of a side are found, and of the shortest side, as parts of the map's shorter
# side.
_WINDOWS = (0.18, 0.36, 0.7)
_SHORTEST_SIDE = 0.12
# Steps of colour are measured at this standard deviation, coarse cells, and not within this many of the map's border.
# The faintest side of a rectangle decides; the mean of all four counts this much.
_BLUR, _BORDER, _OF_MEAN = 1.2, 4, 0.3
# A line is taken if it is the best within this many; its parts begin a third of a window apart, and no window is
# shorter than this many coarse cells.
_BEST_WITHIN, _PARTS, _LEAST_WINDOW = 5, 3, 4
# A step of colour per coarse cell that counts half: what is usual on this table, within these limits. An edge above it
# is an edge, however strong.
_FAINT_STEP = (0.05, 0.4)
# Regions: differences from a main colour, Oklab times 100, and steps of colour per coarse cell, that bound them; radii
# of the openings that separate them, coarse cells; how many main colours there are, and the side of their bins.
_COLOR_LIMITS = (2.5, 4.0, 6.0, 9.0, 13.0, 19.0)
_STEP_LIMITS = (0.35, 0.6, 1.0, 1.7, 3.0, 5.0)
_OPENINGS = (2, 6)
_MAIN_COLORS = 6
_COLOR_BIN = 4.0
# The map of colours loses its grain in a median over squares of this side, its slope is taken at this standard
# deviation, and the outline of a region is smoothed at this one. Coarse cells, the last in points of the outline.
_GRAIN, _SLOPE_OVER, _SMOOTH = 3, 1.0, 1.0
_AIM = 0.2  # of a photo's long side
_SMALLEST, _LARGEST = 0.01, 0.85  # of the map that is known
# Parts of a mask are filled if they have this share of it, and of these only the largest.
_SMALLEST_PART, _MOST_PARTS = 0.004, 6
_SAME = 0.02  # share of their union in which two regions may differ and be one


@dataclass(frozen=True)
class Hypothesis:
    """A region that may be a sheet.

    Attributes
    ----------
    polygon : (K, 2) array
        Map positions of its outline, clockwise.
    mask : (h, w) bool array
        Its cells in the coarse map.
    """

    polygon: Array
    mask: Mask

    @classmethod
    def around(cls, mask: Mask) -> Hypothesis:
        """The region of the coarse cells in a mask, with a smooth outline."""
        outline = resample(trace_mask(mask) * float(COARSE), float(COARSE))
        return cls(ndimage.gaussian_filter1d(outline, _SMOOTH, axis=0, mode="wrap"), mask)


def sheet_hypotheses(ortho: Orthophoto, photo_side: float) -> list[Hypothesis]:
    """All regions that may be a sheet; ``photo_side`` is the length that a photo's long side covers, in cells."""
    color = shrink(ortho.color, COARSE)
    known = whole_blocks(ortho.known, COARSE)
    rows, columns = np.indices(known.shape)
    middle = ortho.from_world(ortho.frame.origin) / COARSE
    aim = np.hypot(columns + 0.5 - middle[0], rows + 0.5 - middle[1]) < _AIM * photo_side / COARSE
    result = [Hypothesis(corners * COARSE, _filled(corners, known.shape)) for corners in rectangles(color, known)]
    result += [Hypothesis.around(mask) for mask in regions(color, known, aim)]
    return [hypothesis for hypothesis in result if hypothesis.mask.any()]


def _filled(corners: Array, shape: tuple[int, ...]) -> Mask:
    """Cells within a convex clockwise polygon (K, 2)."""
    y, x = np.indices(shape) + 0.5
    mask = np.ones(shape, bool)
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        mask &= (x1 - x0) * (y - y0) >= (y1 - y0) * (x - x0)
    return mask


def rectangles(color: NDArray[np.float32], known: Mask) -> list[Array]:
    """Rectangles with an edge along each side, the clearest first; each (4, 2) corners, clockwise, coarse cells.

    The map is turned by every angle; lines along its axes with a long edge on them are paired. A side counts by how
    much of it has an edge with the same step of colour, not by the size of that step: print has higher steps than the
    paper's edge, but gaps between them.
    """
    height, width = known.shape
    side = int(np.ceil(np.hypot(height, width)))
    middle = np.array([width, height]) / 2
    inner = ndimage.binary_erosion(known, iterations=_BORDER)
    across, down = (
        np.stack([ndimage.gaussian_filter(color[..., c], _BLUR, order=order, mode="nearest") for c in range(3)])
        for order in ((0, 1), (1, 0))
    )
    length = np.sqrt((across**2 + down**2).sum(axis=0))
    faint = float(np.clip(np.median(length[inner]), *_FAINT_STEP)) if inner.any() else _FAINT_STEP[1]
    fields = np.concatenate([across, down]) * inner / (length + faint)
    found: list[tuple[float, Array]] = []
    for angle in np.radians(np.arange(0.0, 90.0, _ANGLE_STEP)):
        cosine, sine = np.cos(angle), np.sin(angle)
        # from (row, column) of the turned map to those of the map
        turn = np.array([[cosine, sine], [-sine, cosine]])
        offset = middle[::-1] - 0.5 - turn @ np.full(2, side / 2 - 0.5)
        turned = np.stack([ndimage.affine_transform(field, turn, offset, (side, side), order=1) for field in fields])
        steps_right = cosine * turned[:3] + sine * turned[3:]
        steps_down = -sine * turned[:3] + cosine * turned[3:]
        for score, corners in _upright_rectangles(steps_right, steps_down, min(height, width)):
            found.append((score, (corners[:, ::-1] - side / 2) @ turn.T[:, ::-1] + middle))
    found.sort(key=lambda item: -item[0])
    kept: list[Array] = []
    turns: list[Array] = []
    for _, corners in found:
        if not turns or np.abs(np.array(turns) - corners).max(axis=(1, 2)).min() > _LEAST_DISTANCE:
            kept.append(corners)
            turns += [np.roll(corners, k, axis=0) for k in range(4)]
            if len(kept) == _MOST_RECTANGLES:
                break
    return kept


def _upright_rectangles(
    steps_right: NDArray[np.float32], steps_down: NDArray[np.float32], shorter: int
) -> list[tuple[float, Array]]:
    """Score and corners (4, 2), x and y, of rectangles along the axes of a map of steps (3, h, w)."""
    # sums over each line, so that the mean step along any part of it is one difference
    along_down = np.pad(np.cumsum(steps_right, axis=1), ((0, 0), (1, 0), (0, 0)))
    along_right = np.pad(np.cumsum(steps_down, axis=2), ((0, 0), (0, 0), (1, 0))).transpose(0, 2, 1)
    left, right = _pairs(_likely_lines(along_down, shorter), _SHORTEST_SIDE * shorter)
    top, bottom = _pairs(_likely_lines(along_right, shorter), _SHORTEST_SIDE * shorter)
    left, top = (pair.ravel() for pair in np.meshgrid(left, top))
    right, bottom = (pair.ravel() for pair in np.meshgrid(right, bottom))
    if not len(left):
        return []
    sides = np.stack(
        [
            np.linalg.norm(sums[:, stop, at] - sums[:, start, at], axis=0) / (stop - start)
            for sums, at, start, stop in (
                (along_down, left, top, bottom),
                (along_down, right, top, bottom),
                (along_right, top, left, right),
                (along_right, bottom, left, right),
            )
        ]
    )
    score = sides.min(axis=0) + _OF_MEAN * sides.mean(axis=0)
    best = np.argsort(-score)[:_RECTANGLES_PER_ANGLE]
    best = best[sides.min(axis=0)[best] > _LEAST_EVEN]
    corners = np.stack([[left, top], [right, top], [right, bottom], [left, bottom]])[..., best] + 0.5
    return [(float(score[k]), corners[..., place]) for place, k in enumerate(best)]


def _pairs(lines: NDArray[np.int64], least: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    first, second = np.triu_indices(len(lines), 1)
    apart = lines[second] - lines[first] > least
    return lines[first[apart]], lines[second[apart]]


def _likely_lines(sums: NDArray[np.float32], shorter: int) -> NDArray[np.int64]:
    """Positions of lines that have somewhere a long part with an even step of colour across it."""
    length = sums.shape[1] - 1
    best = np.zeros(sums.shape[2])
    for part in _WINDOWS:
        window = max(int(part * shorter), _LEAST_WINDOW)
        start = np.arange(0, length - window, max(window // _PARTS, 1))
        step = np.linalg.norm(sums[:, start + window] - sums[:, start], axis=0) / np.sqrt(window)
        best = np.maximum(best, step.max(axis=0))
    peaks = np.flatnonzero((best == ndimage.maximum_filter1d(best, _BEST_WITHIN)) & (best > 0))
    return np.sort(peaks[np.argsort(-best[peaks], kind="stable")][:_LINES])


def regions(color: NDArray[np.float32], known: Mask, aim: Mask) -> list[Mask]:
    """Connected regions of about one colour or without a step of colour, their holes filled.

    Parameters
    ----------
    color : (h, w, 3) float32 array
        Oklab times 100.
    known : (h, w) bool array
    aim : (h, w) bool array
        Where the photos are aimed: regions have the colours that are common there.
    """
    smooth = np.stack([ndimage.median_filter(color[..., c], _GRAIN) for c in range(3)], axis=-1)
    smooth *= COLOR_WEIGHTS
    masks: list[Mask] = []
    for main in _main_colors(smooth[aim & known]):
        off = np.linalg.norm(smooth - main, axis=-1)
        for limit in _COLOR_LIMITS:
            masks += _large_parts((off < limit) & known, known)
    step = np.sqrt(sum(ndimage.gaussian_gradient_magnitude(smooth[..., c], _SLOPE_OVER) ** 2 for c in range(3)))
    for limit in _STEP_LIMITS:
        masks += [ndimage.binary_dilation(mask) for mask in _large_parts((step < limit) & known, known)]
    distinct: list[Mask] = []
    for mask in masks:
        if all((mask ^ other).sum() > _SAME * (mask | other).sum() for other in distinct):
            distinct.append(mask)
    return distinct


def _main_colors(colors: NDArray[np.float32]) -> list[NDArray[np.float32]]:
    """The means of the fullest bins of the colours' histogram, none beside another."""
    if not len(colors):
        return []
    bins, which = np.unique(np.round(colors / _COLOR_BIN).astype(np.int64), axis=0, return_inverse=True)
    which = which.ravel()
    chosen: list[int] = []
    for fullest in np.argsort(-np.bincount(which), kind="stable"):
        if all(np.abs(bins[fullest] - bins[other]).max() > 1 for other in chosen):
            chosen.append(int(fullest))
            if len(chosen) == _MAIN_COLORS:
                break
    return [colors[which == place].mean(axis=0) for place in chosen]


def _large_parts(mask: Mask, known: Mask) -> list[Mask]:
    """Large parts of a mask that hold together by more than a thread, holes filled."""
    total = known.sum()
    closed = ndimage.binary_closing(mask)
    result = []
    for radius in _OPENINGS:
        parts, _ = ndimage.label(eroded(closed, radius))
        area = np.bincount(parts.ravel())
        area[0] = 0
        for part in np.argsort(-area, kind="stable")[:_MOST_PARTS]:
            if area[part] < _SMALLEST_PART * total:
                break
            filled = fill_holes(dilated(parts == part, radius))
            if _SMALLEST * total < filled.sum() < _LARGEST * total:
                result.append(filled)
    return result
