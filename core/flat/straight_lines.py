"""Creases and sides that become straight lines on the page: the rows of Eq. 16."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..arrays import Array, Indices

# Values without a figure are choices; no measurement of them is recorded.
# Of the rows: the paper's gamma, for a page of unit area with triangles of unit weight on average.
_COLLINEARITY_WEIGHT = 1e2
# A side or ridge that waves by more than this share of the page without rows is notched, torn or not a line at all.
_MOST_WAVE = 0.03


def collinearity_rows(flat: Array, lines: list[Indices]) -> sparse.csr_array:
    """Weighted rows (K, 2V) of Eq. 16 for unknowns (u, v): each vertex of a line against the line through its ends.

    As printed, the rows also fix each vertex's place along the line. On a ragged edge that place is more wrong than in
    the map without rows. So here only the offset across the line counts, with the line's direction from the map without
    rows. Lines that wave too much in that map get no rows.
    """
    count = len(flat)
    entries: list[tuple[int, int, float]] = []
    row = 0
    for line in lines:
        if _wave(flat[line]) >= _MOST_WAVE:
            continue
        first, last = int(line[0]), int(line[-1])
        span = flat[last] - flat[first]
        normal = np.array([-span[1], span[0]]) / np.linalg.norm(span)
        for vertex in line[1:-1]:
            t = float((flat[vertex] - flat[first]) @ span / (span @ span))
            for node, share in ((int(vertex), 1.0), (first, t - 1.0), (last, -t)):
                entries += [(row, node, share * normal[0]), (row, node + count, share * normal[1])]
            row += 1
    rows, columns, values = zip(*entries, strict=True) if entries else ((), (), ())
    return _COLLINEARITY_WEIGHT * sparse.csr_array((values, (rows, columns)), shape=(row, 2 * count), dtype=float)


def _wave(line: Array) -> float:
    """Largest distance of a run of points (K, 2) from the line through its ends."""
    span = line[-1] - line[0]
    length = np.linalg.norm(span)
    if length == 0:  # a ring
        return np.inf
    return float(np.abs((line - line[0]) @ np.array([-span[1], span[0]])).max() / length)
