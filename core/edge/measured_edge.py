"""The paper's edge, measured in all photos: it shows where the sheet is even where nothing is printed.

A blank margin has no points, and a stiff surface only guesses how the paper goes on there. But its edge shows in every
photo: as far as it lies beside the place where the surface expects it, the surface is wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import Image
from ..numeric.polygon import resample, signed_area
from ..numeric.robust import GATE, MAD_TO_SIGMA, observation_weight
from ..numeric.threads import in_threads
from ..paper.snapped_contour import Snapped, snap
from ..surface.edge_points import EdgePoints
from ..surface.surface import Surface, fitted_to_edge
from ..surface.surface_settings import SurfaceSettings
from ..watch import SILENT, Watch
from .edge_stiffness import as_stiff_as_its_edge

# Pixels between two places along the edge.
_SPACING = 3.0
# How far from where it is expected the edge is looked for, first and again from the better surface, as parts of the
# paper's longer side in the reference photo. On a rendered letter with a curled blank margin the first surface is 12
# pixels of 2000 off.
_REACHES = (0.01, 0.004)
# Pixels between samples along the normal; the cost of a pixel between the shifts of neighbours, see `snap`.
_STEP, _STIFFNESS = 0.25, 0.02
# An edge is one from this step of linear light on, hundredths of white.
_LEAST_STEP = 1.0
# Rounds of weighting; before the fifth, observations are taken to scatter by this many pixels.
_ROUNDS, _FIRST_ROUNDS, _FIRST_DEVIATION = 20, 4, 2.0
_LEAST_DEVIATION = 0.05  # pixels
# A slope below this, pixels by 1 of inverse depth, is none: the photo sees the edge move along itself.
_LEAST_SLOPE = 1e-3
# Of the photos that show a place of the edge, besides the reference, at least this many and this part must agree.
_FEWEST, _AGREEING = 2, 0.5
# Places along the edge share their noise with their neighbours, so each counts with this many times its own deviation.
# The pages of 30 generated sheets are .0598 % of their height off without the edge, .0522 % with 1, .0506 % with 3
# (medians).
_SHARED = 3.0
# With fewer points the surface is left as it is. A choice, as all values here without a figure are.
_FEWEST_POINTS = 20
# Where the surface is too far off for the edge to be found, it is looked for again where it would run on straight in
# space from the places that were found: from so many of them, at least so many, and for so many places onwards. On a
# rendered book, whose paper sinks 14 mm into the gutter where the surface goes on straight, three more looks find 95 %
# of the edge instead of 70 %.
_LOOKS, _ONWARD_FROM, _FEWEST_FROM, _ONWARD = 4, 20, 8, 60
# No further look once this part of the edge is found, or the last look found no more than this part.
_FOUND, _FOUND_MORE = 0.98, 0.005
# The change of inverse depth over which pixels are differentiated, in the surface's unit.
_SMALL = 1e-4


def fit_to_edge(
    surface: Surface,
    points: Array,
    settings: SurfaceSettings,
    cameras: Sequence[Camera],
    reference: int,
    polygon: Array,
    photos: Sequence[Image],
    threads: int = 1,
    watch: Watch = SILENT,
) -> Surface:
    """Fit a developable surface to the paper's edge, as the photos show it, besides its points.

    Parameters
    ----------
    surface : Surface
        Fitted to the points, about right everywhere.
    points : (N, 3) array
    settings : SurfaceSettings
        As the surface was fitted with.
    cameras : sequence of Camera
    reference : int
        The camera over whose photo the surface lies.
    polygon : (K, 2) array
        The paper's outline there, distorted pixels.
    photos : sequence of (h, w, 3) uint8 or uint16 arrays
        One for each camera; each is read when it is looked at.
    threads : int
        How many photos are looked at at once.
    watch : Watch

    Returns
    -------
    Surface
        With its ``edge``; the same surface if the other photos do not show the edge.

    Raises
    ------
    Cancelled
    """
    longer_side = float(np.ptp(polygon, axis=0).max())
    in_reference = _snapped(photos[reference], resample(polygon, _SPACING), _REACHES[-1] * longer_side)
    others = [(camera, index) for index, camera in enumerate(cameras) if index != reference]

    def shown(part: Watch) -> Iterator[tuple[Camera, Image]]:
        for number, (camera, index) in enumerate(others):
            part.step(number / len(others), "Following the paper's edge in all photos")
            yield camera, photos[index]

    for number, reach in enumerate(_REACHES):
        part = watch.part(number / len(_REACHES), (number + 1) / len(_REACHES))
        edge = measure_edge(surface, in_reference, partial(shown, part), reach * longer_side, threads)
        if len(edge) < _FEWEST_POINTS:
            return surface
        surface = fitted_to_edge(surface, points, settings, edge)
    return as_stiff_as_its_edge(surface, points, settings)


def measure_edge(
    surface: Surface,
    in_reference: Snapped,
    others: Callable[[], Iterable[tuple[Camera, Image]]],
    reach: float,
    threads: int = 1,
) -> EdgePoints:
    """Points of the paper's edge, each on the reference photo's ray, at the depth on which the other photos agree.

    Parameters
    ----------
    surface : Surface
    in_reference : Snapped
    others : callable
        Yields (Camera, (h, w, 3) array) of each of the other photos, whenever they are looked at.
    reach : float
        How far from its expected place the edge is looked for, pixels.
    threads : int
    """
    frame = surface.grid.frame
    plane = frame.from_pixels(in_reference.points)
    on_surface = surface.grid.interpolate(surface.inverse_depth, plane)
    is_edge, expected = _is_edge(in_reference), on_surface
    edge = EdgePoints(plane[:0], on_surface[:0], on_surface[:0])
    for _ in range(_LOOKS):
        here, farther = (frame.to_world(plane, expected + change) for change in (0.0, _SMALL))
        change, deviation, good = _measured(here, farther, is_edge, others(), reach, threads)
        found, before = int(good.sum()), len(edge)
        if found <= before:
            break
        measured = expected + change
        edge = EdgePoints(plane[good], measured[good], _SHARED * deviation[good])
        if found > _FOUND * is_edge.sum() or found - before < _FOUND_MORE * is_edge.sum():
            break
        expected = on_surface + run_on(np.where(good, measured - on_surface, np.nan))
    return edge


def _measured(
    here: Array,
    farther: Array,
    is_edge: NDArray[np.bool_],
    others: Iterable[tuple[Camera, Image]],
    reach: float,
    threads: int,
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The changes of inverse depth (M,) on which the other photos agree, their deviation, and where they do agree.

    The edge is expected at ``here``, and at ``farther`` with `_SMALL` more of inverse depth.
    """

    def look(item: tuple[Camera, Image]) -> tuple[Array, Array]:
        camera, photo = item
        return _beside(camera, photo, camera.project(here), camera.project(farther), reach)

    slope, off = (np.stack(each, axis=1) for each in zip(*in_threads(look, others, threads), strict=True))
    off[~is_edge] = np.nan
    change, deviation, agreeing = _agreed(slope, off)
    return change, deviation, (agreeing >= _FEWEST) & (agreeing >= _AGREEING * np.isfinite(off).sum(axis=1))


