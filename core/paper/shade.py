"""Where paper goes on in less light beyond an outline: the half of a folded sheet that is turned from the lamp."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array

# Values without a figure are choices; no measurement of them is recorded.
# Paper in shade has down to this part of the lightness beside it; its tint changes by less than this part of the
# difference from the table's tint, which is at least the third value (Oklab times 100, with `image.COLOR_WEIGHTS`);
# below the last lightness a tint is noise. Outlines of generated scenes that end at a shaded half have lightness .83 to
# .95 beyond it, tints changed by 0.1 to 1.5, and 10 to 23 from the table's. So has the page of a book before a shaded
# facing page.
_DEEPEST, _SAME, _OTHER_TINT, _DARKEST = 0.6, 0.4, 5.0, 10.0
# Most of a stretch of this part of the outline decides. A shaded side is at least as long as the second: white squares
# of a cloth beside white paper take .04 of the outline, a shaded half .22 and more.
_STRETCH, _SHORTEST_SIDE = 0.01, 0.1


def paper_in_shade(inside: Array, outside: Array) -> NDArray[np.bool_]:
    """Where the outside of an outline is its inside in less light, along whole sides, and is not the table.

    Less light scales all coordinates of an Oklab colour by one factor, so that their ratios, the tint, stay. Where
    the table has the tint of the paper, nothing is known.

    Parameters
    ----------
    inside, outside : (M, 3) arrays
        Oklab colours times 100, with `image.COLOR_WEIGHTS`, beside the places of a closed outline.
    """
    paper = float(np.median(inside[:, 0]))
    tint_inside, tint_outside = (
        paper * colors[:, 1:] / np.maximum(colors[:, :1], _DARKEST) for colors in (inside, outside)
    )
    apart = np.linalg.norm(np.median(tint_outside, axis=0) - tint_inside, axis=1)
    changed = np.linalg.norm(tint_outside - tint_inside, axis=1)
    light = outside[:, 0] / np.maximum(inside[:, 0], _DARKEST)
    return _along_sides((light > _DEEPEST) & (light < 1) & (apart > _OTHER_TINT) & (changed < _SAME * apart))


def _along_sides(places: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The places (M,) of a closed outline in runs as long as a side, short gaps closed and short runs left out."""
    stretch = max(round(_STRETCH * len(places)), 1)
    mostly = ndimage.percentile_filter(places.astype(np.uint8), 50, size=2 * stretch + 1, mode="wrap")
    side = 2 * max(round(_SHORTEST_SIDE * len(places) / 2), 1) + 1
    shrunk = ndimage.minimum_filter1d(mostly, side, mode="wrap")
    return np.asarray(ndimage.maximum_filter1d(shrunk, side, mode="wrap") > 0)
