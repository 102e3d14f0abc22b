"""Ridges painted on a mesh: bands of vertices, thinned to runs along their middles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from ..arrays import Array, Indices

Flags = NDArray[np.bool_]

# Values without a figure are choices; no measurement of them is recorded.
# The half width of a band is the distance from the paint's edge below which this share of its vertices are.
_INSIDE = 0.9
# Half width, in edges, of paint most of whose vertices have two neighbours: a line one vertex wide.
_THIN = 0.6
# A band is at least this many times as long as wide (root mean squares about its middle).
_LEAST_LENGTH = 2.5
# The remaining paint is another band if it is this many edges, and half widths, long.
_LEAST_EDGES, _LEAST_HALF_WIDTHS = 4.0, 3.0
# Paint within this many half widths of a band's middle belongs to it.
_REACH = 1.5
# A line has left its band where the paint around it is to one side by more than these shares of an edge and of the half
# width.
_ASTRAY = 0.3, 0.4
# Rounds in which a line is moved to the middle of its paint. A choice.
_CENTRED_ROUNDS = 5
# Paint is reported if more than this share of it belongs to no band.
_MOST_LEFT = 0.25
# Largest gap, in edges plus one half width, in a band where it crosses another.
_GAP = 3.0
# Lines are tried through all pairs of the first number of vertices, about the second number vote, and the best lines
# are examined closely.
_SEEDS, _VOTERS, _CLOSER_LOOKS = 48, 2000, 24
# Squared sine of the angle, about 9 degrees, above which two lines have a definite crossing.
_LEAST_SLANT = 0.025
# How strongly a path along the middle avoids vertices beside it.
_STRAYING = 4.0


@dataclass(frozen=True)
class PaintedRidges:
    """The result of `painted_ridges`.

    Attributes
    ----------
    runs : tuple of (K,) int arrays
        Vertices along the middle of each band, in order, joined by edges.
    spots : tuple of (N,) int arrays
        The vertices of painted spots that show no direction.
    """

    runs: tuple[Indices, ...]
    spots: tuple[Indices, ...]

    @property
    def warning(self) -> str | None:
        """A warning about the result for the user, with what to do."""
        if not self.spots:
            return None
        what = "1 painted spot shows" if len(self.spots) == 1 else f"{len(self.spots)} painted spots show"
        return (
            f"{what} no direction and makes no ridge: paint along the whole crease, with a narrower brush, or erase it."
        )


def painted_ridges(positions: Array, edges: Indices, weight: Array) -> PaintedRidges:
    """Thin painted bands to straight runs of vertices; bands one vertex wide stay as they are.

    Parameters
    ----------
    positions : (V, 2) or (V, 3) array
        On a flat map of the surface, if there is one, or in space, where straight creases are straight too.
    edges : (E, 2) int array
        All edges of the mesh, pairs of vertices.
    weight : (V,) array
        Painted where positive; a band's middle is where the weight is concentrated.
    """
    painted = weight > 0
    within = edges[painted[edges].all(1)]
    beside = np.unique(edges[painted[edges].any(1)])
    beside = beside[~painted[beside]]
    vertex = np.flatnonzero(painted)
    if len(vertex) == 0:
        return PaintedRidges((), ())
    number = np.cumsum(painted) - 1
    length = np.linalg.norm(positions[within[:, 0]] - positions[within[:, 1]], axis=1)
    one_way = sparse.coo_array((length, tuple(number[within].T)), shape=(len(vertex), len(vertex)))
    graph = (one_way + one_way.T).tocsr()
    width = np.full(len(vertex), float(np.linalg.norm(np.ptp(positions, axis=0))))
    if len(beside):
        width = cKDTree(positions[beside]).query(positions[vertex])[0]
    runs: list[Indices] = []
    spots: list[Indices] = []
    part = connected_components(graph, directed=False)[1]
    for index in range(int(part.max()) + 1):
        own = np.flatnonzero(part == index)
        paint = _paint(positions[vertex[own]], graph[own][:, own], weight[vertex[own]], width[own])
        found, left = _bands(paint)
        runs += [vertex[own[run]] for run in found]
        if left.mean() > _MOST_LEFT:
            spots.append(vertex[own[left]])
    return PaintedRidges(tuple(runs), tuple(spots))


@dataclass(frozen=True)
class _Paint:
    """Connected paint: points (N, D), lengths of the edges between them, and the typical sizes."""

    points: Array
    graph: sparse.csr_array
    weight: Array
    edge: float
    half_width: float


@dataclass(frozen=True)
class _Line:
    """A line through the paint, and the longest gapless piece of paint along it."""

    origin: Array
    direction: Array
    members: Flags

    def apart(self, points: Array) -> Array:
        """Distance from the line."""
        offset = points - self.origin
        return np.linalg.norm(offset - (offset @ self.direction)[..., None] * self.direction, axis=-1)

    def along(self, points: Array) -> Array:
        return (points - self.origin) @ self.direction


def _paint(points: Array, graph: sparse.csr_array, weight: Array, width: Array) -> _Paint:
    edge = float(np.median(graph.data)) if graph.nnz else 0.0
    one_wide = np.median(np.diff(graph.indptr)) <= 2
    half_width = _THIN * edge if one_wide else max(float(np.quantile(width, _INSIDE)), edge)
    return _Paint(points, graph, weight, edge, half_width)


def _bands(paint: _Paint) -> tuple[list[Indices], Flags]:
    """Runs along the middles of all bands, the fullest first, and the paint that belongs to none."""
    left = np.ones(len(paint.points), bool)
    lines: list[_Line] = []
    spans: list[tuple[float, float]] = []
    while paint.edge > 0 and left.sum() >= 3 and (line := _best_line(paint, left)) is not None:
        along = line.along(paint.points)
        fresh = np.ptp(along[line.members & left])
        if lines and fresh < max(_LEAST_EDGES * paint.edge, _LEAST_HALF_WIDTHS * paint.half_width):
            break
        low, high = float(along[line.members].min()), float(along[line.members].max())
        near = (along > low - paint.half_width) & (along < high + paint.half_width)
        left &= ~(near & (line.apart(paint.points) < _REACH * paint.half_width + paint.edge / 2))
        lines.append(line)
        spans.append((low, high))
    ends = _ends_at_junctions(paint, lines, np.array(spans).reshape(-1, 2))
    return [_middle(paint, line, low, high) for line, (low, high) in zip(lines, ends, strict=True)], left


def _ends_at_junctions(paint: _Paint, lines: list[_Line], spans: Array) -> Array:
    """Start and end of each line, (L, 2); a line that ends within the paint of another ends on its middle."""
    ends = spans.copy()
    for index, side in np.ndindex(spans.shape):
        line = lines[index]
        end = line.origin + spans[index, side] * line.direction
        steepest = _LEAST_SLANT
        for other, (low, high) in zip(lines, spans, strict=True):
            cosine = float(line.direction @ other.direction)
            slant = 1 - cosine**2
            within = low - paint.half_width <= other.along(end) <= high + paint.half_width
            if within and slant > steepest and other.apart(end) <= paint.half_width + paint.edge / 2:
                steepest = slant
                way = line.direction - cosine * other.direction
                ends[index, side] = (other.origin - line.origin) @ way / slant
    return ends


def _best_line(paint: _Paint, left: Flags) -> _Line | None:
    """The line along which most of the remaining paint is; None if that paint is not longer than wide."""
    candidates = np.flatnonzero(left)
    seeds = candidates[np.linspace(0, len(candidates) - 1, min(_SEEDS, len(candidates))).astype(int)]
    one, other = (paint.points[seeds[part]] for part in np.triu_indices(len(seeds), 1))
    apart = np.linalg.norm(other - one, axis=1)
    one, direction = one[apart > paint.edge / 2], ((other - one) / apart[:, None])[apart > paint.edge / 2]
    voters = paint.points[candidates[:: 1 + len(candidates) // _VOTERS]]
    votes = [
        int((_Line(origin, way, left).apart(voters) <= paint.half_width).sum())
        for origin, way in zip(one, direction, strict=True)
    ]
    best: _Line | None = None
    for index in np.argsort(votes)[::-1][:_CLOSER_LOOKS]:
        line = _along_line(paint, left, one[index], direction[index])
        if best is None or (line.members & left).sum() > (best.members & left).sum():
            best = line
    if best is None:
        return None
    return _centred(paint, left, best)


def _along_line(paint: _Paint, left: Flags, origin: Array, direction: Array) -> _Line:
    """The piece of paint along a line with most of the remaining paint, equally on both sides of the line.

    Where a line leaves its own band for one that branches off, the paint is on one side only.
    """
    line = _Line(origin, direction, left)
    along, apart = line.along(paint.points), line.apart(paint.points)
    around = np.flatnonzero(apart <= 2 * paint.half_width)
    place = np.round((along - along[around].min()) / paint.edge).astype(np.int64)
    count = int(place[around].max()) + 1
    beside = paint.points - origin - along[:, None] * direction
    sums = np.stack([np.bincount(place[around], part[around], count) for part in (*beside.T, paint.weight * 0 + 1)])
    reach = round(paint.half_width / paint.edge)
    sums = np.stack([np.convolve(part, np.ones(2 * reach + 1), "same") for part in sums])
    limit = _ASTRAY[0] * paint.edge + _ASTRAY[1] * paint.half_width
    astray = np.linalg.norm(sums[:-1], axis=0) > limit * sums[-1]
    on = np.flatnonzero(apart <= paint.half_width)
    on = on[~astray[place[on]]]
    order = on[np.argsort(along[on], kind="stable")]
    gaps = np.flatnonzero(np.diff(along[order]) > _GAP * paint.edge + paint.half_width) + 1
    members = np.zeros(len(left), bool)
    members[max(np.split(order, gaps), key=lambda piece: int(left[piece].sum()))] = True
    return _Line(origin, direction, members)


def _centred(paint: _Paint, left: Flags, line: _Line) -> _Line | None:
    """The line moved to the middle of its paint; None if there is no more paint along it than across."""
    for _ in range(_CENTRED_ROUNDS):
        if not line.members.any():
            return None
        points, weight = paint.points[line.members], paint.weight[line.members]
        centre = weight @ points / weight.sum()
        spread, ways = np.linalg.eigh((points - centre).T @ ((points - centre) * weight[:, None]))
        if np.sqrt(spread[-1]) < _LEAST_LENGTH * np.sqrt(max(spread[:-1].sum(), 0.0)):
            return None
        line = _along_line(paint, left, centre, ways[:, -1])
    return line if (line.members & left).any() else None


def _middle(paint: _Paint, line: _Line, low: float, high: float) -> Indices:
    """The shortest path of edges along a line from one place on it to another."""
    along, apart = line.along(paint.points), line.apart(paint.points)
    start, end = (int(np.argmin(np.abs(along - place) + 2 * apart)) for place in (low, high))
    # The squared length makes a path visit a vertex on the line instead of passing it.
    edges = paint.graph.tocoo()
    row, column = edges.coords
    straying = 1 + _STRAYING * (apart[row] ** 2 + apart[column] ** 2) / (2 * paint.edge**2)
    costs = sparse.coo_array((edges.data**2 * straying, (row, column)), shape=edges.shape)
    before = dijkstra(costs, directed=False, indices=start, return_predecessors=True)[1]
    path = [end]
    while path[-1] != start:
        path.append(int(before[path[-1]]))
    return np.array(path[::-1], np.int64)