def run_on(values: Array) -> Array:
    """Values (M,) along a closed contour, continued where they are NaN: straight on from both ends of each gap.

    Far from the ends they stay level; in between, each end counts by its nearness.
    """
    count, result = len(values), np.nan_to_num(values)
    known = np.flatnonzero(np.isfinite(values))
    if not len(known):
        return result
    for before, gap in zip(known, np.diff(np.append(known, known[0] + count)), strict=True):
        if gap > 1:
            step = np.arange(1, gap)
            start = _line(values[(before - np.arange(_ONWARD_FROM)) % count])
            end = _line(values[(before + gap + np.arange(_ONWARD_FROM)) % count])
            onward, back = (
                first + slope * np.minimum(at, _ONWARD) for (first, slope), at in ((start, step), (end, gap - step))
            )
            result[(before + step) % count] = (1 - step / gap) * onward + step / gap * back
    return result


def _line(values: Array) -> tuple[float, float]:
    """The line through values (N,) that come to an end with the first: its value there, and its slope beyond it."""
    at = np.flatnonzero(np.isfinite(values))
    if len(at) < _FEWEST_FROM:
        return float(np.median(values[at])), 0.0
    slope, first = np.polyfit(-at, values[at], 1)
    return float(first), float(slope)


def _beside(camera: Camera, photo: Image, here: Array, farther: Array, reach: float) -> tuple[Array, Array]:
    """How far across itself the edge (M, 2) moves in a photo by 1 of inverse depth, and how far it is off, pixels (M,).

    ``farther`` is where it would be with `_SMALL` more of inverse depth. What the photo does not show is NaN.
    """
    if not (np.isfinite(here).all() and np.isfinite(farther).all()) or signed_area(here) <= 0:
        return np.zeros(len(here)), np.full(len(here), np.nan)
    snapped = _snapped(photo, here, reach)
    slope, off = (((there - here) * snapped.normals).sum(axis=1) for there in (farther, snapped.points))
    return slope / _SMALL, np.where(_is_edge(snapped), off, np.nan)


def _snapped(photo: Image, points: Array, reach: float) -> Snapped:
    """The edge at most ``reach`` pixels beside a closed contour (M, 2), pixels."""
    return snap(photo, points, reach, _STEP, _STIFFNESS, in_linear_light=True)


def _is_edge(snapped: Snapped) -> NDArray[np.bool_]:
    """Where a snapped contour has an edge (M,): not where the photo's frame cuts the sheet off, nor within the page."""
    return ~snapped.at_frame & (snapped.strength >= _LEAST_STEP)


def _agreed(slope: Array, off: Array) -> tuple[Array, Array, Array]:
    """The changes (M,) that explain most of what is ``off`` (M, C), their deviation, and how many photos agree.

    NaN is not known. Least squares with Cauchy's weights.
    """
    known = np.isfinite(off)
    off, slope = np.where(known, off, 0.0), np.where(known, slope, 0.0)
    weight, deviation = known.astype(float), _FIRST_DEVIATION
    for round_ in range(_ROUNDS):
        change = (weight * slope * off).sum(axis=1) / np.maximum((weight * slope**2).sum(axis=1), _LEAST_SLOPE**2)
        rest = np.abs(off - slope * change[:, None])
        if round_ >= _FIRST_ROUNDS and known.any():
            deviation = max(MAD_TO_SIGMA * float(np.median(rest[known])), _LEAST_DEVIATION)
        weight = known * observation_weight(rest, deviation)
    kept = known & (rest < GATE * deviation)
    return change, deviation / np.sqrt(np.maximum((kept * slope**2).sum(axis=1), _LEAST_SLOPE**2)), kept.sum(axis=1)
