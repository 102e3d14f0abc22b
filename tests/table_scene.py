"""Drawn photos of sheets on a table with their sparse model, for the search for a sheet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from origami.core.camera import Camera
from origami.core.numeric.image import reduced
from origami.core.numeric.polygon import filled_polygon
from origami.core.paper.sheet_search import FoundSheet, find_sheets
from origami.core.sparse_model import SparseModel
from photo_scene import FOCAL_OVER_LONG_SIDE, PAGE, Pose, folded_sheet, poses, print_texture, render
from scipy import ndimage

SIZE = (480, 640)
TWO_PLACES = (-0.35, 0.0), (0.4, 0.05)
_TEXELS = 640
Planes = list[tuple[np.ndarray, ...]]


def page(density: float = 1.0, paper: Sequence[float] = (232, 230, 224), seed: int = 1) -> np.ndarray:
    """A printed page with a margin, (n, n, 3) float in 0..255; ``density`` is the share of lines that are printed."""
    random = np.random.default_rng(seed)
    picture = np.full((_TEXELS, _TEXELS, 3), paper, float)
    for row in range(60, 580, 14):
        if random.random() > density:
            continue
        column = 60
        while column < 560:
            width = int(random.integers(8, 40))
            picture[row : row + int(random.integers(4, 8)), column : column + width] = random.uniform(10, 90)
            column += width + 6
    return ndimage.gaussian_filter(picture, (0.8, 0.8, 0))


def wood(seed: int = 7, color: Sequence[float] = (140, 95, 60)) -> np.ndarray:
    """A table with grain and knots."""
    random = np.random.default_rng(seed)
    grain = ndimage.gaussian_filter(random.normal(size=(_TEXELS, _TEXELS)), (1.2, 25))
    knots = ndimage.gaussian_filter((random.random((_TEXELS, _TEXELS)) < 0.002).astype(float), 1.5)
    light = 1 + 0.25 * grain / grain.std() - 4 * knots
    return np.clip(light[..., None] * np.array(color), 5, 250)


def plain(color: Sequence[float]) -> np.ndarray:
    """A table without texture except a little unevenness."""
    uneven = ndimage.gaussian_filter(np.random.default_rng(3).normal(size=(_TEXELS, _TEXELS)), 40)
    return np.clip(np.array(color) + 40 * uneven[..., None], 0, 255)


def flat_sheet(at: Sequence[float] = (0.0, 0.0), turn: float = 12.0, scale: float = 1.0) -> Planes:
    """A sheet on the table: one plane for `photo_scene.render`."""
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    right, down = scale * PAGE[0] * np.array([c, s, 0.0]), scale * PAGE[1] * np.array([s, -c, 0.0])
    corner = np.array([*at, 0.002]) - 0.5 * right - 0.5 * down
    return [(corner, right, down, np.array([0.0, 1.0]))]


@dataclass(frozen=True)
class TableScene:
    """Photos, their sparse model, and the true outline in every photo."""

    photos: list[np.ndarray]
    model: SparseModel
    outlines: list[np.ndarray]

    @property
    def reduced(self) -> list[np.ndarray]:
        """In the form for `find_sheets`."""
        return [reduced(photo) for photo in self.photos]

    def overlap(self, index: int, polygon: np.ndarray) -> float:
        """Intersection over union of an outline and the true one in a photo."""
        height, width = self.photos[index].shape[:2]
        found, true = filled_polygon(polygon, (height, width)), filled_polygon(self.outlines[index], (height, width))
        return float((found & true).sum() / (found | true).sum())


def table_scene(
    sheets: Sequence[tuple[Planes, np.ndarray]],
    table: np.ndarray,
    table_points: int = 600,
    sheet_points: int = 500,
    count: int = 5,
    seed: int = 0,
) -> TableScene:
    """Photos of sheets (planes and their print) on a table; the first sheet is the intended one."""
    cameras = poses(count, seed=seed)
    photos = [_photo(pose, sheets, table) for pose in cameras]
    random = np.random.default_rng(seed)
    points = [_on_planes(planes, sheet_points, random) for planes, _ in sheets]
    around = random.uniform(-1.3, 1.3, (table_points, 2))
    points.append(np.column_stack([around, np.zeros(table_points)]))
    model = _sparse_model(np.concatenate(points), cameras, [planes for planes, _ in sheets])
    edge = _edge(sheets[0][0])
    return TableScene(photos, model, [camera.project(edge) for camera in model.cameras])


@cache
def letter_on_wood() -> TableScene:
    """A printed sheet on a wooden table; all tests of a process share it, so none may change it."""
    return table_scene([(flat_sheet(), page())], wood())


@cache
def letter_found() -> tuple[FoundSheet, ...]:
    """The sheets that a search finds on `letter_on_wood`."""
    scene = letter_on_wood()
    return tuple(find_sheets(scene.model, scene.reduced))


def two_sheets() -> TableScene:
    """Photos aimed between two sheets, whose middles are `TWO_PLACES`."""
    lying = [flat_sheet(at, turn, 0.5) for at, turn in zip(TWO_PLACES, (5.0, -20.0), strict=True)]
    return table_scene([(planes, page(0.6, seed=seed)) for seed, planes in enumerate(lying)], wood())


def _photo(pose: Pose, sheets: Sequence[tuple[Planes, np.ndarray]], table: np.ndarray) -> np.ndarray:
    """Drawn at twice the resolution and shrunk, which makes edges as soft as a photo's; sheets do not overlap."""
    fine = (2 * SIZE[0], 2 * SIZE[1])
    photo = render(pose, *sheets[0], table, fine)
    for planes, texture in sheets[1:]:
        there = render(pose, planes, np.full_like(texture, 255), None, fine)[..., 0] == 255
        photo[there] = render(pose, planes, texture, None, fine)[there]
    return photo.reshape(SIZE[1], 2, SIZE[0], 2, 3).mean(axis=(1, 3)).round().astype(np.uint8)


