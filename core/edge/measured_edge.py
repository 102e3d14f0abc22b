"""The paper's edge measured in all photos: where the sheet is where nothing is printed.

A blank margin has no points, and a stiff surface only guesses how the paper goes on there. But its edge shows in every
photo: as far as it lies beside the place where the surface expects it, the surface is wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import Image
from ..numeric.polygon import resample, signed_area
from ..numeric.threads import in_threads
from ..paper.contour import outward_normals, snap
from ..surface.edge_points import EdgePoints
from ..surface.surface import Surface, SurfaceSettings, fitted_to_edge
from ..watch import SILENT, Watch

# Pixels between two places along the edge.
_SPACING = 3.0
# How far from where it is expected the edge is looked for, first and again from the better surface, as parts of the
# paper's longer side in the reference photo. On a rendered letter with a curled blank margin the first surface is 12
# pixels of 2000 off.
_REACHES = (0.01, 0.004)
# Samples along the normal, pixels apart; the cost of a pixel between the shifts of neighbours, as in `contour.snap`.
_STEP, _STIFFNESS = 0.25, 0.02
# Neighbours over which the edge's normals are smoothed, as `contour.snap` smooths them.
_NORMALS = 4.0
# An edge is one from this step of linear light on, hundredths of white.
_LEAST_STEP = 1.0
# Rounds of weighting; until the third, observations are taken to scatter by so many pixels.
_ROUNDS, _FIRST_ROUNDS, _FIRST_DEVIATION = 20, 4, 2.0
# Where Cauchy's weight is a half, and from where on an observation is not counted, in standard deviations.
_HALF_WEIGHT, _GATE = 2.5, 4.0
_LEAST_DEVIATION = 0.05  # pixels
# Of the photos that show a place of the edge, besides the reference, at least so many and this part must agree.
_FEWEST, _AGREEING = 2, 0.5
# Places along the edge share their noise with their neighbours, so each counts with so many times its own deviation.
_SHARED = 3.0
# Without so many points the edge tells nothing.
_FEWEST_POINTS = 20
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
    for number, reach in enumerate(_REACHES):
        part = watch.part(number / len(_REACHES), (number + 1) / len(_REACHES))
        edge = measure_edge(surface, cameras, reference, polygon, photos, reach * longer_side, threads, part)
        if len(edge) < _FEWEST_POINTS:
            return surface
        surface = fitted_to_edge(surface, points, settings, edge)
    return surface


def measure_edge(
    surface: Surface,
    cameras: Sequence[Camera],
    reference: int,
    polygon: Array,
    photos: Sequence[Image],
    reach: float,
    threads: int = 1,
    watch: Watch = SILENT,
) -> EdgePoints:
    """Points of the paper's edge, each on the reference photo's ray, at the depth on which the other photos agree.

    ``reach`` is how far from its expected place the edge is looked for, pixels; all else is as for `fit_to_edge`.
    """
    expected = _Expected.of(surface, polygon)

    def look(item: tuple[Camera, Image]) -> tuple[Array, Array]:
        return expected.beside(*item, reach)

    others = [index for index in range(len(cameras)) if index != reference]
    slope, off = np.zeros((2, len(expected.plane), len(others)))
    shown = ((cameras[index], photos[index]) for index in others)
    for number, (slopes, offsets) in enumerate(in_threads(look, shown, threads)):
        slope[:, number], off[:, number] = slopes, offsets
        watch.step((number + 1) / len(others), "Following the paper's edge in all photos")
    change, deviation, agreeing = _agreed(slope, off)
    seen = np.isfinite(off).sum(axis=1)
    good = (agreeing >= _FEWEST) & (agreeing >= _AGREEING * seen)
    return EdgePoints(expected.plane[good], (expected.inverse_depth + change)[good], _SHARED * deviation[good])


@dataclass(frozen=True)
class _Expected:
    """Where the edge is expected: plane coordinates (M, 2), inverse depths (M,), world points (M, 3), and the points
    that are deeper by `_SMALL` of inverse depth.
    """

    plane: Array
    inverse_depth: Array
    points: Array
    deeper: Array

    @classmethod
    def of(cls, surface: Surface, polygon: Array) -> _Expected:
        frame = surface.grid.frame
        plane = frame.from_pixels(resample(polygon, _SPACING))
        inverse_depth = surface.grid.interpolate(surface.inverse_depth, plane)
        points, deeper = (frame.to_world(plane, inverse_depth + change) for change in (0.0, _SMALL))
        return cls(plane, inverse_depth, points, deeper)

    def beside(self, camera: Camera, photo: Image, reach: float) -> tuple[Array, Array]:
        """How far the edge moves across itself in a photo, pixels, by 1 of inverse depth, and how far it is off (M,).

        The latter is NaN where the photo does not show it.
        """
        here, there = camera.project(self.points), camera.project(self.deeper)
        nowhere = np.zeros(len(here)), np.full(len(here), np.nan)
        if not (np.isfinite(here).all() and np.isfinite(there).all()) or signed_area(here) <= 0:
            return nowhere
        snapped = snap(photo, here, reach, _STEP, _STIFFNESS, in_linear_light=True)
        normal = outward_normals(here, _NORMALS)
        slope = ((there - here) * normal).sum(axis=1) / _SMALL
        off = ((snapped.points - here) * normal).sum(axis=1)
        return slope, np.where(snapped.at_frame | (snapped.strength < _LEAST_STEP), np.nan, off)


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
            deviation = max(float(np.median(rest[known])) / _MEDIAN, _LEAST_DEVIATION)
        weight = known / (1 + (rest / (_HALF_WEIGHT * deviation)) ** 2)
    kept = known & (rest < _GATE * deviation)
    return change, deviation / np.sqrt(np.maximum((kept * slope**2).sum(axis=1), _LEAST_SLOPE**2)), kept.sum(axis=1)


# Median of the absolute values of a normal variable with deviation 1.
_MEDIAN = 0.6745
# A slope below this, pixels by 1 of inverse depth, is none: the photo sees the edge move along itself.
_LEAST_SLOPE = 1e-3
