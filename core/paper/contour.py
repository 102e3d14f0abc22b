"""Closed contours: around a mask, evenly spaced, snapped to the edge in a photo, smoothed without losing corners."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..numeric.image import perceptual, sample_bilinear
from ..numeric.local_fit import local_fits
from ..numeric.peaks import peak_offset
from ..numeric.polygon import resample, signed_area

# Values without a figure are choices; no measurement of them is recorded.
# A detour is cut out if it is no longer than this part of the outline, and if the sides before and after it, taken over
# this part of the outline and at least so many points, agree in direction with the short cut (cosine).
_LONGEST_DETOUR = 0.08
_LENGTH_STEP = 2  # points, between the lengths of detours that are tried
_SIDE, _LEAST_SIDE = 0.012, 6
_STRAIGHT = 0.98
# It must be so many times longer than the short cut: more is required where paper might be lost than where some is won.
_LEAST_GAIN_INWARDS, _LEAST_GAIN_OUTWARDS = 1.1, 1.3
# All but this part of the short cut must lie on an edge of this share of the outline's median edge, colour difference
# per pixel, which counts up to this value: an outline with strong edges must not exclude a faint side. An edge counts
# in a square of this side around it, because a short cut is straight and the paper's side is hardly ever.
_WITHOUT_EDGE, _LEAST_EDGE, _USUAL_EDGE, _BESIDE_EDGE = 0.2, 0.3, 3.0, 3
# The snapped path: the normals are smoothed over so many points, and the profiles across it over so many points along
# it and pixels across it; samples beyond the reach that the blur needs.
_SMOOTH_NORMALS, _BLUR_ALONG, _BLUR_ACROSS, _MARGIN = 4.0, 1.0, 1.0, 6
# Pixels nearer than this to the photo's border have no complete neighbourhood. A contour that comes within this part of
# the reach to the border runs along it.
_INCOMPLETE, _AT_FRAME = 1.5, 0.2
# An edge counts fully from this percentile of the strongest edges of so many points around it; an edge at the end of
# the reach costs this more than one in the middle, in units of a full edge.
_FULL_EDGE, _AROUND, _FAR_COST = 60, 61, 0.3
# Largest shift between neighbours of the snapped path, samples, and the part of the loop by which its ends overlap.
_MOST_JUMP, _OVERLAP = 3, 8
# The misfit of the parabola about a point counts so much: if leaving it were free, noise alone would choose another.
_PREFER_CENTRE = 0.7
# Parabolas: a point counts less beyond this distance, all points beyond the second distance alike, and this is added to
# the mean square, so that hardly different misfits do not decide. Distances in pixels (in `raggedness`, places). Found
# in so many rounds of reweighting, with this on the diagonal of the normal equations, because points of no weight
# determine no parabola.
_FIT_SCALE, _FIT_LIMIT, _FIT_FLOOR = 0.7, 6.0, 0.01
_FIT_ROUNDS, _FIT_RIDGE = 3, 1e-9
# Two lines make a corner if they turn by this (sine of the angle) and cross within so many gaps between their points.
_LEAST_TURN, _NEAR_CORNER = 0.1, 2.0
# Raggedness is measured at so many places along an outline, by parabolas through so many of them each: about a
# fiftieth of the outline, far shorter than a side.
_PLACES = 1000
_STRETCH = 18
_STRETCHES = (-_STRETCH, -_STRETCH // 2, 0)


def trace_mask(mask: NDArray[np.bool_]) -> Array:
    """The outer border of a connected mask as a polygon (K, 2) of pixel corners, clockwise on screen.

    Where two pixels touch only by a corner, the border keeps them apart.
    """
    padded = np.pad(mask, 1)
    follows: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for step, neighbour, offset in (
        ((1, 0), padded[:-2, 1:-1], (0, 0)),
        ((0, 1), padded[1:-1, 2:], (1, 0)),
        ((-1, 0), padded[2:, 1:-1], (1, 1)),
        ((0, -1), padded[1:-1, :-2], (0, 1)),
    ):
        rows, columns = np.nonzero(mask & ~neighbour)
        for x, y in zip((columns + offset[0]).tolist(), (rows + offset[1]).tolist(), strict=True):
            follows.setdefault((x, y), []).append(step)
    loops = []
    while follows:
        start = next(iter(follows))
        here, loop, came = start, [], (1, 0)
        while here in follows:
            steps = follows[here]
            right_turn = (-came[1], came[0])
            step = right_turn if right_turn in steps else steps[0]
            steps.remove(step)
            if not steps:
                del follows[here]
            loop.append(here)
            here, came = (here[0] + step[0], here[1] + step[1]), step
        loops.append(np.array(loop, dtype=float))
    return max(loops, key=lambda loop: abs(signed_area(loop)))


def take_short_cuts(points: Array, gradient: NDArray[np.float32]) -> Array:
    """Cut out short detours of a contour if its side continues straight past them along an edge of the photo.

    Such detours come from a patch of the table that looks like the paper, or the reverse.

    Parameters
    ----------
    points : (M, 2) array
        Evenly spaced about one pixel apart, clockwise.
    gradient : (h, w) array
        Length of the colour gradient in the same pixels.
    """
    widest = ndimage.maximum_filter(gradient, _BESIDE_EDGE)
    count = len(points)
    lead = max(round(_SIDE * count), _LEAST_SIDE)
    before = _unit(points - np.roll(points, lead, axis=0))
    after = _unit(np.roll(points, -lead, axis=0) - points)
    typical = float(np.median(_edge_along(widest, points)))
    found: list[tuple[float, int, int]] = []
    for length in range(lead, round(_LONGEST_DETOUR * count), _LENGTH_STEP):
        chord = np.roll(points, -length, axis=0) - points
        direction = _unit(chord)
        following = np.roll(after, -length, axis=0)
        runs_on = np.minimum((before * direction).sum(axis=1), (following * direction).sum(axis=1)) > _STRAIGHT
        gain = length / np.maximum(np.linalg.norm(chord, axis=1), 1e-9)
        bulge = np.roll(points, -(length // 2), axis=0) - points
        outwards = direction[:, 1] * bulge[:, 0] > direction[:, 0] * bulge[:, 1]
        least = np.where(outwards, _LEAST_GAIN_OUTWARDS, _LEAST_GAIN_INWARDS)
        starts = np.flatnonzero(runs_on & (gain > least))
        share = np.linspace(0, 1, length)[:, None]
        edge = _edge_along(widest, points[starts, None] + share * chord[starts, None])
        has_edge = np.quantile(edge, _WITHOUT_EDGE, axis=1) > _LEAST_EDGE * min(typical, _USUAL_EDGE)
        found += [(float(gain[start]), int(start), length) for start in starts[has_edge]]
    keep = np.ones(count, bool)
    for _, start, length in sorted(found, reverse=True):
        inner = (start + np.arange(1, length)) % count
        if keep[inner].all() and keep[start] and keep[(start + length) % count]:
            keep[inner] = False
    return points[keep]


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12))


def _edge_along(widest: NDArray[np.float32], points: Array) -> Array:
    columns = np.clip(points[..., 0].astype(int), 0, widest.shape[1] - 1)
    rows = np.clip(points[..., 1].astype(int), 0, widest.shape[0] - 1)
    return np.asarray(widest[rows, columns], dtype=np.float64)


def outward_normals(points: Array, sigma: float) -> Array:
    """Unit normals (M, 2) of an evenly spaced clockwise contour, smoothed over ``sigma`` points."""
    tangent = ndimage.gaussian_filter1d(points, sigma, axis=0, order=1, mode="wrap")
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
    return np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)


@dataclass(frozen=True)
class Snapped:
    """The edge near a contour.

    Attributes
    ----------
    points : (M, 2) array
        Pixels.
    strength : (M,) array
        Colour step across the edge, 0 to about 100.
    at_frame : (M,) bool array
        Where the contour runs along the border of the photo, which is not an edge.
    """

    points: Array
    strength: Array
    at_frame: NDArray[np.bool_]


def snap(
    linear: NDArray[np.float32], points: Array, reach: float, step: float, stiffness: float, in_linear_light: bool
) -> Snapped:
    """Move each point of a contour along its normal to the edge there, as one path of least cost.

    Parameters
    ----------
    linear : (h, w, 3) float32 array
        The photo in linear light.
    points : (M, 2) array
        Evenly spaced, clockwise, pixels.
    reach : float
        How far to look inwards and outwards, pixels.
    step : float
        Distance between samples along the normal, pixels.
    stiffness : float
        Cost of one pixel of difference between the shifts of neighbours, in units of a full edge.
    in_linear_light : bool
        Whether the steepest place is sought in linear light, in which a blurred edge has it exactly at the edge, or in
        perceptual colour, in which dim edges count like bright ones.
    """
    normals = outward_normals(points, _SMOOTH_NORMALS)
    half = int(np.ceil(reach / step))
    shifts = np.arange(-half, half + 1) * step
    margin = np.arange(-half - _MARGIN, half + _MARGIN + 1) * step
    positions = points[:, None] + margin[None, :, None] * normals[:, None]
    sampled = sample_bilinear(linear, positions)
    profile = 100 * sampled if in_linear_light else perceptual(sampled)
    profile = ndimage.gaussian_filter1d(profile, _BLUR_ALONG, axis=0, mode="wrap")
    slope = ndimage.gaussian_filter1d(profile, _BLUR_ACROSS / step, axis=1, order=1, mode="nearest")[
        :, _MARGIN:-_MARGIN
    ]
    strength = np.sqrt((slope**2).sum(axis=2))
    height, width = linear.shape[:2]
    at = positions[:, _MARGIN:-_MARGIN]
    beyond = (at < _INCOMPLETE).any(axis=2)
    beyond |= (at[..., 0] > width - _INCOMPLETE) | (at[..., 1] > height - _INCOMPLETE)
    strength[beyond] = 0
    border = _AT_FRAME * reach
    at_frame = ((points < border) | (points > np.array([width, height]) - border)).any(axis=1)
    strength[at_frame] = 0
    peak = ndimage.percentile_filter(strength.max(axis=1), _FULL_EDGE, size=_AROUND, mode="wrap")
    cost = -np.minimum(strength / np.maximum(peak, 1e-6)[:, None], 1.0)
    cost += _FAR_COST * (shifts / reach)[None, :] ** 2
    path = _cheapest_loop(cost, stiffness * step)
    rows = np.arange(len(points))
    inner = np.clip(path, 1, len(shifts) - 2)
    before, here, after = (strength[rows, inner + offset] for offset in (-1, 0, 1))
    shift = shifts[inner] + np.clip(peak_offset(before, here, after), -1, 1) * step
    # the step of a blurred edge: peak slope (per sample) times the width of the blur
    return Snapped(points + shift[:, None] * normals, here * (np.sqrt(2 * np.pi) / step), at_frame)


def _cheapest_loop(cost: Array, stiffness: float) -> NDArray[np.int64]:
    """Column of each row of ``cost`` (M, K) on the closed path of least cost; neighbours differ by a few columns.

    The loop is cut open and extended at both ends by a part of itself, which is dropped afterwards.
    """
    rows, columns = cost.shape
    overlap = rows // _OVERLAP
    order = (np.arange(rows + 2 * overlap) - overlap) % rows
    jump_cost = stiffness * np.abs(np.arange(-_MOST_JUMP, _MOST_JUMP + 1))
    everywhere = np.arange(columns)
    # the totals that each column can be reached from are windows of one array, without copies
    padded = np.full(columns + 2 * _MOST_JUMP, np.inf)
    total = padded[_MOST_JUMP:-_MOST_JUMP]
    reached_from = sliding_window_view(padded, len(jump_cost))
    total[:] = cost[order[0]]
    back = np.zeros((len(order), columns), np.int64)
    for index in range(1, len(order)):
        candidates = reached_from + jump_cost
        back[index] = candidates.argmin(axis=1)
        total[:] = candidates[everywhere, back[index]] + cost[order[index]]
    path = np.empty(len(order), np.int64)
    path[-1] = total.argmin()
    for index in range(len(order) - 1, 0, -1):
        path[index - 1] = path[index] + back[index, path[index]] - _MOST_JUMP
    return path[overlap : overlap + rows]


def smooth_sides(points: Array, weights: Array, window: int) -> Array:
    """Smooth an evenly spaced contour and keep its corners and kinks.

    Three robust, weighted parabolas are fitted at each point: to the ``window`` points before, after and around it. The
    one that fits best is taken, so no parabola spans a corner. Where that changes from the points before to the points
    after, and the two parabolas meet at an angle, the corner is where they cross.

    Parameters
    ----------
    points : (M, 2) array
        Pixels.
    weights : (M,) array
        Trust in each point, at least 0.

    Returns
    -------
    (K, 2) array
        The smoothed contour with its corners inserted.
    """
    count = len(points)
    before, centre, after = (
        _parabolas(points, weights, np.arange(first, first + window + 1)) for first in (-window, -window // 2, 0)
    )
    misfit = np.stack([before.misfit, _PREFER_CENTRE * centre.misfit, after.misfit])
    choice = misfit.argmin(axis=0)
    positions = np.stack([before.position, centre.position, after.position])
    tangents = np.stack([before.tangent, centre.tangent, after.tangent])
    every = np.arange(count)
    smooth, tangent = positions[choice, every], tangents[choice, every]
    result: list[Array] = []
    for index in range(count):
        following = (index + 1) % count
        result.append(smooth[index])
        if choice[index] == 0 and choice[following] == 2:
            corner = _crossing(smooth[index], tangent[index], smooth[following], tangent[following])
            if corner is not None:
                result.append(corner)
    return np.array(result)


def raggedness(points: Array) -> Array:
    """How far each part of a closed contour strays from a smooth line or a corner of two.

    Parameters
    ----------
    points : (M, 2) array
        Clockwise.

    Returns
    -------
    (N,) array
        At places evenly spaced along the contour: root mean square distance from the parabola that fits best before,
        around or after the place, as a part of that parabola's length.
    """
    closed = np.vstack([points, points[:1]])
    spacing = float(np.linalg.norm(np.diff(closed, axis=0), axis=1).sum()) / _PLACES
    places = resample(points, spacing)
    if len(places) <= _STRETCH:
        return np.zeros(len(places))
    trust = np.ones(len(places))
    fits = (_parabolas(places / spacing, trust, np.arange(at, at + _STRETCH + 1)) for at in _STRETCHES)
    return np.sqrt(np.min([fit.misfit for fit in fits], axis=0)) / _STRETCH


@dataclass(frozen=True)
class _Parabolas:
    position: Array
    tangent: Array
    misfit: Array


def _parabolas(points: Array, weights: Array, offsets: NDArray[np.int64]) -> _Parabolas:
    """Position, tangent and weighted mean square misfit at each point of the parabola through its neighbours."""
    index = (np.arange(len(points))[:, None] + offsets) % len(points)
    near = points[index] - points[:, None]
    t = offsets / np.abs(offsets).max()
    basis = np.stack([np.ones_like(t), t, t**2], axis=1)
    trust = weights[index]
    coefficients, residual = local_fits(
        basis,
        near,
        trust,
        lambda residual: trust / np.maximum(residual, _FIT_SCALE),
        rounds=_FIT_ROUNDS,
        ridge=_FIT_RIDGE,
    )
    misfit = (trust * np.minimum(residual, _FIT_LIMIT) ** 2).sum(axis=1) / np.maximum(trust.sum(axis=1), 1e-9)
    length = np.linalg.norm(coefficients[:, 1], axis=1, keepdims=True)
    tangent = coefficients[:, 1] / np.maximum(length, 1e-12)
    return _Parabolas(points + coefficients[:, 0], tangent, misfit + _FIT_FLOOR)


def _crossing(first: Array, direction: Array, second: Array, other: Array) -> Array | None:
    """Where two lines cross, if they meet at an angle and the crossing lies between and near the two points."""
    turn = direction[0] * other[1] - direction[1] * other[0]
    gap = second - first
    if abs(turn) < _LEAST_TURN:
        return None
    along = (gap[0] * other[1] - gap[1] * other[0]) / turn
    back = (gap[0] * direction[1] - gap[1] * direction[0]) / turn
    near = _NEAR_CORNER * float(np.linalg.norm(gap))
    if not (-near <= along <= near and -near <= -back <= near):
        return None
    return np.asarray(first + along * direction)
