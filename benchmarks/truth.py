"""The exact sheet of a rendered scene, and how far a recovered surface is from it.

A scene folder holds ``gt_mesh.npz`` (a dense grid: ``xyz`` and flat ``uv`` in mm, u right, v down) and ``scene.json``
(``page_mm`` and the true cameras). All errors are per cent of the page's height. How far the page is from the truth is
measured in `page_error`.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from ..core.camera import Camera
from ..core.page.raster import interpolate, rasterize

Array = NDArray[np.float64]

_ALIGN_STEPS = 40
_ALIGN_VERTICES = 4000
# A vertex may only be beyond the edge if its nearest point of the truth is this close (mm) to it.
_EDGE_MM = 0.4


@dataclass(frozen=True)
class Similarity:
    """``scale * rotation @ x + shift``."""

    scale: float
    rotation: Array
    shift: Array

    def __call__(self, points: Array) -> Array:
        return self.scale * points @ self.rotation.T + self.shift


def fit_similarity_in_space(source: Array, target: Array) -> Similarity:
    """Umeyama's least-squares similarity from ``source`` (N, 3) to ``target`` (N, 3), never a mirror image."""
    a, b = source - source.mean(0), target - target.mean(0)
    rotation = Rotation.align_vectors(b, a)[0].as_matrix()
    scale = float((b * (a @ rotation.T)).sum() / (a**2).sum())
    return Similarity(scale, rotation, target.mean(0) - scale * rotation @ source.mean(0))


class Truth:
    """The exact sheet of a rendered scene."""

    def __init__(self, scene: Path) -> None:
        mesh = np.load(scene / "gt_mesh.npz")
        self.positions = mesh["xyz"].astype(float)
        self.flat = mesh["uv"].astype(float)
        about = json.loads((scene / "scene.json").read_text())
        self.width, self.height = about["page_mm"]
        self.cameras = {camera.name: camera for camera in map(_true_camera, about["photos"])}
        self._tree = cKDTree(self.positions.reshape(-1, 3))
        # Of one photo, for most pages of a scene come from the same.
        self.flat_in_photo = lru_cache(maxsize=1)(self._flat_in_photo)

    def _flat_in_photo(self, name: str) -> Array:
        """Flat position (h, w, 2) in mm of what each pixel of a photo shows; NaN where that is not the sheet.

        Where the sheet covers itself, it is the nearest part that counts.
        """
        camera = self.cameras[name]
        positions, triangles = self.positions.reshape(-1, 3), _grid_triangles(*self.positions.shape[:2])
        depth = camera.to_camera_frame(positions)[:, 2][triangles].mean(1)
        # Of several triangles over a pixel, the last one listed is taken.
        triangles = triangles[np.argsort(-depth)]
        lookup = rasterize(camera.project(positions), triangles, (camera.width, camera.height))
        return interpolate(lookup, triangles, self.flat.reshape(-1, 2))

    def nearest_vertex(self, points: Array) -> Array:
        return self.positions.reshape(-1, 3)[self._tree.query(points)[1]]

    def closest(self, points: Array) -> tuple[Array, Array, Array]:
        """Nearest points (N, 3) of the true surface, their flat positions (N, 2) and distances (N,)."""
        rows, columns = self.positions.shape[:2]
        row, column = np.divmod(self._tree.query(points)[1], columns)
        distance = np.full(len(points), np.inf)
        place, flat = np.zeros((len(points), 3)), np.zeros((len(points), 2))
        for up in (-1, 0):
            for left in (-1, 0):
                r, c = np.clip(row + up, 0, rows - 2), np.clip(column + left, 0, columns - 2)
                for corners in (((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1))):
                    where = [(r + dr, c + dc) for dr, dc in corners]
                    weights = _closest_in_triangle(points, *(self.positions[w] for w in where))
                    here = sum(weights[:, i, None] * self.positions[w] for i, w in enumerate(where))
                    away = np.linalg.norm(here - points, axis=1)
                    nearer = away < distance
                    distance[nearer], place[nearer] = away[nearer], here[nearer]
                    there = sum(weights[:, i, None] * self.flat[w] for i, w in enumerate(where))
                    flat[nearer] = there[nearer]
        return place, flat, distance


