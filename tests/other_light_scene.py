"""A folded, printed sheet whose page is known exactly, and other photos of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from origami.core.camera import Camera
from origami.core.page.single_photo import page_of_photo
from origami.core.paper.outline import Outline
from origami.core.sheet import FlatMap, Sheet
from origami.core.sparse_model import SparseModel
from origami.origami_addon.files.photos import gather
from origami.origami_addon.state import Page, Paged, Region
from photo_scene import FOCAL_OVER_LONG_SIDE, PAGE, Pose, folded_sheet, poses, print_texture, render, save

SIZE = (480, 640)
PAGE_PX = (493, 640)
ANGLE = 40.0
_ROWS, _COLUMNS = 8, 12  # of each half


def camera(name: str, pose: Pose, size: tuple[int, int] = SIZE, zoom: float = 1.0) -> Camera:
    """The camera of `photo_scene.render`."""
    focal = zoom * FOCAL_OVER_LONG_SIDE * max(size)
    return Camera(name, *size, focal, np.array(size) / 2, np.zeros(2), pose.rotation, pose.translation)


def sheet(angle: float = ANGLE) -> tuple[Sheet, FlatMap]:
    """The sheet of `folded_sheet` and its flat map."""
    vertices, uv, triangles = [], [], []
    for number, (corner, across, down, part) in enumerate(folded_sheet(angle)):
        a, b = np.meshgrid(np.linspace(0, 1, _COLUMNS + 1), np.linspace(0, 1, _ROWS + 1))
        vertices.append(corner + a[..., None] * across + b[..., None] * down)
        uv.append(np.stack([a * PAGE[0], (part[0] + b * (part[1] - part[0])) * PAGE[1]], axis=-1))
        index = np.arange(a.size).reshape(a.shape) + number * a.size
        p, q, r, s = (each.ravel() for each in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
        triangles += [np.stack([p, r, q], 1), np.stack([q, r, s], 1)]
    index = np.arange(2 * (_ROWS + 1) * (_COLUMNS + 1)).reshape(-1, _COLUMNS + 1)
    edge = np.concatenate([index[:-1, 0], index[-1, :-1], index[:0:-1, -1], index[0, :0:-1]])
    flat = FlatMap(np.concatenate(uv).reshape(-1, 2), PAGE[0], PAGE[1], "page heights", None)
    return Sheet(np.concatenate(vertices).reshape(-1, 3), np.concatenate(triangles), (), edge), flat


def known_page(folder: Path) -> tuple[Paged, list]:
    """The state of a document with the page made, and its photos, which are written into the folder."""
    views = poses(3)
    for index, pose in enumerate(views):
        save(render(pose, folded_sheet(ANGLE), print_texture(1), None, SIZE), folder / f"{index}.png")
    photos, _ = gather(folder)
    cameras = tuple(camera(f"{index}.png", pose) for index, pose in enumerate(views))
    points = np.zeros((0, 3))
    none = np.zeros(0, int)
    model = SparseModel(cameras, points, points.astype(np.uint8), none, none, points[:, :2])
    region = Region(1, Outline(np.array([[50.0, 50], [430, 50], [430, 590]]), 1.0, ()), none.astype(bool))
    folded, flat = sheet()
    reference = render(views[1], folded_sheet(ANGLE), print_texture(1), None, SIZE)
    texture = page_of_photo(folded, flat, cameras, lambda _: reference, 1, PAGE_PX)
    page = Page(texture, 300.0, texture.image)
    return Paged(model, region, cameras, folded, flat.uv, flat, page), photos


def negative(photo: np.ndarray) -> np.ndarray:
    """What is bright becomes dark, as under ultraviolet light: bluish, with another tone curve."""
    dark = 1 - (photo.mean(axis=2, keepdims=True) / 255) ** 0.6
    return (255 * (0.1 + 0.8 * dark) * np.array([0.5, 0.7, 1.0])).astype(np.uint8)


def other_photo(pose: Pose, angle: float = ANGLE, size: tuple[int, int] = SIZE, zoom: float = 1.0, seed: int = 1):
    """A photo of the sheet, or of one in another shape or with another print, in another light."""
    return negative(render(pose, folded_sheet(angle), print_texture(seed), None, size, zoom))
