"""How exact the page is: at each place a bound, within which the error of nine tenths of the page stays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from ..arrays import Array
from ..flat.distortion import measure_strain
from ..numeric.triangles import areas
from ..sheet import FlatMap, Sheet
from .page_scatter import PageScatter

# The bound is this many times the scatter by errors and the strain together, with this weight of the strain, and grows
# with the gap, by as much again within this many page lengths. Fitted by `benchmarks/tabletops/fit_page_bound.py` to 24
# sheets, of each of which the others' weights let 89 % keep the bound (mean; 33 to 100 %).
SCATTERS, STRAIN_WEIGHT, DOUBLED_WITHIN = 5.45, 0.65, 1.28
# No expected error is more than this many times the largest bound: of a page with one bound, 99.99 % keep the double.
_MOST_BOUNDS = 2.0


def page_bound(scatter: PageScatter) -> Array:
    """The bound (V,) of each vertex that follows from what is known of a page, world units."""
    known = np.hypot(scatter.by_errors, STRAIN_WEIGHT * scatter.strain)
    return np.asarray(SCATTERS * known * (1 + scatter.gap / DOUBLED_WITHIN))


def bound_on_page(sheet: Sheet, flat: FlatMap) -> Array | None:
    """The bound (V,) in the page's unit; None if it is not known."""
    if sheet.bound is None:
        return None
    return sheet.bound * measure_strain(sheet.vertices, sheet.triangles, flat.uv).scale


def page_within(sheet: Sheet, flat: FlatMap, shares: Sequence[float]) -> list[float] | None:
    """Errors, in the page's unit, that these shares of the page's area are expected to keep; None if not known.

    Both coordinates of a place's error are taken for normal, with the deviation of which its bound is the 90th
    percentile.
    """
    bound = bound_on_page(sheet, flat)
    if bound is None:
        return None
    area = areas(np.column_stack([flat.uv, np.zeros(len(flat.uv))]), sheet.triangles)
    weight = area / area.sum()
    square = np.square(bound[sheet.triangles].mean(axis=1))

    # the length of a normal error exceeds its 90th percentile, the bound, once in ten times: hence the logarithm of ten
    def beyond(error: float, share: float) -> float:
        return float(weight @ np.exp(-np.log(10) * error**2 / square)) - (1 - share)

    return [brentq(beyond, 0, _MOST_BOUNDS * float(bound.max()), args=(share,)) for share in shares]
