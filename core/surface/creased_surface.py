"""The sheet's surface with its creases, given by the user or detected."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..creases.crease_ends import CREASE_REACH, CROSSING_REACH, extend_to_each_other, extend_to_outline
from ..watch import SILENT, Watch
from .left_out import Assessment, assess
from .ridges import find_ridges, straight_in_space
from .surface import Surface, reconstruct
from .surface_settings import SurfaceSettings

# Least confidence with which a detected crease is kept.
_SURE = 0.95


def reconstruct_with_creases(
    points: Array,
    reference: Camera,
    polygon: Array,
    settings: SurfaceSettings | None = None,
    *,
    given: Array | None = None,
    seed: int = 0,
    threads: int = 1,
    watch: Watch = SILENT,
) -> Surface:
    """Fit a surface to the points on the sheet, and find the straight lines along which the paper is folded.

    The developable surface is fitted twice: first limp, which rounds the creases and so shows where they are, then with
    hinges there, which lets it be sharp and keeps the paper on either side in one tangent plane along each crease. In
    between, left-out patches of points show which creases are real and how stiff the paper is between them. If a hinge
    is still not straight in space, it is two creases, and the surface is fitted once more. The other methods are the
    published ones, with the creases of their only surface.

    Parameters
    ----------
    points, reference, polygon, settings, watch
        As for `reconstruct`.
    given : (K, 2, 2) array, optional
        The ends of all creases, distorted pixels; without it, creases are detected.
    seed : int
        For `find_ridges`.
    threads : int
        How many surfaces are fitted at once.

    Returns
    -------
    Surface
        Its ``creases`` are all creases of the sheet.

    Raises
    ------
    Cancelled, StepFailed
    """
    settings = settings or SurfaceSettings()
    if settings.method != "developable":
        return _published(points, reference, polygon, settings, given, seed, watch)

    def assessed(creases: Array, part: Watch) -> Assessment:
        return assess(points, reference, polygon, settings, creases if len(creases) else None, threads, part)

    def fitted(creases: Array, assessment: Assessment, part: Watch) -> Surface:
        stiff = replace(settings, smoothness=assessment.stiffness * settings.smoothness)
        surface = reconstruct(points, reference, polygon, stiff, part, creases if len(creases) else None)
        confidence = tuple(assessment.confidence_of(ends) for ends in surface.creases)
        return replace(surface, stiffness=assessment.stiffness, confidence=confidence)

    if given is not None:
        return fitted(given, assessed(given, watch.part(0, 0.4)), watch.part(0.4, 1))
    smooth = reconstruct(points, reference, polygon, settings, watch.part(0, 0.3))
    lines = [ridge.ends for ridge in find_ridges(smooth, seed=seed)]
    lines = extend_to_each_other(lines, CROSSING_REACH * smooth.grid.step)
    while True:
        creases = _in_pixels(lines, smooth, reference)
        assessment = assessed(creases, watch.part(0.3, 0.5))
        sure = [ends for ends in lines if assessment.confidence_of(ends) >= _SURE]
        if len(sure) == len(lines):
            break
        lines = sure
    if not lines and assessment.stiffness == 1:
        return smooth
    surface = fitted(creases, assessment, watch.part(0.5, 0.75))
    pieces = [piece for ends in surface.creases for piece in straight_in_space(surface, ends)]
    if len(pieces) == len(surface.creases) and all(map(operator.is_, pieces, surface.creases)):
        return surface
    return fitted(_in_pixels(pieces, surface, reference), assessment, watch.part(0.75, 1))


def _published(
    points: Array,
    reference: Camera,
    polygon: Array,
    settings: SurfaceSettings,
    given: Array | None,
    seed: int,
    watch: Watch,
) -> Surface:
    """The surface of the other methods, with its detected creases."""
    surface = reconstruct(points, reference, polygon, settings, watch, given)
    if given is not None:
        return surface
    edge, reach = surface.grid.frame.from_pixels(polygon), CREASE_REACH * surface.grid.step
    lines = [ridge.ends for ridge in find_ridges(surface, seed=seed)]
    pieces = [piece for ends in lines for piece in straight_in_space(surface, ends)]
    return replace(surface, creases=tuple(extend_to_outline(piece, edge, reach) for piece in pieces))


def _in_pixels(lines: Sequence[Array], surface: Surface, reference: Camera) -> Array:
    """Lines over the surface, plane coordinates, as (K, 2, 2) distorted pixels."""
    return np.array([reference.project(surface.at(ends)) for ends in lines]).reshape(-1, 2, 2)
