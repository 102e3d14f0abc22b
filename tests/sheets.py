"""Synthetic sheets of paper with an exactly known flat map, as seen by a camera and by structure from motion.

Flat coordinates are page heights, u to the right and v down from the page's top left corner. In space the unbent page
is in z = 0 with x along u and y along v, its printed side towards -z, its middle at the origin.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from origami.core.arrays import Array
from origami.core.camera import Camera
from origami.core.sheet import Sheet
from scipy.spatial import Delaunay, cKDTree
from scipy.spatial.transform import Rotation

WIDTH, HEIGHT = 0.7, 1.0
_GAUSS_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(16)


@dataclass(frozen=True)
class SyntheticSheet:
    """A page ``WIDTH`` x ``HEIGHT``.

    ``in_space`` maps flat positions (..., 2) to (..., 3); each crease is its two flat end points (2, 2).
    """

    name: str
    in_space: Callable[[Array], Array]
    creases: tuple[Array, ...] = ()


def _clip_to_page(point: Array, direction: Array) -> Array:
    """Both ends (2, 2) of the line through ``point`` along ``direction`` inside the page, exactly on its edge."""
    with np.errstate(divide="ignore"):
        steps = np.stack([-point / direction, ([WIDTH, HEIGHT] - point) / direction])
    ends = point + np.array([[np.nanmax(steps.min(0))], [np.nanmin(steps.max(0))]]) * direction
    for edge in ([0, 0], [WIDTH, HEIGHT]):
        ends = np.where(np.abs(ends - edge) < 1e-12, edge, ends)
    return ends


def _level(in_space: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """``in_space`` moved rigidly as near as possible to the flat page."""
    flat = np.stack(np.meshgrid(np.linspace(0, WIDTH, 21), np.linspace(0, HEIGHT, 29)), -1).reshape(-1, 2)
    spatial = in_space(flat)
    target = np.c_[flat - [WIDTH / 2, HEIGHT / 2], np.zeros(len(flat))]
    centre = spatial.mean(0)
    rotation, _ = Rotation.align_vectors(target, spatial - centre)
    return lambda uv: (in_space(uv) - centre) @ rotation.as_matrix().T


def _bent(
    name: str,
    ruling_degrees: float,
    bend: Callable[[Array], Array],
    folds: tuple[tuple[float, float], ...] = (),
) -> SyntheticSheet:
    """Parallel rulings at ``ruling_degrees`` from the u axis.

    ``bend(s)`` is the slope angle of the profile at arc length ``s`` from the page's middle; folds are (s, radians).
    """
    angle = np.radians(ruling_degrees)
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    middle = np.array([WIDTH / 2, HEIGHT / 2])
    knots = np.array([-2.0, *sorted(s for s, _ in folds), 2.0])
    turns = np.cumsum([0.0, *(turn for _, turn in sorted(folds))])

    def in_space(uv: Array) -> Array:
        s, t = (uv - middle) @ across, (uv - middle) @ along
        profile = np.zeros((*s.shape, 2))
        for (start, end), turn in zip(pairwise(knots), turns, strict=True):
            span = np.clip(s, start, end) - np.clip(0, start, end)
            slope = bend(np.clip(0, start, end) + (span[..., None] * (_GAUSS_NODES + 1)) / 2) + turn
            weights = _GAUSS_WEIGHTS / 2
            profile += span[..., None] * np.stack([np.cos(slope) @ weights, np.sin(slope) @ weights], -1)
        flat = profile[..., :1] * across + t[..., None] * along
        return np.concatenate([flat, profile[..., 1:]], -1)

    creases = tuple(_clip_to_page(middle + s * across, along) for s, _ in folds)
    return SyntheticSheet(name, _level(in_space), creases)


def _straight(s: Array) -> Array:
    return np.zeros_like(s)


def plane() -> SyntheticSheet:
    return _bent("plane", 0, _straight)


def cylinder() -> SyntheticSheet:
    """An oblique sine-like curl without creases."""
    return _bent("cylinder", 65, lambda s: 0.5 * np.sin(6 * s + 0.4))


def gutter() -> SyntheticSheet:
    """The page of an open book: hardly bent where it is printed, and sinking into the gutter in its left margin."""
    margin, steepest = 0.1, 1.0
    return _bent("gutter", 90, lambda s: steepest * np.clip((s - WIDTH / 2 + margin) / margin, 0, 1) + 0.2 * s)


def one_fold() -> SyntheticSheet:
    """Two planes meeting in a crease across the page."""
    return _bent("one_fold", 0, _straight, ((-0.08, 0.6),))


def two_folds() -> SyntheticSheet:
    """Folded in thirds, as a letter."""
    return _bent("two_folds", 0, _straight, ((-1 / 6, 0.7), (1 / 6, -0.6)))


def three_folds() -> SyntheticSheet:
    return _bent("three_folds", 0, _straight, ((-0.25, 0.5), (0.0, -0.7), (0.25, 0.6)))


def oblique_fold() -> SyntheticSheet:
    return _bent("oblique_fold", 32, _straight, ((0.05, 0.7),))


def curved_folds() -> SyntheticSheet:
    """A curl and two creases along the same rulings."""
    return _bent("curved_folds", 8, lambda s: 0.35 * np.sin(5 * s), ((-0.2, 0.5), (0.17, -0.45)))


def cone() -> SyntheticSheet:
    """A piece of a circular cone whose apex is beside the page."""
    apex, half_angle = np.array([-0.5, -0.35]), np.radians(35)

    def in_space(uv: Array) -> Array:
        radius = np.linalg.norm(uv - apex, axis=-1)
        turn = np.arctan2(uv[..., 1] - apex[1], uv[..., 0] - apex[0]) / np.sin(half_angle)
        direction = np.stack([np.sin(half_angle) * np.cos(turn), np.sin(half_angle) * np.sin(turn)], -1)
        return radius[..., None] * np.concatenate([direction, np.full((*turn.shape, 1), np.cos(half_angle))], -1)

    return SyntheticSheet("cone", _level(in_space))


def cross() -> SyntheticSheet:
    """Four creases meeting in one point: a rigid origami vertex, each sector stays plane."""
    vertex = np.array([0.33, 0.47])
    flat_angles = np.radians([-100, -30, 50, 165])
    sectors = np.diff([*flat_angles, flat_angles[0] + 2 * np.pi])
    flat_rays = np.stack([np.cos(flat_angles), np.sin(flat_angles)], -1)
    # The angle in space from the first crease to the third: 2 degrees less than flat make folds of 41, -11, 42, 11.
    opened = sectors[0] + sectors[1] - np.radians(2)
    first, third = np.array([1.0, 0, 0]), np.array([np.cos(opened), np.sin(opened), 0])

    def at_angles(to_first: float, to_third: float, side: float) -> Array:
        c1, c3, c = np.cos(to_first), np.cos(to_third), np.cos(opened)
        x, y = np.linalg.solve([[1, c], [c, 1]], [c1, c3])
        in_plane = x * first + y * third
        return in_plane + side * np.sqrt(1 - in_plane @ in_plane) * np.array([0, 0, 1.0])

    second, fourth = at_angles(sectors[0], sectors[1], 1), at_angles(sectors[3], sectors[2], 1)
    rays = np.stack([first, second, third, fourth])
    sector_ends = np.stack([flat_rays, np.roll(flat_rays, -1, 0)], 1)
    maps = np.linalg.solve(sector_ends, np.stack([rays, np.roll(rays, -1, 0)], 1))

    def in_space(uv: Array) -> Array:
        offset = uv - vertex
        angle = np.mod(np.arctan2(offset[..., 1], offset[..., 0]) - flat_angles[0], 2 * np.pi)
        sector = np.searchsorted(np.cumsum(sectors)[:3], angle, side="right")
        return np.einsum("...i,...ij->...j", offset, maps[sector])

    creases = tuple(np.stack([vertex, _clip_to_page(vertex, ray)[1]]) for ray in flat_rays)
    return SyntheticSheet("cross", _level(in_space), creases)


def sharp_letter() -> SyntheticSheet:
    """Folded in thirds, by 120 degrees each; too steep for a camera above it."""
    return _bent("sharp_letter", 0, _straight, ((-1 / 6, 2.1), (1 / 6, -2.1)))


def roll() -> SyntheticSheet:
    """Rolled up obliquely, by 270 degrees from top to bottom; it hides itself from a camera above it."""
    return _bent("roll", 70, lambda s: 4.7 * s)


ALL = (plane, cylinder, cone, one_fold, two_folds, three_folds, oblique_fold, curved_folds, cross)


def camera(tilt_degrees: tuple[float, float] = (20, 11), distance: float = 2.2) -> Camera:
    """A 2400 x 3200 photo of the sheet from ``distance`` page heights, tilted about x and y, with some distortion."""
    rotation = Rotation.from_euler("xy", tilt_degrees, degrees=True).as_matrix()
    return Camera(
        name="synthetic.jpg",
        width=2400,
        height=3200,
        focal_length=5600.0,
        principal_point=np.array([1200.0, 1600.0]),
        distortion=np.array([-0.03, 0.0]),
        rotation=rotation,
        translation=np.array([0, 0, distance]),
    )


def outline_flat(spacing: float = 0.01) -> Array:
    """Points (K, 2) along the page's edge, clockwise on the page from its top left corner."""
    across, down = np.arange(0, WIDTH - 1e-9, spacing), np.arange(0, HEIGHT - 1e-9, spacing)
    return np.concatenate(
        [
            np.c_[across, np.zeros_like(across)],
            np.c_[np.full_like(down, WIDTH), down],
            np.c_[WIDTH - across, np.full_like(across, HEIGHT)],
            np.c_[np.zeros_like(down), HEIGHT - down],
        ]
    )


