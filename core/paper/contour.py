"""Closed contours: around a mask, without detours, and their normals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..numeric.polygon import signed_area

# Values without a figure are choices; no measurement of them is recorded.
# A detour is cut out if it is no longer than this part of the outline, and if the sides before and after it, taken over
# this part of the outline and at least this many points, agree in direction with the short cut (cosine).
_LONGEST_DETOUR = 0.08
_LENGTH_STEP = 2  # points, between the lengths of detours that are tried
_SIDE, _LEAST_SIDE = 0.012, 6
_STRAIGHT = 0.98
# It must be this many times longer than the short cut: more is required where paper might be lost than where some is
# won.
_LEAST_GAIN_INWARDS, _LEAST_GAIN_OUTWARDS = 1.1, 1.3
# All but this part of the short cut must lie on an edge of this share of the outline's median edge, colour difference
# per pixel, which counts up to this value: an outline with strong edges must not exclude a faint side. An edge counts
# in a square of this side around it, because a short cut is straight and the paper's side is hardly ever.
_WITHOUT_EDGE, _LEAST_EDGE, _USUAL_EDGE, _BESIDE_EDGE = 0.2, 0.3, 3.0, 3


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
        has_edge = (edge > _LEAST_EDGE * min(typical, _USUAL_EDGE)).mean(axis=1) >= 1 - _WITHOUT_EDGE
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
