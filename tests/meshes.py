"""Meshes as in modelling programs: faces with corners, tubes, balls."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np


def quads(
    across: int, up: int, place: Callable[[np.ndarray, np.ndarray], np.ndarray], *, around: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """A grid of ``across`` x ``up`` vertices (V, 3) and its quads (Q, 4), row by row from the lower left.

    ``place(u, v)`` maps grid coordinates from 0 to 1 to points; ``around`` joins the last column to the first.
    """
    index = np.arange(across * up).reshape(up, across)
    if around:
        index = np.hstack([index, index[:, :1]])
    faces = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1).reshape(-1, 4)
    u, v = np.meshgrid(np.arange(across) / (across if around else across - 1), np.linspace(0, 1, up))
    return place(u.ravel(), v.ravel()), faces


def corners(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The vertex of each face corner (L,), and the faces (Q, K) as triangles of corners (F, 3)."""
    corner = np.arange(faces.size).reshape(faces.shape)
    fans = [corner[:, [0, k, k + 1]] for k in range(1, faces.shape[1] - 1)]
    return faces.ravel(), np.concatenate(fans)


def label() -> tuple[np.ndarray, np.ndarray]:
    """A label of 2 x 1.3 around part of a bottle, seen from outside."""
    return quads(41, 27, lambda u, v: np.stack([np.cos(2 * u), np.sin(2 * u), 1.3 * v], -1))


def tube(columns: int = 64, rows: int = 17, height: float = 2.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """An open tube of radius 1 and a seam (E, 2) along it."""
    vertices, faces = quads(
        columns,
        rows,
        lambda u, v: np.stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), height * v], -1),
        around=True,
    )
    first = np.arange(rows) * columns
    return vertices, faces, np.stack([first[:-1], first[1:]], -1)


def ensure_pins(layer) -> None:
    """Give one of Blender's UV maps room for pins; before Blender 5.0 it has it from the first look. Moves the maps."""
    if hasattr(layer, "pin_ensure"):
        layer.pin_ensure()
