"""Where paper goes on beyond an outline: unchanged, in shade as behind a fold, or under print such as a barcode."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array

# Values without a figure are choices; no measurement of them is recorded. Colours are Oklab times 100, with
# `image.COLOR_WEIGHTS`.
# Paper in shade has down to this part of the lightness beside it; its tint changes by less than this part of the
# difference from the table's tint, which is at least the third value; below the last lightness a tint is noise.
# Outlines of generated scenes that end at a shaded half have lightness .83 to .95 beyond it, tints changed by 0.1 to
# 1.5, and 10 to 23 from the table's. So has the page of a book before a shaded facing page.
_DEEPEST, _SAME, _OTHER_TINT, _DARKEST = 0.6, 0.4, 5.0, 10.0
# Colours that differ by less are alike, and tables that differ by more along most of the outline are unlike the paper.
_ALIKE, _UNLIKE = 4.0, 8.0
# Most of a stretch decides, up to this part of the outline to either side of a place. Of 49 correct outlines of
# generated scenes 46 have no stretch beyond which all looks like paper; of outlines of books that end at print, .2 to
# .4. Beyond more than the second share of the outline, the table looks like paper.
_STRETCH, _MOST = 0.01, 0.5
# The ground between print is the lightest fifth of a stretch.
_GROUND = 0.8
_LOOKED_AT = 11  # places of a stretch, at most
# Only runs as long as a side count: white squares of a cloth beside white paper take .04 of the outline, a shaded half
# .22 and more, the end of a receipt beyond its barcode .13 and more.
_SHORTEST_SIDE = 0.1


def unchanged(inside: Array, outside: Array, paper: Array) -> NDArray[np.bool_]:
    """Where the outside of an outline looks like the inside, or like most of the sheet.

    An outline that follows a line of print is strong, but is not the edge of the paper. If paper seems to go on along
    most of the outline, the table looks like paper, and nothing is known.

    Parameters
    ----------
    inside, outside : (M, 3) arrays
        Colours beside the places of a closed outline.
    paper : (3,) array
        The colour of most of the sheet.

    Returns
    -------
    (M,) bool array
    """
    differ = np.minimum(np.linalg.norm(outside - inside, axis=1), np.linalg.norm(outside - paper, axis=1))
    alike = _in_stretches(differ < _ALIKE)
    return alike if alike.mean() < _MOST else np.zeros_like(alike)


def in_shade(inside: Array, outside: Array) -> NDArray[np.bool_]:
    """Where the outside of an outline is its inside in less light, along whole sides, and is not the table.

    Less light scales all coordinates of an Oklab colour by one factor, so that their ratios, the tint, stay. Where
    the table has the tint of the paper, nothing is known.

    Parameters and result as for `unchanged`.
    """
    paper = float(np.median(inside[:, 0]))
    tint_inside, tint_outside = (
        paper * colors[:, 1:] / np.maximum(colors[:, :1], _DARKEST) for colors in (inside, outside)
    )
    apart = np.linalg.norm(np.median(tint_outside, axis=0) - tint_inside, axis=1)
    changed = np.linalg.norm(tint_outside - tint_inside, axis=1)
    light = outside[:, 0] / np.maximum(inside[:, 0], _DARKEST)
    return _along_sides((light > _DEEPEST) & (light < 1) & (apart > _OTHER_TINT) & (changed < _SAME * apart))


def under_print(inside: Array, outside: Array) -> NDArray[np.bool_]:
    """Where an outline has the same light ground on both sides along whole sides, with or without print on it.

    Where the table is hardly unlike the paper elsewhere, nothing is known.

    Parameters
    ----------
    inside, outside : (M, K, 3) arrays
        Colours of strips beside the places of a closed outline.

    Returns
    -------
    (M,) bool array
    """
    differ = np.linalg.norm(_ground(outside) - _ground(inside), axis=1)
    return _along_sides((differ < _ALIKE) & (np.median(differ) > _UNLIKE))


def _ground(strips: Array) -> Array:
    """The colour (M, 3) of the lightest fifth of the strips (M, K, 3) near each place."""
    away = np.unique((np.linspace(-1, 1, _LOOKED_AT) * _STRETCH * len(strips)).astype(int))
    near = np.concatenate([np.roll(strips, places, axis=0) for places in away], axis=1)
    at = int(_GROUND * near.shape[1])
    chosen = np.argpartition(near[..., 0], at, axis=1)[:, at]
    return np.asarray(near[np.arange(len(near)), chosen])


def _along_sides(places: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The places (M,) of a closed outline in runs as long as a side, short gaps closed and short runs left out."""
    side = 2 * max(round(_SHORTEST_SIDE * len(places) / 2), 1) + 1
    shrunk = ndimage.minimum_filter1d(_in_stretches(places).astype(np.uint8), side, mode="wrap")
    return np.asarray(ndimage.maximum_filter1d(shrunk, side, mode="wrap") > 0)


def _in_stretches(places: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The places (M,) of a closed outline around which most are so."""
    size = 2 * max(round(_STRETCH * len(places)), 1) + 1
    return np.asarray(ndimage.percentile_filter(places.astype(np.uint8), 50, size=size, mode="wrap") > 0)
