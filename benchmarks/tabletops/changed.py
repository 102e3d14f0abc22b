"""A scene whose sheet was moved or bent between the photos."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from . import scene as scenes
from .raster import Layer
from .scene import Scene, hull
from .shapes import Facet, border, rest

CHANGES = ("moved", "bent")
# Sheets that are one chain of facets, of which all angles can be changed.
SHEETS = ("flat", "curled", "folded", "trifold", "receipt")
# Millimetres and degrees by which a sheet is moved, and degrees by which its steepest bend changes.
_SHIFT, _TURN, _BEND = (3.0, 30.0), (1.0, 5.0), (4.0, 14.0)
# Least and largest share of the photos that show the second state.
_SECOND = (0.3, 0.5)
# How dark the line is where the sheet touches the table.
_CONTACT = 0.4


@dataclass(frozen=True)
class Change:
    """The scene in its second state, and what was done to the sheet.

    Attributes
    ----------
    kind : str
        One of `CHANGES`.
    scene : Scene
    first_photo : int
        The first photo that shows the second state.
    shift : float
        Millimetres by which the sheet's middle moved.
    turn, bend : float
        Degrees by which it turned on the table, and by which the largest angle between two parts of it changed.
    """

    kind: str
    scene: Scene
    first_photo: int
    shift: float = 0.0
    turn: float = 0.0
    bend: float = 0.0

    def figures(self) -> dict[str, Any]:
        """For ``truth.json``, with the facets of the second state."""
        facets = [
            {"flat": f.flat.tolist(), "rotation": f.rotation.tolist(), "origin": f.origin.tolist()}
            for f in self.scene.sheet.facets
        ]
        own = ("kind", "first_photo", "shift", "turn", "bend")
        return {name: getattr(self, name) for name in own} | {"facets": facets}


def change(scene: Scene, kind: str) -> Change:
    """The scene in its second state, and how the sheet changed.

    Parameters
    ----------
    scene : Scene
        With a sheet of one of the kinds `SHEETS`.
    kind : str
        One of `CHANGES`.
    """
    random = np.random.default_rng([scene.seed, 11, CHANGES.index(kind)])
    facets = scene.sheet.facets
    first = len(scene.views) - max(2, round(random.uniform(*_SECOND) * len(scene.views)))
    if kind == "moved":
        shift, turn, way = random.uniform(*_SHIFT), random.uniform(*_TURN), random.uniform(0, 2 * np.pi)
        rotation = Rotation.from_euler("z", random.choice([-1, 1]) * turn, degrees=True).as_matrix()
        offset = shift * np.array([np.cos(way), np.sin(way), 0])
        moved = [facet.moved(rotation, offset) for facet in facets]
        return Change(kind, _with_sheet(scene, moved), first, shift=shift, turn=turn)
    bend, most = random.uniform(*_BEND), largest_bend(facets)
    factor = 1 - bend / most if most > 2 * bend else 1 + bend / most
    return Change(kind, _with_sheet(scene, rest(bent_by(facets, factor))), first, bend=bend)


def largest_bend(facets: Sequence[Facet]) -> float:
    """The largest angle in degrees between two facets."""
    normals = np.stack([facet.normal for facet in facets])
    return float(np.degrees(np.arccos(np.clip(normals @ normals.T, -1, 1).min())))


def bent_by(facets: Sequence[Facet], factor: float) -> list[Facet]:
    """A chain of facets with the angle at each hinge multiplied by ``factor``."""
    chain = [facets[0]]
    for before, after in pairwise(facets):
        turn = Rotation.from_matrix(before.rotation.T @ after.rotation).as_rotvec()
        rotation = chain[-1].rotation @ Rotation.from_rotvec(factor * turn).as_matrix()
        apart = np.linalg.norm(before.flat[:, None] - after.flat, axis=2).min(0)
        hinge = after.flat[apart.argmin()]
        origin = chain[-1].in_space(hinge) - rotation[:, :2] @ (hinge * [1, -1])
        chain.append(Facet(after.flat, rotation, origin))
    return chain


def _with_sheet(scene: Scene, facets: list[Facet]) -> Scene:
    """The scene with another sheet, and the light on all of it."""
    sheet, light, table = replace(scene.sheet, facets=facets), scene.light, scene.table
    edge = border(facets, sheet.width, sheet.height)
    beside = [layer for layer in scene.layers if layer.name not in ("sheet", "board", *scene.overlapping)]
    shading = [facet.corners for layer in beside for part in layer.parts for facet in part.facets]
    bright, bright_scale = light.on_sheet(facets, sheet.width, sheet.height, shading)
    layers = []
    for layer in scene.layers:
        if layer.name == "sheet":
            part = replace(layer.parts[0], facets=facets, light=bright, light_scale=bright_scale)
            layers.append(Layer("sheet", [part], hull(scenes.corners_of(facets)[:, :2])))
        elif layer.name == "board":
            board = Layer("board", [replace(part) for part in layer.parts], layer.ground)
            scenes._light_on_board(board, light, [facet.corners for facet in facets] + shading, edge)
            layers.append(board)
        else:
            layers.append(layer)
    casters = [facet.corners for layer in layers for part in layer.parts for facet in part.facets]
    size = len(table.light)
    scale = table.scale * size / len(table.picture)
    lit = light.on_plane(casters, table.corner, table.axes, size, scale)
    if scene.table_kind != "board":
        scenes._contact(lit, edge, table.corner, table.axes, scale, _CONTACT)
    return replace(scene, sheet=sheet, layers=layers, edge=edge, table=replace(table, light=lit))
