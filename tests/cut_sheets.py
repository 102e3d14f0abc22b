"""Sheets with a part cut away."""

from __future__ import annotations

import numpy as np
from origami.core.numeric.triangles import directed_edges
from origami.core.sheet import Sheet


def outer_part(sheet: Sheet, keep: np.ndarray) -> Sheet:
    """The sheet of the triangles where ``keep`` (F,) is true, its vertices renumbered in their old order."""
    used = np.unique(sheet.triangles[keep])
    number = np.full(len(sheet.vertices), -1)
    number[used] = np.arange(len(used))
    triangles = number[sheet.triangles[keep]]
    edges = directed_edges(triangles)
    count = len(used)
    lone = ~np.isin(edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0])
    following = dict(edges[lone].tolist())
    loop = [next(iter(following))]
    while following[loop[-1]] != loop[0]:
        loop.append(following[loop[-1]])
    return Sheet(sheet.vertices[used], triangles, (), np.array(loop))