def _grid_triangles(rows: int, columns: int) -> NDArray[np.int64]:
    """Two triangles for each cell of a grid, (2 (rows - 1) (columns - 1), 3)."""
    node = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (part.ravel() for part in (node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]))
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def _true_camera(photo: dict[str, Any]) -> Camera:
    if photo["fx"] != photo["fy"]:
        raise ValueError(f"the true pixels of {photo['file']} are not square")
    return Camera(
        name=Path(photo["file"]).name,
        width=photo["width"],
        height=photo["height"],
        focal_length=photo["fx"],
        principal_point=np.array([photo["cx"], photo["cy"]]),
        distortion=np.array([photo["k1"], photo["k2"]]),
        rotation=np.array(photo["R"]),
        translation=np.array(photo["t_mm"]),
    )


def _closest_in_triangle(points: Array, a: Array, b: Array, c: Array) -> Array:
    """Barycentric weights (N, 3) of the point of each triangle nearest to ``points`` (N, 3)."""

    def on_edge(start: Array, end: Array) -> Array:
        way = end - start
        return np.clip(((points - start) * way).sum(1) / np.maximum((way**2).sum(1), 1e-18), 0, 1)

    ab, ac, ap = b - a, c - a, points - a
    g = np.stack([(ab * ab).sum(1), (ab * ac).sum(1), (ac * ac).sum(1), (ap * ab).sum(1), (ap * ac).sum(1)])
    size = np.maximum(g[0] * g[2] - g[1] ** 2, 1e-18)
    second, third = (g[2] * g[3] - g[1] * g[4]) / size, (g[0] * g[4] - g[1] * g[3]) / size
    inside = np.stack([1 - second - third, second, third], -1)
    t_ab, t_ac, t_bc = on_edge(a, b), on_edge(a, c), on_edge(b, c)
    none = np.zeros_like(t_ab)
    candidates = np.stack(
        [
            np.where((inside >= 0).all(1, keepdims=True), inside, np.nan),
            np.stack([1 - t_ab, t_ab, none], -1),
            np.stack([1 - t_ac, none, t_ac], -1),
            np.stack([none, 1 - t_bc, t_bc], -1),
        ]
    )
    places = candidates[..., :1] * a + candidates[..., 1:2] * b + candidates[..., 2:] * c
    best = np.nanargmin(np.linalg.norm(places - points, axis=2), axis=0)
    return candidates[best, np.arange(len(points))]


def align(truth: Truth, vertices: Array, names: Sequence[str], centres: Array) -> Similarity:
    """From the recovered world to the scene: by the cameras, then by the surface without its worst parts."""
    known = [i for i, name in enumerate(names) if Path(name).name in truth.cameras]
    if len(known) < 3:
        raise ValueError("fewer than three cameras bear the names of the scene's photos")
    fit = fit_similarity_in_space(centres[known], np.stack([truth.cameras[Path(names[i]).name].center for i in known]))
    some = vertices[np.random.default_rng(0).permutation(len(vertices))[:_ALIGN_VERTICES]]
    for step in range(_ALIGN_STEPS):
        moved = fit(some)
        near = truth.nearest_vertex(moved) if step < _ALIGN_STEPS - 10 else truth.closest(moved)[0]
        distance = np.linalg.norm(near - moved, axis=1)
        keep = distance <= max(np.percentile(distance, 85), 0.2)
        fit = fit_similarity_in_space(some[keep], near[keep])
    return fit


def score_surface(truth: Truth, vertices: Array, names: Sequence[str], centres: Array) -> dict[str, float]:
    """Distance of a surface (V, 3) to the true one, per cent of the page's height.

    ``outside`` is the share of vertices beyond the page, which do not count; ``coverage`` that of the page with one
    near it. ``names`` and ``centres`` (N, 3) are the recovered cameras.

    Raises
    ------
    ValueError
        If fewer than three of the cameras are the scene's.
    """
    moved = align(truth, vertices, names, centres)(vertices)
    _, flat, distance = truth.closest(moved)
    edge = np.minimum(flat, [truth.width, truth.height] - flat).min(1)
    outside = (edge < _EDGE_MM) & (distance > 0.004 * truth.height)
    surface = distance[~outside] * 100 / truth.height
    near = cKDTree(moved).query(truth.positions.reshape(-1, 3)[::23])[0] < 0.015 * truth.height
    return {
        "surface_rms": float(np.sqrt((surface**2).mean())),
        "surface_median": float(np.median(surface)),
        "surface_p95": float(np.percentile(surface, 95)),
        "outside": float(outside.mean()),
        "coverage": float(near.mean()),
    }