def outline_pixels(sheet: SyntheticSheet, view: Camera, spacing: float = 0.01) -> Array:
    """The paper's edge (K, 2) in distorted pixels, clockwise on screen."""
    return view.project(sheet.in_space(outline_flat(spacing)))


def flat_at(sheet: SyntheticSheet, view: Camera, pixels: Array) -> Array:
    """Flat positions (N, 2) that ``view`` sees at distorted ``pixels`` (N, 2), also a little beyond the edge."""
    flat = np.stack(np.meshgrid(np.linspace(0, WIDTH, 71), np.linspace(0, HEIGHT, 101)), -1).reshape(-1, 2)
    flat = flat[cKDTree(view.project(sheet.in_space(flat))).query(pixels)[1]]
    step = 1e-6
    for _ in range(12):  # Newton's, which may have to cross a crease
        here = view.project(sheet.in_space(flat))
        slopes = [(view.project(sheet.in_space(flat + step * axis)) - here) / step for axis in np.eye(2)]
        flat = flat + np.linalg.solve(np.stack(slopes, -1), (pixels - here)[..., None])[..., 0]
    return flat


def sample_points(
    sheet: SyntheticSheet,
    view: Camera,
    count: int,
    noise: float = 0.002,
    outliers: float = 0.1,
    margin: float = 0.05,
    lines: bool = True,
    seed: int = 0,
) -> tuple[Array, Array]:
    """World points (count, 3) as structure from motion leaves them, and their true flat positions (count, 2).

    ``noise`` (page heights) acts along the ray of ``view`` and, a third of it, in every direction; a share ``outliers``
    is off by up to a quarter of its depth. ``lines`` puts the points on lines of text inside empty margins.
    """
    random = np.random.default_rng(seed)
    flat = margin + random.random((count, 2)) * ([WIDTH - 2 * margin, HEIGHT - 2 * margin])
    if lines:
        pitch = 0.022
        flat[:, 1] = margin + np.floor((flat[:, 1] - margin) / pitch) * pitch + 0.4 * pitch * random.random(count)
    points = sheet.in_space(flat)
    ray = points - view.center
    depth = np.linalg.norm(ray, axis=1, keepdims=True)
    along = noise * random.standard_normal((count, 1))
    wrong = random.random(count) < outliers
    along[wrong] = random.uniform(-0.25, 0.25, (wrong.sum(), 1)) * depth[wrong]
    return points + along * ray / depth + noise / 3 * random.standard_normal((count, 3)), flat


