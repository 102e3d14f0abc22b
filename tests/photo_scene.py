"""Small photos of a folded, printed sheet on a desk, with known cameras: exact pictures of a few textured planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image
from scipy import ndimage

PAGE = np.array([0.77, 1.0])
FOCAL_OVER_LONG_SIDE = 0.85
_TEXELS = 640


@dataclass(frozen=True)
class Pose:
    """World to camera of one photo."""

    rotation: np.ndarray
    translation: np.ndarray

    @property
    def center(self) -> np.ndarray:
        return -self.rotation.T @ self.translation


def print_texture(seed: int, contrast: float = 1.0) -> np.ndarray:
    """Something like print: bars and blots of many sizes on white, no two places alike; (n, n, 3) float in 0..255."""
    random = np.random.default_rng(seed)
    picture = np.full((_TEXELS, _TEXELS, 3), 235.0)
    for _ in range(1300):
        height, width = random.integers(3, 10), random.integers(3, 32)
        row, column = random.integers(0, _TEXELS, 2)
        picture[row : row + height, column : column + width] = random.uniform(20, 200, 3)
    return 235 + contrast * (ndimage.gaussian_filter(picture, (0.8, 0.8, 0)) - 235)


def poses(count: int, spread: float = 35.0, roll: float = 8.0, distance: float = 1.75, seed: int = 0) -> list[Pose]:
    """Cameras on an arc of ``spread`` degrees to either side above the sheet, all looking at its middle."""
    random = np.random.default_rng(seed)
    found = []
    for azimuth in np.radians(np.linspace(-spread, spread, count)):
        elevation = np.radians(random.uniform(55, 75))
        toward = np.array(
            [np.sin(azimuth) * np.cos(elevation), -np.cos(azimuth) * np.cos(elevation), np.sin(elevation)]
        )
        forward = -toward
        right = np.cross(forward, [0.0, 1.0, 0.0])
        right /= np.linalg.norm(right)
        angle = np.radians(random.uniform(-roll, roll))
        down = np.cross(forward, right)
        right, down = np.cos(angle) * right + np.sin(angle) * down, np.cos(angle) * down - np.sin(angle) * right
        rotation = np.stack([right, down, forward])
        found.append(Pose(rotation, -rotation @ (toward * distance)))
    return found


def folded_sheet(angle: float = 40.0, moved: Sequence[float] = (0.0, 0.0, 0.0)) -> list[tuple[np.ndarray, ...]]:
    """Two halves that meet at a fold across the middle, raised there: (corner, along u, along v, part of v)."""
    half = PAGE[1] / 2
    slope = np.radians(angle / 2)
    rise, run = half * np.sin(slope), half * np.cos(slope)
    turn = np.array([[np.cos(moved[2]), -np.sin(moved[2]), 0], [np.sin(moved[2]), np.cos(moved[2]), 0], [0, 0, 1]])
    shift = np.array([moved[0], moved[1], 0.0])
    across = turn @ [PAGE[0], 0, 0]
    top = turn @ [-PAGE[0] / 2, run, 0.01] + shift
    ridge = turn @ [-PAGE[0] / 2, 0, 0.01 + rise] + shift
    return [
        (top, across, turn @ [0, -run, rise], np.array([0.0, 0.5])),
        (ridge, across, turn @ [0, -run, -rise], np.array([0.5, 1.0])),
    ]


def render(
    pose: Pose,
    sheet: list[tuple[np.ndarray, ...]],
    page: np.ndarray,
    desk: np.ndarray | None,
    size: tuple[int, int] = (480, 640),
    zoom: float = 1.0,
) -> np.ndarray:
    """A photo of ``size`` (width, height) as (h, w, 3) uint8: the nearest plane is visible, without noise."""
    width, height = size
    focal = zoom * FOCAL_OVER_LONG_SIDE * max(size)
    row, column = np.mgrid[:height, :width] + 0.5
    rays = np.stack([(column - width / 2) / focal, (row - height / 2) / focal, np.ones_like(row)], -1) @ pose.rotation
    photo = np.full((height, width, 3), 90.0)
    nearest = np.full((height, width), np.inf)
    planes = [(corner, u, v, page, part) for corner, u, v, part in sheet]
    if desk is not None:
        planes.append(
            (np.array([-1.6, 1.6, 0]), np.array([3.2, 0, 0]), np.array([0, -3.2, 0]), desk, np.array([0, 1.0]))
        )
    for corner, u, v, texture, part in planes:
        normal = np.cross(u, v)
        depth = (corner - pose.center) @ normal / (rays @ normal)
        point = pose.center + rays * depth[..., None] - corner
        a, b = point @ u / (u @ u), point @ v / (v @ v)
        hit = (depth > 0) & (depth < nearest) & (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1)
        at = np.stack([(part[0] + b[hit] * (part[1] - part[0])) * _TEXELS, a[hit] * _TEXELS]) - 0.5
        photo[hit] = np.stack(
            [ndimage.map_coordinates(texture[..., c], at, order=1, mode="nearest") for c in range(3)], 1
        )
        nearest[hit] = depth[hit]
    return (photo + 0.5).clip(0, 255).astype(np.uint8)


def save(photo: np.ndarray, path: Path, **options: object) -> Path:
    """Write a photo with Pillow, with the JPEG quality of phones."""
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(photo).save(path, **({"quality": 95} if path.suffix == ".jpg" else {}), **options)
    return path


def photo_set(folder: Path, count: int = 6, seed: int = 1, desk: bool = True, angle: float = 40.0) -> list[Pose]:
    """``count`` photos 0.jpg, 1.jpg, ... of one sheet in ``folder``; their poses."""
    page, surface = print_texture(seed), print_texture(seed + 1000, 0.6) if desk else None
    cameras = poses(count)
    for index, pose in enumerate(cameras):
        save(render(pose, folded_sheet(angle), page, surface), folder / f"{index}.jpg")
    return cameras
