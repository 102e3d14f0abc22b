"""A drawn scene with a known outline: a tilted quadrilateral sheet over a desk, and the sparse model of its photos."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from origami.core.camera import Camera
from origami.core.numeric.polygon import inside_polygon
from origami.core.sparse_model import SparseModel
from scipy import ndimage

SIZE = (480, 360)
CORNERS = np.array([[70.3, 60.6], [300.2, 80.4], [320.7, 410.1], [50.9, 430.5]])


def draw(corners=CORNERS, paper=(225, 222, 214), desk=(120, 85, 60), texture=0.0, size=SIZE, seed=0):
    """A photo (h, w, 3) uint8 of a printed sheet with the given corners (4, 2), blurred by half a pixel."""
    random = np.random.default_rng(seed)
    fine = 4
    y, x = np.mgrid[: size[0] * fine, : size[1] * fine]
    pixels = np.stack([x.ravel() + 0.5, y.ravel() + 0.5], axis=1) / fine
    on_paper = inside_polygon(pixels, corners).reshape(y.shape)
    coverage = on_paper.reshape(size[0], fine, size[1], fine).mean(axis=(1, 3))[..., None]
    grain = ndimage.gaussian_filter(random.normal(size=size), 2.0)[..., None]
    ground = (np.array(desk) / 255.0) ** 2.2 * (1 + texture * grain / grain.std())
    sheet = np.broadcast_to((np.array(paper) / 255.0) ** 2.2, (*size, 3)).copy()
    middle = corners.mean(axis=0)
    for row in np.linspace(-0.8, 0.8, 24):
        for column in np.linspace(-0.75, 0.75, 30):
            if random.random() < 0.6:
                px, py = _inside(corners, column, row)
                sheet[int(py) - 1 : int(py) + 1, int(px) - 2 : int(px) + 2] *= 0.1
    assert inside_polygon(middle[None], corners)[0]
    linear = np.clip(coverage * sheet + (1 - coverage) * ground, 0, 1)
    linear = ndimage.gaussian_filter(linear, (0.6, 0.6, 0))
    return np.round(255 * np.clip(_encoded(linear) + random.normal(scale=0.004, size=linear.shape), 0, 1)).astype(
        np.uint8
    )


def _encoded(linear):
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def _inside(corners, column, row):
    u, v = (column + 1) / 2, (row + 1) / 2
    upper = corners[0] * (1 - u) + corners[1] * u
    lower = corners[3] * (1 - u) + corners[2] * u
    return upper * (1 - v) + lower * v


def model(corners=CORNERS, size=SIZE, count=400, seed=0, bend=0.0, desk_points=0):
    """Four cameras side by side over the sheet of `draw`; camera 0 is the photo's. Points are on the sheet first.

    The sheet is the plane z = 1 of camera 0, bent towards the cameras by ``bend``; the desk is at z = 1.2.
    """
    random = np.random.default_rng(seed)
    focal_length = 1.1 * max(size)
    centre = np.array([size[1] / 2, size[0] / 2])
    seen = np.array([_inside(corners, *random.uniform(-0.85, 0.85, 2)) for _ in range(count)])
    depth = 1 - bend * ((seen[:, 0] - centre[0]) / size[1]) ** 2
    on_desk = random.uniform([0, 0], [size[1], size[0]], size=(desk_points, 2))
    pixels = np.concatenate([seen, on_desk])
    depth = np.concatenate([depth, np.full(desk_points, 1.2)])
    points = np.column_stack([(pixels - centre) / focal_length * depth[:, None], depth])
    hidden = np.concatenate([np.zeros(count, bool), inside_polygon(on_desk, corners)])
    return sparse_model(points, [[0.06 * i, 0.0, 0.0] for i in range(4)], focal_length, size, hidden)


def sparse_model(points, centres, focal_length, size, hidden=False):
    """Upright cameras at ``centres`` looking along z, each of which sees every point in its frame of ``size`` (h, w).

    Camera 0 does not see the points that are ``hidden``.
    """
    points = np.asarray(points, float)
    cameras = tuple(
        Camera(
            f"{index}.jpg",
            size[1],
            size[0],
            focal_length,
            np.array([size[1] / 2, size[0] / 2]),
            np.zeros(2),
            np.eye(3),
            -np.asarray(centre, float),
        )
        for index, centre in enumerate(centres)
    )
    point, camera, pixel = [], [], []
    for index, view in enumerate(cameras):
        where = view.project(points)
        visible = ((where > 0) & (where < [size[1], size[0]])).all(axis=1) & ~(np.asarray(hidden) & (index == 0))
        point.append(np.flatnonzero(visible))
        camera.append(np.full(visible.sum(), index))
        pixel.append(where[visible])
    return SparseModel(
        cameras,
        points,
        np.zeros((len(points), 3), np.uint8),
        np.concatenate(point),
        np.concatenate(camera),
        np.concatenate(pixel),
    )


def without(scene: SparseModel, lost: np.ndarray) -> SparseModel:
    """The model without the observations that are ``lost`` (M,)."""
    return replace(
        scene,
        observed_point=scene.observed_point[~lost],
        observed_camera=scene.observed_camera[~lost],
        observed_pixel=scene.observed_pixel[~lost],
    )


def distance_to(polygon, points):
    """Distance of each of ``points`` (N, 2) from the border of a polygon (K, 2)."""
    start, step = polygon, np.roll(polygon, -1, axis=0) - polygon
    offset = points[:, None] - start
    along = np.clip((offset * step).sum(axis=2) / np.maximum((step**2).sum(axis=1), 1e-12), 0, 1)
    return np.linalg.norm(offset - along[..., None] * step, axis=2).min(axis=1)