def mesh(sheet: SyntheticSheet, spacing: float = 0.02) -> tuple[Sheet, Array]:
    """The exact sheet as a mesh with edges along its creases, and the flat position (V, 2) of each vertex."""
    across = np.linspace(0, WIDTH, round(WIDTH / spacing) + 1)
    down = np.linspace(0, HEIGHT, round(HEIGHT / spacing) + 1)
    grid = np.stack(np.meshgrid(across, down), -1).reshape(-1, 2)
    corner = (np.isin(grid, [0, WIDTH]) | np.isin(grid, [0, HEIGHT])).all(1)
    lines = []
    for start, end in sheet.creases:
        steps = np.linspace(0, 1, max(2, round(np.linalg.norm(end - start) / spacing) + 1))[:, None]
        lines.append(np.where(steps < 1, start + steps * (end - start), end))
        way = np.clip((grid - start) @ (end - start) / ((end - start) ** 2).sum(), 0, 1)
        far = np.linalg.norm(grid - start - way[:, None] * (end - start), axis=1) > 0.6 * spacing
        grid, corner = grid[far | corner], corner[far | corner]
    flat, index = np.unique(np.concatenate([grid, *lines]).round(13), axis=0, return_inverse=True)
    index = index.ravel()
    offsets = np.cumsum([len(grid), *(len(line) for line in lines)])
    ridges = tuple(index[a:b] for a, b in pairwise(offsets))

    triangles = Delaunay(flat).simplices.astype(np.int64)
    first, second = (flat[triangles[:, i]] - flat[triangles[:, 0]] for i in (1, 2))
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    triangles, area = triangles[np.abs(area) > 1e-12], area[np.abs(area) > 1e-12]
    triangles[area > 0] = triangles[area > 0][:, ::-1]  # v is down: counter-clockwise on the page is negative

    on_edge = np.flatnonzero(np.isin(flat[:, 0], [0, WIDTH]) | np.isin(flat[:, 1], [0, HEIGHT]))
    u, v = flat[on_edge].T
    left, bottom, right = u == 0, v == HEIGHT, u == WIDTH
    way = np.select([left, bottom, right], [v, HEIGHT + u, 2 * HEIGHT + WIDTH - v], 2 * (HEIGHT + WIDTH) - u)
    return Sheet(sheet.in_space(flat), triangles, ridges, on_edge[np.argsort(way)]), flat
