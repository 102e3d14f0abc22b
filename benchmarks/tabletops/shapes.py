"""Sheets of paper on a table as exact isometric bends: plane facets hinged along lines, and where they come to rest.

Flat coordinates are millimetres, u to the right and v down from the page's top left corner. In space z is up, the table
is the plane z = 0, and the printed side looks up; the flat page would have x along u and y against v.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from ...core.numeric.polygon import signed_area

Array = NDArray[np.float64]
Random = np.random.Generator


@dataclass(frozen=True)
class Facet:
    """A plane piece: flat corners (K, 2), and ``rotation @ (u, -v, 0) + origin`` takes a flat position to space."""

    flat: Array
    rotation: Array
    origin: Array

    def in_space(self, flat: Array) -> Array:
        """Flat positions (..., 2) of this facet's plane in space (..., 3)."""
        return (flat * [1, -1]) @ self.rotation[:, :2].T + self.origin

    @property
    def corners(self) -> Array:
        return self.in_space(self.flat)

    @property
    def normal(self) -> Array:
        return self.rotation[:, 2]

    def moved(self, rotation: Array, shift: Array) -> Facet:
        """The facet after the rigid motion ``rotation @ x + shift``."""
        return Facet(self.flat, rotation @ self.rotation, rotation @ self.origin + shift)


def clip(polygon: Array, point: Array, direction: Array) -> Array:
    """The part of a convex polygon (K, 2) on the right of whoever walks on the page along ``direction``."""
    side = _side(polygon, point, direction)
    kept = []
    for here, there, a, b in zip(polygon, np.roll(polygon, -1, 0), side, np.roll(side, -1)):
        if a >= 0:
            kept.append(here)
        if (a < 0) != (b < 0):
            kept.append(here + a / (a - b) * (there - here))
    return np.array(kept).reshape(-1, 2)


def _side(points: Array, point: Array, direction: Array) -> Array:
    offset = points - point
    return direction[0] * offset[..., 1] - direction[1] * offset[..., 0]


def page_corners(width: float, height: float) -> Array:
    return np.array([[0, 0], [width, 0], [width, height], [0, height]], float)


def hinged(width: float, height: float, lines: Sequence[tuple[Array, Array, float]]) -> list[Facet]:
    """A page bent along lines that do not cross on it.

    Parameters
    ----------
    width, height : float
    lines : sequence of (point, direction, angle)
        In order across the page, each on the right of its predecessor (of whoever walks along it on the page).
        ``angle`` in radians is how far the part on the right turns up from the part before it.
    """
    rotation, origin = np.eye(3), np.zeros(3)
    rest = page_corners(width, height)
    facets = []
    for point, direction, angle in lines:
        before = clip(rest, point, -direction)
        if len(before) >= 3:
            facets.append(Facet(before, rotation, origin))
        rest = clip(rest, point, direction)
        # About the line in space as it lay before all bends; then as all lines before have moved it.
        axis = np.array([direction[0], -direction[1], 0.0]) / np.linalg.norm(direction)
        pivot = np.array([point[0], -point[1], 0.0])
        turn = Rotation.from_rotvec(-angle * axis).as_matrix()
        origin = rotation @ (pivot - turn @ pivot) + origin
        rotation = rotation @ turn
    if len(rest) >= 3:
        facets.append(Facet(rest, rotation, origin))
    return facets


def rolled(width: float, height: float, degrees: float, slope: Array, positions: Array) -> list[Facet]:
    """A cylinder with rulings at ``degrees`` from the u axis.

    ``slope`` (N,) is the rise angle in radians of the strip that begins at each of ``positions`` (N,), which are
    millimetres across the rulings from the page's middle.
    """
    angle = np.radians(degrees)
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    middle = np.array([width, height]) / 2
    lines = [(middle + s * across, along, bend) for s, bend in zip(positions[1:], np.diff(slope), strict=True)]
    facets = hinged(width, height, lines)
    turn = Rotation.from_rotvec(-slope[0] * np.array([along[0], -along[1], 0])).as_matrix()
    return [facet.moved(turn, np.zeros(3)) for facet in facets]


