"""The two nouns between the points and the page: the sheet in space and its flat map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import Array, Indices


@dataclass(frozen=True)
class Sheet:
    """The sheet as a triangle mesh that ends at the paper's edge and has edges along its creases.

    Attributes
    ----------
    vertices : (V, 3) array
        World frame of the sparse model.
    triangles : (F, 3) int array
        Counter-clockwise as seen from the printed side.
    ridges : tuple of (K,) int arrays
        The vertices along each straight crease, in order.
    boundary : (B,) int array
        The vertices of the paper's edge, a closed loop in order (the first is not repeated).
    bound : (V,) array or None
        How far each vertex is, nine times in ten, at most from its place on the page, world units; None if that is not
        known.
    """

    vertices: Array
    triangles: Indices
    ridges: tuple[Indices, ...]
    boundary: Indices
    bound: Array | None = None


def sheet_arrays(sheet: Sheet) -> dict[str, NDArray[Any]]:
    """A sheet as plain arrays to keep in a file.

    Returns
    -------
    dict
        ``vertices``, ``triangles`` and ``boundary`` as in `Sheet`; ``ridges``, all creases concatenated, and
        ``ridge_lengths``, their numbers of vertices. ``bound`` is missing if it is not known.
    """
    arrays: dict[str, NDArray[Any]] = {
        "vertices": sheet.vertices,
        "triangles": sheet.triangles,
        "ridges": np.concatenate([np.zeros(0, np.int64), *sheet.ridges]),
        "ridge_lengths": np.array([len(ridge) for ridge in sheet.ridges], np.int64),
        "boundary": sheet.boundary,
    }
    return arrays if sheet.bound is None else arrays | {"bound": sheet.bound}


def sheet_from_arrays(arrays: Mapping[str, NDArray[Any]]) -> Sheet:
    """The sheet from the arrays of `sheet_arrays`.

    Raises
    ------
    KeyError
        If an array other than ``bound`` is missing.
    """
    ends = np.cumsum(arrays["ridge_lengths"])
    ridges = np.split(arrays["ridges"], ends)[:-1]  # nothing follows the last crease
    return Sheet(arrays["vertices"], arrays["triangles"], tuple(ridges), arrays["boundary"], arrays.get("bound"))


@dataclass(frozen=True)
class FlatMap:
    """The place of each vertex of a sheet on the flat page.

    Attributes
    ----------
    uv : (V, 2) array
        u to the right, v down, both in ``unit``; the page is ``0 <= u <= width``, ``0 <= v <= height``.
    width, height : float
        Size of the page, in ``unit``.
    unit : str
        ``"mm"`` if the paper's size is known, otherwise ``"page heights"`` (then ``height`` is 1).
    world_scale : float or None
        Millimetres in one unit of the world frame; None if the paper's size is unknown.
    """

    uv: Array
    width: float
    height: float
    unit: str
    world_scale: float | None
