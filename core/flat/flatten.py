"""From the sheet to the plane: the settings, and the method that they choose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..arrays import Array, Indices
from ..errors import StepFailed
from ..numeric.triangles import areas
from ..setting import Choice, setting
from ..sheet import Sheet
from ..watch import SILENT, Watch
from .conformal_map import conformal_map
from .convex_map import convex_map
from .geodesic import keep_geodesic_lengths
from .least_stretch import has_flips, least_stretch
from .pins import Pins
from .rigid_map import as_rigid_as_possible
from .sides import sides
from .straight_lines import collinearity_rows

FlattenMethod = Literal["arap", "conformal_l1", "lscm", "geodesic", "least_stretch"]


@dataclass(frozen=True)
class FlattenSettings:
    """How the sheet is flattened.

    ``conformal_l1`` is the paper's (Eq. 19), ``lscm`` its l2 version (Brown et al.), ``geodesic`` is after Zhang et al.
    and ``least_stretch`` after Rabinovich et al. The rows are those of Eq. 16: they help on a correct surface and hurt
    on a wrong one.
    """

    method: FlattenMethod = setting(
        "arap",
        "what the flat map preserves of the surface",
        label="Method",
        option="--unwrap",
        choices={
            "arap": Choice(
                "As Rigid as Possible", "the shape and size of every triangle, as far as possible; best for paper"
            ),
            "conformal_l1": Choice("Conformal, l1", "angles, except in a few triangles; the published method"),
            "lscm": Choice("Conformal, Least Squares", "angles everywhere, as far as possible"),
            "geodesic": Choice("Geodesic", "distances along the surface"),
            "least_stretch": Choice(
                "Least Stretch", "lengths, nowhere much worse than elsewhere, and never folds over; best for cloth"
            ),
        },
    )
    ridge_rows: bool = setting(
        False,
        "make creases, including painted ones, straight lines on the page",
        label="Straighten Creases",
        option="--ridge-rows",
    )
    boundary_rows: bool = setting(
        False,
        "make the sheet's sides straight; helps where they wave, hurts where the edge was not found well",
        label="Straighten Sides",
        option="--boundary-rows",
    )


def flatten(
    sheet: Sheet,
    settings: FlattenSettings | None = None,
    watch: Watch = SILENT,
    *,
    pins: Pins | None = None,
    robust_start: bool = True,
) -> Array:
    """Flat coordinates of every vertex.

    Parameters
    ----------
    sheet : Sheet
    settings : FlattenSettings, optional
    watch : Watch
    pins : Pins, optional
        In the frame of the result. One pin moves the whole map. Two or more turn it, and bend it if they are not as far
        apart as on the sheet; the conformal methods then take the pins' scale, the others keep the sheet's.
    robust_start : bool
        Whether ``arap`` starts from the l1 conformal map or from the l2 one, with which it takes an eighth of the
        time. On sheets of paper the results agree to 1e-4 of the page.

    Returns
    -------
    uv : (V, 2) array
        In the sheet's own unit, v down, not mirrored as seen from the printed side. Without pins its rotation and
        position are arbitrary; `page.lay_out` fixes them.

    Raises
    ------
    StepFailed
        If the sheet closes on itself so far that it has no map, or the pins allow none.
    """
    settings = settings or FlattenSettings()
    size = np.sqrt(areas(sheet.vertices, sheet.triangles).sum())
    unit = replace(sheet, vertices=sheet.vertices / size)
    lines = [ridge for ridge in sheet.ridges if len(ridge) >= 3] if settings.ridge_rows else []
    if settings.boundary_rows:
        lines += sides(unit)
    robust = settings.method == "conformal_l1" or (settings.method == "arap" and robust_start)
    held = None if pins is None or len(pins.vertices) < 2 else Pins(pins.vertices, pins.uv / [size, -size])
    if settings.method == "least_stretch":
        flat = _least_stretch(unit, lines, watch, held)
    else:
        flat = conformal_map(unit, lines, robust=robust, pins=held, watch=watch.part(0, 0.5))
    if settings.method == "arap":
        flat = as_rigid_as_possible(unit, flat, lines, watch.part(0.5, 1), pins=held)
    elif settings.method == "geodesic":
        flat = keep_geodesic_lengths(unit, flat, watch.part(0.5, 1), pins=held)
    uv = flat * [size, -size]
    if pins is not None and len(pins.vertices) > 0:
        if len(pins.vertices) == 1:
            uv += pins.uv - uv[pins.vertices]
        uv[pins.vertices] = pins.uv  # avoids rounding by the unit
    return uv


def _least_stretch(unit: Sheet, lines: list[Indices], watch: Watch, held: Pins | None) -> Array:
    """The map of least stretch, from the first of three that has no flips; if pins fold all over, as rigid as possible.

    Raises
    ------
    StepFailed
        If the pins allow no map.
    """
    flat = None
    try:
        angles = conformal_map(unit, lines, robust=False, pins=held, watch=watch.part(0, 0.1))
        flat = as_rigid_as_possible(unit, angles, lines, watch.part(0.1, 0.3), pins=held)
        if has_flips(flat, unit.triangles) and not has_flips(angles, unit.triangles):
            flat = angles
    except StepFailed:
        if held is not None:
            raise
    if flat is None or has_flips(flat, unit.triangles):
        if held is not None:
            assert flat is not None
            return flat
        flat = convex_map(unit) / np.sqrt(np.pi)  # of unit area, like the sheet
    straight = collinearity_rows(flat, lines)
    return least_stretch(unit, flat, straight, watch.part(0.3, 1), pins=held)
