"""Recognise an open book that was taken for one sheet: two pages that arch down into a gutter between them."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..sheet import Sheet

# Values without a figure are choices; no measurement of them is recorded.
# The page is cut into this many strips along each of its sides; in each the mean slope is taken.
_STRIPS = 24
# Where the gutter may be, as a part of the page's side: facing pages are equally wide.
_MIDDLE = (0.45, 0.55)
# The pages are steepest within this many strips beside the gutter.
_BESIDE = 3
# An open book's pages meet at this angle or more in their gutter, and each is this much less steep in its outer half,
# degrees. Of a generated book, whose pages met at 19 degrees, both lost 17; of 49 runs on flat, folded, curled and
# crossed sheets none has 8 on both sides of such an angle.
_LEAST_ANGLE, _LEAST_ARCH = 12.0, 8.0
# Half-way between gutter and outer edge, this part of it is gained: a zigzag of four panels bends there all at once.
_GRADUAL = 0.5
# From one strip to the next it gains at most this part: the generated book .5, across a fold all of it and more.
_AT_ONCE = 0.6


def is_open_book(sheet: Sheet, uv: Array) -> bool:
    """Whether a sheet bends as two facing pages do.

    Parameters
    ----------
    sheet : Sheet
    uv : (V, 2) array
        Its vertices on the page, u to the right and v down.
    """
    return any(_has_gutter(slopes) for slopes in (_slopes(sheet, uv, 0), _slopes(sheet, uv, 1)))


def _slopes(sheet: Sheet, uv: Array, axis: int) -> Array:
    """The slope of each strip across an axis of the page (`_STRIPS`,), degrees, rising towards the camera's side."""
    corners = sheet.vertices[sheet.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    mean = normal.sum(axis=0) / np.linalg.norm(normal.sum(axis=0))
    along = np.linalg.lstsq(uv - uv.mean(axis=0), sheet.vertices - sheet.vertices.mean(axis=0), rcond=None)[0][axis]
    along -= mean * (along @ mean)
    along /= np.linalg.norm(along)
    slope = np.degrees(np.arctan2(-normal @ along, normal @ mean))
    low, high = uv[:, axis].min(), uv[:, axis].max()
    place = (uv[sheet.triangles, axis].mean(axis=1) - low) / (high - low)
    strip = np.minimum((place * _STRIPS).astype(int), _STRIPS - 1)
    weight = np.bincount(strip, area, _STRIPS)
    return np.bincount(strip, slope * area, _STRIPS) / np.maximum(weight, 1e-12 * area.sum())


def _has_gutter(slopes: Array) -> bool:
    """Whether the strips fall ever more steeply towards a line in the middle, and rise beyond it ever less."""
    first, last = (round(_STRIPS * part) for part in _MIDDLE)
    for line in range(first, last + 1):
        before, after = slopes[:line][::-1], -slopes[line:]  # from the gutter outwards
        steepest = [page[:_BESIDE].min() for page in (before, after)]
        if _is_arched(before) and _is_arched(after) and -sum(steepest) > _LEAST_ANGLE:
            return True
    return False


def _is_arched(page: Array) -> bool:
    """Whether the slopes of a page's strips, from the gutter outwards, rise gradually."""
    steepest, quarter = page[:_BESIDE].min(), len(page) // 4
    arch = page[2 * quarter :].mean() - steepest
    gradual = page[quarter : 2 * quarter].mean() - steepest > _GRADUAL * arch
    return bool(arch > _LEAST_ARCH and gradual and np.abs(np.diff(page)).max() < _AT_ONCE * arch)