def crossed(width: float, height: float, vertex: Array, sectors: tuple[float, float], fold: float) -> list[Facet]:
    """Four creases that meet in ``vertex``: a flat-foldable rigid vertex whose sectors are a, b, 180 - a, 180 - b.

    ``sectors`` are a and b in degrees, the first crease runs to the right; ``fold`` is the angle in radians by which
    the angle from the first crease to the third is less than the flattest possible.
    """
    a, b = np.radians(sectors)
    sizes = np.array([a, b, np.pi - a, np.pi - b])
    flat_angles = np.array([0, a, a + b, np.pi + b])
    flat_rays = np.stack([np.cos(flat_angles), np.sin(flat_angles)], -1)
    opened = np.pi - abs(np.pi - a - b) - fold
    first, third = np.array([1.0, 0, 0]), np.array([np.cos(opened), -np.sin(opened), 0])

    def at_angles(to_first: float, to_third: float, side: float) -> Array:
        cosine = np.cos(opened)
        x, y = np.linalg.solve([[1, cosine], [cosine, 1]], [np.cos(to_first), np.cos(to_third)])
        in_plane = x * first + y * third
        return in_plane + side * np.sqrt(1 - in_plane @ in_plane) * np.array([0, 0, 1.0])

    rays = np.stack([first, at_angles(sizes[0], sizes[1], 1), third, at_angles(sizes[3], sizes[2], 1)])
    facets = []
    for i in range(4):
        j = (i + 1) % 4
        flat = clip(clip(page_corners(width, height), vertex, flat_rays[i]), vertex, -flat_rays[j])
        on_flat = np.stack([np.append(ray * [1, -1], 0) for ray in (flat_rays[i], flat_rays[j])])
        flat_frame = np.column_stack([*on_flat, np.cross(*on_flat)])
        frame = np.column_stack([rays[i], rays[j], np.cross(rays[i], rays[j])])
        rotation = frame @ np.linalg.inv(flat_frame)
        facets.append(Facet(flat, rotation, -rotation @ np.array([vertex[0], -vertex[1], 0])))
    return facets


def rest(facets: Sequence[Facet], steepest: float = 40.0) -> list[Facet]:
    """The sheet at rest: its centre of mass above a face of its convex hull, its middle at x = y = 0, its lowest z 0.

    ``steepest`` is how far in degrees it may tip from its mean plane.
    """
    corners = np.concatenate([facet.corners for facet in facets])
    areas = np.array([abs(signed_area(facet.flat)) for facet in facets])
    centre = areas @ np.stack([facet.corners.mean(0) for facet in facets]) / areas.sum()
    normal = areas @ np.stack([facet.normal for facet in facets])
    level = _turn(normal / np.linalg.norm(normal), np.array([0, 0, 1.0]))
    points = (corners - centre) @ level.T
    if np.ptp(points[:, 2]) > 0.5:
        hull = ConvexHull(points, qhull_options="QJ")
        best, down = -np.inf, None
        for equation, simplex in zip(hull.equations, hull.simplices):
            if equation[2] > -np.cos(np.radians(steepest)):
                continue
            triangle = points[simplex] @ _turn(-equation[:3], np.array([0, 0, 1.0])).T
            inside = _inside_triangle(triangle[:, :2])
            if inside > best:
                best, down = inside, -equation[:3]
        if down is not None:
            level = _turn(down, np.array([0, 0, 1.0])) @ level
            points = (corners - centre) @ level.T
    low, high = points.min(0), points.max(0)
    shift = -level @ centre - np.array([*(low + high)[:2] / 2, low[2]])
    return [facet.moved(level, shift) for facet in facets]


def _turn(source: Array, target: Array) -> Array:
    """The smallest rotation from one unit vector to another."""
    axis = np.cross(source, target)
    sine = np.linalg.norm(axis)
    if sine < 1e-12:
        return np.eye(3)
    return Rotation.from_rotvec(axis / sine * np.arctan2(sine, source @ target)).as_matrix()


def _inside_triangle(corners: Array) -> float:
    """Distance of the origin inside a triangle, negative outside."""
    edge = np.roll(corners, -1, 0) - corners
    distance = (edge[:, 1] * corners[:, 0] - edge[:, 0] * corners[:, 1]) / (np.linalg.norm(edge, axis=1) + 1e-12)
    return float(max(distance.min(), (-distance).min()))


def border(facets: Sequence[Facet], width: float, height: float, spacing: float = 2.0) -> Array:
    """The page's edge in space (K, 3), clockwise on the page from its top left corner, not closed."""
    corners = page_corners(width, height)
    flat = []
    for start, end in zip(corners, np.roll(corners, -1, 0)):
        steps = max(2, round(np.linalg.norm(end - start) / spacing))
        way = [np.arange(steps) / steps]
        # Where a crease reaches the edge the outline has a corner of its own.
        for facet in facets:
            share = (facet.flat - start) @ (end - start) / ((end - start) ** 2).sum()
            on_edge = np.abs(_side(facet.flat, start, end - start)) < 1e-6
            way.append(share[on_edge & (share > 1e-9) & (share < 1 - 1e-9)])
        flat.append(start + np.unique(np.concatenate(way).round(9))[:, None] * (end - start))
    return in_space(facets, np.concatenate(flat))


def in_space(facets: Sequence[Facet], flat: Array) -> Array:
    """Flat positions (N, 2) of the page in space (N, 3)."""
    best = np.full(len(flat), -np.inf)
    found = np.zeros((len(flat), 3))
    for facet in facets:
        corners = facet.flat if signed_area(facet.flat) > 0 else facet.flat[::-1]
        edge = np.roll(corners, -1, 0) - corners
        offset = flat[:, None] - corners
        inside = (edge[:, 0] * offset[..., 1] - edge[:, 1] * offset[..., 0]) / np.maximum(
            np.linalg.norm(edge, axis=1), 1e-9
        )
        nearer = inside.min(1) > best
        best[nearer] = inside.min(1)[nearer]
        found[nearer] = facet.in_space(flat[nearer])
    return found
