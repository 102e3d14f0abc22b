"""The sheet's surface with its creases: those that a person gave, or those that it shows by itself."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .camera import Array, Camera
from .crease_ends import CREASE_REACH, extend_to_outline
from .ridges import find_ridges, straight_in_space
from .surface import Surface, SurfaceSettings, reconstruct
from .watch import SILENT, Watch


def reconstruct_with_creases(
    points: Array,
    reference: Camera,
    polygon: Array,
    settings: SurfaceSettings | None = None,
    *,
    given: Array | None = None,
    seed: int = 0,
    watch: Watch = SILENT,
) -> Surface:
    """Fit a surface to the points on the sheet, and tell along which straight lines the paper is folded.

    The developable surface is fitted twice: a first time smooth, which rounds the creases and so shows where they are,
    then with hinges there, which lets it be sharp and holds the paper on either side to one tangent plane along each
    crease. Where a hinge is not straight in space even so, it is two creases, and the surface is fitted once more. The
    other methods are the published ones, whose creases are those of their only surface.

    Parameters
    ----------
    points, reference, polygon, settings, watch
        As for `reconstruct`.
    given : (K, 2, 2) array, optional
        The ends of all creases, distorted pixels, where they are not to be looked for.
    seed : int
        For `find_ridges`.

    Returns
    -------
    Surface
        Its ``creases`` are all that the sheet has.

    Raises
    ------
    Cancelled, StepFailed
    """
    settings = settings or SurfaceSettings()
    if given is not None:
        return reconstruct(points, reference, polygon, settings, watch, given)
    smooth = reconstruct(points, reference, polygon, settings, watch.part(0, 0.4))
    lines = [ridge.ends for ridge in find_ridges(smooth, seed=seed)]
    if settings.method != "developable" or not lines:
        edge, reach = smooth.grid.frame.from_pixels(polygon), CREASE_REACH * smooth.grid.step
        pieces = [piece for ends in lines for piece in straight_in_space(smooth, ends)]
        return replace(smooth, creases=tuple(extend_to_outline(piece, edge, reach) for piece in pieces))
    hinged = reconstruct(
        points, reference, polygon, settings, watch.part(0.4, 0.7), _in_pixels(lines, smooth, reference)
    )
    pieces = [piece for ends in hinged.creases for piece in straight_in_space(hinged, ends)]
    if len(pieces) == len(hinged.creases) and all(map(operator.is_, pieces, hinged.creases)):
        return hinged
    return reconstruct(points, reference, polygon, settings, watch.part(0.7, 1), _in_pixels(pieces, hinged, reference))


def _in_pixels(lines: Sequence[Array], surface: Surface, reference: Camera) -> Array:
    """Lines over the surface, plane coordinates, as (K, 2, 2) distorted pixels."""
    return np.array([reference.project(surface.at(ends)) for ends in lines]).reshape(-1, 2, 2)