def _on_planes(planes: Planes, count: int, random: np.random.Generator) -> np.ndarray:
    """Points on the sheet, none in its margin."""
    found = []
    for corner, right, down, part in planes:
        u, v = random.uniform(0.1, 0.9, count // len(planes)), random.uniform(0.1, 0.9, count // len(planes))
        whole = (0.1 - part[0]) / (part[1] - part[0]), (0.9 - part[0]) / (part[1] - part[0])
        v = np.clip(v, *whole)
        found.append(corner + u[:, None] * right + v[:, None] * down)
    return np.concatenate(found)


def _edge(planes: Planes) -> np.ndarray:
    """World points around a sheet of one or two planes."""
    part = np.linspace(0, 1, 30)[:, None]
    first, last = planes[0], planes[-1]
    right = [corner + u + part * v for corner, u, v, _ in planes]
    left = [corner + (1 - part) * v for corner, u, v, _ in reversed(planes)]
    top, bottom = first[0] + part * first[1], last[0] + last[2] + (1 - part) * last[1]
    return np.concatenate([top, *right, bottom, *left])


def _sparse_model(points: np.ndarray, cameras: Sequence[Pose], sheets: Sequence[Planes]) -> SparseModel:
    focal_length = FOCAL_OVER_LONG_SIDE * max(SIZE)
    centre = np.array([SIZE[0] / 2, SIZE[1] / 2])
    posed = [
        Camera(f"{k}.png", *SIZE, focal_length, centre, np.zeros(2), pose.rotation, pose.translation)
        for k, pose in enumerate(cameras)
    ]
    hidden = np.zeros(len(points), bool)
    for planes in sheets:
        for corner, right, down, _ in planes:
            off = points - corner
            u, v = off[:, :2] @ right[:2] / (right[:2] @ right[:2]), off[:, :2] @ down[:2] / (down[:2] @ down[:2])
            hidden |= (u > 0) & (u < 1) & (v > 0) & (v < 1) & (points[:, 2] == 0)
    points = points[~hidden]
    seen_point, seen_camera, seen_pixel = [], [], []
    for index, camera in enumerate(posed):
        pixel = camera.project(points)
        inside = np.flatnonzero(((pixel > 2) & (pixel < np.array(SIZE) - 2)).all(axis=1))
        seen_point.append(inside)
        seen_camera.append(np.full(len(inside), index))
        seen_pixel.append(pixel[inside])
    return SparseModel(
        tuple(posed),
        points,
        np.full((len(points), 3), 128, np.uint8),
        np.concatenate(seen_point),
        np.concatenate(seen_camera),
        np.concatenate(seen_pixel),
    )


__all__ = ["TableScene", "flat_sheet", "folded_sheet", "page", "plain", "print_texture", "table_scene", "wood"]
