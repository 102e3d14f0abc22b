"""A small folded sheet with two cameras and their photos, for tests of conversion to and from Blender."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType

import numpy as np
import pytest
from origami.core.camera import Camera
from origami.core.page.texture import PageTexture
from origami.core.paper.outline import Outline
from origami.core.sheet import FlatMap, Sheet
from origami.core.sparse_model import SparseModel
from origami.origami_addon.stages import STAGES
from origami.origami_addon.state import LaidOut, Page, Region

ROWS, COLUMNS = 30, 24
WORLD_SCALE = 40.0  # millimetres per world unit
WIDTH_MM, HEIGHT_MM = 160.0, 200.0
# The functions in `origami_addon.steps` that do the work of each stage.
STEPS = dict(
    zip(
        STAGES,
        ("place_photos", "find_sheet", "build_surface", "unwrap_sheet", "lay_out_page", "make_page"),
        strict=True,
    )
)


@dataclass(frozen=True)
class Folded:
    """A sheet folded along its middle row, in a turned and shifted frame of arbitrary scale."""

    sheet: Sheet
    flat: FlatMap
    model: SparseModel
    photos: list[np.ndarray]

    @property
    def state(self) -> LaidOut:
        """The same as the state of a document; the outline is the photo's middle."""
        camera = self.model.cameras[0]
        corners = np.array([[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]]) * (camera.width, camera.height)
        region = Region(0, Outline(corners, 1.0, ()), np.ones(len(self.model.points), bool))
        return LaidOut(self.model, region, self.model.cameras, self.sheet, self.flat.uv, self.flat)


def folded_sheet(fold: float = 0.5) -> Folded:
    u, v = np.meshgrid(np.linspace(0, WIDTH_MM, COLUMNS + 1), np.linspace(0, HEIGHT_MM, ROWS + 1))
    x, along = u - WIDTH_MM / 2, HEIGHT_MM / 2 - v
    on_page = np.stack([x, along * np.cos(fold), np.abs(along) * np.sin(fold)], -1).reshape(-1, 3)
    index = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    boundary = np.concatenate([index[3:-1, 0], index[-1, :-1], index[:0:-1, -1], index[0, :0:-1], index[:3, 0]])
    ridges = (index[ROWS // 2], index[::-1, COLUMNS // 3])

    turn, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    shift = np.array([3.0, -1.0, 0.5])

    def to_world(points: np.ndarray) -> np.ndarray:
        return points @ turn.T / WORLD_SCALE + shift

    sheet = Sheet(to_world(on_page), triangles, ridges, boundary)
    flat = FlatMap(np.stack([u, v], -1).reshape(-1, 2), WIDTH_MM, HEIGHT_MM, "mm", WORLD_SCALE)
    cameras = []
    for number, tilt in enumerate((0.15, -0.3)):
        cosine, sine = np.cos(tilt), np.sin(tilt)
        rotation = np.array([[1, 0, 0], [0, -cosine, -sine], [0, sine, -cosine]]) @ turn.T
        cameras.append(
            Camera(
                f"Foto ü {number}.jpg",
                600,
                720,
                900.0,
                np.array([310.0, 352.0]),
                np.array([-0.04, 0.01]),
                rotation,
                np.array([0, 0, 360 / WORLD_SCALE]) - rotation @ shift,
            )
        )
    rng = np.random.default_rng(2)
    coarse = rng.uniform(40, 230, (720 // 6, 600 // 6, 3))
    photos = [_enlarged(coarse), _enlarged(coarse[::-1])]
    model = SparseModel(
        tuple(cameras),
        sheet.vertices[::7],
        np.full((len(sheet.vertices[::7]), 3), (200, 100, 50), np.uint8),
        np.zeros(0, np.int64),
        np.zeros(0, np.int64),
        np.zeros((0, 2)),
    )
    return Folded(sheet, flat, model, photos)


def _enlarged(coarse: np.ndarray) -> np.ndarray:
    """Six times as large, linear between."""
    for axis in (0, 1):
        at = (np.arange(6 * coarse.shape[axis]) + 0.5) / 6 - 0.5
        low = np.clip(np.floor(at).astype(int), 0, coarse.shape[axis] - 2)
        part = np.clip(at - low, 0, 1).reshape((-1, 1, 1) if axis == 0 else (1, -1, 1))
        coarse = np.take(coarse, low, axis) * (1 - part) + np.take(coarse, low + 1, axis) * part
    return np.rint(coarse).astype(np.uint8)


def stand_in_for_steps(monkeypatch: pytest.MonkeyPatch, steps: ModuleType) -> None:
    """Make the steps after the first return this sheet at once, and write nothing."""
    case = folded_sheet()
    found = {
        "find_sheet": case.state.region,
        "build_surface": (case.model.cameras, case.sheet),
        "unwrap_sheet": case.flat.uv,
        "lay_out_page": case.flat,
        "make_page": white_page(),
        "write_results": None,
    }
    for name, result in found.items():
        monkeypatch.setattr(steps, name, lambda *_, result=result, **__: result)


def white_page() -> Page:
    """A page of a few pixels with nothing on it, from the first photo."""
    shape = (5, 4)
    texture = PageTexture(
        np.full((*shape, 3), 255, np.uint8), np.zeros(shape, np.int16), np.zeros((*shape, 2), np.float32), 0.0
    )
    return Page(texture, 100.0, texture.image)
