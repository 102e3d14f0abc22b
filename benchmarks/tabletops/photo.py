"""One photo of a scene: table and layers painted, the photographer's hand and shadow, lens, sensor and JPEG."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .cameras import View
from .clutter import linear
from .raster import FINE, TO_LINEAR, Cover, Linear, in_order, paint
from .scene import Scene
from .shapes import Array, Random

# How far below the table the floor is, mm.
_FLOOR = 700.0
# Every this many pixels gloss and shadows are computed.
_COARSE = 16


@dataclass(frozen=True)
class Photo:
    """Pixels (h, w, 3) uint8, the sheet's visible edge (K, 2), and what covers some of it."""

    pixels: NDArray[np.uint8]
    outline: Array
    hand_on_sheet: bool


def take(scene: Scene, index: int) -> Photo:
    """The photo of a view of the scene."""
    random = np.random.default_rng([scene.seed, 3, index])
    view = scene.views[index]
    rays = view.rays()
    photo = _ground(scene, view, rays)
    outline = view.project(scene.edge)
    for layer in in_order(scene.layers, view):
        cover = paint(photo, layer, view, rays)
        if layer.name == "sheet" and cover is not None:
            outline = visible_edge(outline, cover)
    _shine(photo, scene, view)
    whole = np.random.default_rng([scene.seed, 4])
    shadows, hands = whole.random() < 0.3, whole.random() < 0.2
    if shadows and random.random() < 0.6:
        _shadow(photo, scene, view, random)
    on_sheet = False
    if hands and random.random() < 0.5:
        on_sheet = _hand(photo, scene, view, random, outline)
    return Photo(_develop(photo, scene, index, view), outline, on_sheet)


def visible_edge(edge: Array, cover: Cover) -> Array:
    """The sheet's edge (K, 2) as projected; its silhouette where a part of the sheet hides some of that edge."""
    fine_edge = (edge - [cover.left, cover.top]) * FINE - 0.5
    mask = np.zeros_like(cover.first)
    cv2.fillPoly(mask, [np.round(fine_edge * 16).astype(np.int32)], 255, cv2.LINE_8, 4)
    differs = cv2.morphologyEx(mask ^ cover.first, cv2.MORPH_OPEN, np.ones((7, 7), np.uint8))
    if not differs.any():
        return edge
    contours, _ = cv2.findContours(cover.first, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    longest = max(contours, key=cv2.contourArea)[:, 0].astype(float)
    return (longest[::4] + 0.5) / FINE + [cover.left, cover.top]


def _plane(view: View, corner: Array, axes: Array, rays: tuple[Linear, Linear]) -> tuple[Linear, Linear, Linear]:
    """Where rays meet a level plane, mm along its axes, and whether they do (> 0)."""
    to_camera = np.column_stack(
        [
            view.rotation[:, :2] @ axes[0],
            view.rotation[:, :2] @ axes[1],
            view.rotation @ corner + view.translation,
        ]
    )
    inverse = np.linalg.inv(to_camera).astype(np.float32)
    x, y = rays
    w = inverse[2, 0] * x + inverse[2, 1] * y + inverse[2, 2]
    ahead = np.where(w * np.sign(np.linalg.det(to_camera)) != 0, w, np.float32(1e-9))
    a = (inverse[0, 0] * x + inverse[0, 1] * y + inverse[0, 2]) / ahead
    b = (inverse[1, 0] * x + inverse[1, 1] * y + inverse[1, 2]) / ahead
    # w is the reciprocal of the depth.
    return a, b, w


def _ground(scene: Scene, view: View, rays: tuple[Linear, Linear]) -> Linear:
    """The table, and the floor beyond its edge."""
    table = scene.table
    a, b, depth = _plane(view, table.corner, table.axes, rays)
    picture, scale = table.picture, np.float32(table.scale)
    bright_scale = np.float32(table.scale * table.light.shape[0] / picture.shape[0])
    colour = TO_LINEAR[
        cv2.remap(picture, a * scale - 0.5, b * scale - 0.5, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    ]
    bright = cv2.remap(
        table.light, a * bright_scale - 0.5, b * bright_scale - 0.5, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    photo = colour * bright[..., None]
    extent = np.float32(picture.shape[0] / table.scale)
    inside = np.minimum(np.minimum(a, extent - a), np.minimum(b, extent - b))
    if inside.min() < 0 or depth.min() <= 0:
        pixel = np.maximum(np.abs(np.gradient(inside, axis=0)) + np.abs(np.gradient(inside, axis=1)), 1e-3)
        share = np.clip(inside / pixel + 0.5, 0, 1) * (depth > 0)
        below = table.corner - np.array([0, 0, _FLOOR])
        a, b, depth = _plane(view, below, table.axes, rays)
        size = scene.table.floor.shape[0]
        x, y = (np.clip(v * np.float32(0.12) + size / 4, -1e4, 1e4) for v in (a, b))
        floor = TO_LINEAR[cv2.remap(table.floor, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)] * 0.6
        photo = photo * share[..., None] + np.where(depth > 0, share * 0 + 1, 0.5)[..., None] * floor * (
            1 - share[..., None]
        )
    return np.ascontiguousarray(photo, np.float32)


def _coarse_points(view: View, level: float) -> tuple[Array, Array]:
    """Places on the plane at ``level`` that every `_COARSE`-th pixel sees, and whether it does."""
    across, down = np.arange(0, view.width + _COARSE, _COARSE), np.arange(0, view.height + _COARSE, _COARSE)
    rays = np.concatenate(
        [view.undistort(np.stack(np.meshgrid(across, down), -1) + 0.5), np.ones((len(down), len(across), 1))], -1
    )
    way = rays @ view.rotation
    falls = way[..., 2] < -0.05
    depth = (level - view.centre[2]) / np.where(falls, way[..., 2], -1)
    return view.centre + depth[..., None] * way, falls


def _spread(coarse: Array, view: View) -> Linear:
    x, y = np.meshgrid(
        np.arange(view.width, dtype=np.float32) / _COARSE, np.arange(view.height, dtype=np.float32) / _COARSE
    )
    return cv2.remap(coarse.astype(np.float32), x, y, cv2.INTER_LINEAR)


def _shine(photo: Linear, scene: Scene, view: View) -> None:
    """The lamp's broad gloss on the table and, weaker, on all that lies on it."""
    places, falls = _coarse_points(view, 0.0)
    toward = view.centre - places
    toward /= np.linalg.norm(toward, axis=-1, keepdims=True)
    lamp = scene.light.lamp * scene.light.distance - places
    lamp /= np.linalg.norm(lamp, axis=-1, keepdims=True)
    half = toward + lamp
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    gloss = scene.table.gloss * np.maximum(half[..., 2], 0) ** 60 * falls
    photo += _spread(gloss, view)[..., None]


def _shadow(photo: Linear, scene: Scene, view: View, random: Random) -> None:
    """The photographer's soft shadow on table and sheet."""
    places, falls = _coarse_points(view, 0.0)
    reach = np.ptp(scene.edge, axis=0)[:2].max()
    angle = random.uniform(0, 2 * np.pi)
    way = np.array([np.cos(angle), np.sin(angle)])
    centre = scene.edge.mean(0)[:2] + reach * random.uniform(0.35, 0.8) * way
    offset = places[..., :2] - centre
    along, across = offset @ way, offset @ np.array([-way[1], way[0]])
    size = reach * random.uniform(0.25, 0.5)
    # A head, and shoulders that widen away from the sheet.
    edge = np.minimum(
        np.hypot(along, across * 1.2) - size * 0.6, np.abs(across) - 0.4 * size - 0.6 * np.maximum(along, 0)
    )
    edge = np.where(along > -0.2 * size, edge, np.hypot(along, across * 1.2) - size * 0.6)
    soft = reach * random.uniform(0.02, 0.12)
    dark = random.uniform(0.15, 0.4) / (1 + np.exp(np.clip(edge / soft, -30, 30))) * falls
    photo *= 1 - _spread(dark, view)[..., None]


def _hand(photo: Linear, scene: Scene, view: View, random: Random, outline: Array) -> bool:
    """A hand from beyond the photo's border beside the sheet, at times on its edge; whether it covers some of it."""
    reach = np.ptp(scene.edge, axis=0)[:2].max()
    middle = scene.edge.mean(0)
    place = scene.edge[random.integers(len(scene.edge))]
    outward = place[:2] - middle[:2]
    outward /= np.linalg.norm(outward)
    on_edge = random.random() < 0.3
    tip = place[:2] + outward * (-12.0 if on_edge else random.uniform(15, 60))
    turn = random.uniform(-0.5, 0.5)
    away = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ outward
    side = np.array([-away[1], away[0]])
    lift = place[2] + 12.0
    knuckles = tip + away * 75
    bones = []
    for finger, length in enumerate([62, 75, 70, 52]):
        base = knuckles + side * (finger - 1.5) * 19
        end = base - away * length + side * (finger - 1.5) * random.uniform(0, 6)
        if on_edge and finger in (0, 3):
            end = base - away * length * 0.5
        bones.append((base, end, 8.5))
    bones.append((knuckles + away * 45 - side * 30, knuckles - away * 5 - side * 62, 10.0))
    bones += [(knuckles + side * s, knuckles + away * 75 + side * s * 0.7, 17.0) for s in (-26, -10, 10, 26)]
    bones.append((knuckles + away * 60, knuckles + away * (90 + reach * 3), 31.0))
    mask = np.zeros(photo.shape[:2], np.uint8)
    shade = np.zeros(photo.shape[:2], np.float32)
    for start, end, radius in bones:
        ends = view.project(np.array([[*start, lift + radius], [*end, lift + radius * 0.6]]))
        depth = view.focal_length / max((np.array([*start, lift]) @ view.rotation.T + view.translation)[2], 60.0)
        wide = max(2, round(2 * radius * depth))
        bone = np.zeros_like(mask)
        one, two = (tuple(np.clip(p, -20000, 20000).astype(int).tolist()) for p in ends)
        cv2.line(bone, one, two, 255, wide, cv2.LINE_AA)
        inside = cv2.distanceTransform((bone > 127).astype(np.uint8), cv2.DIST_L2, 3) / (wide / 2)
        shade = np.maximum(
            shade, 0.45 + 0.55 * np.sqrt(np.clip(1 - (1 - np.minimum(inside, 1)) ** 2, 0, 1)) * (bone > 0)
        )
        mask = np.maximum(mask, bone)
    if not mask.any():
        return False
    dark = cv2.GaussianBlur(mask, (0, 0), 14).astype(np.float32) / 255
    shift = np.float32([[1, 0, random.uniform(-18, 18)], [0, 1, random.uniform(-18, 18)]])
    photo *= 1 - 0.45 * cv2.warpAffine(dark, shift, (view.width, view.height))[..., None]
    skin = linear(
        np.array(
            [[222, 172, 144], [190, 132, 100], [122, 80, 58], [236, 190, 168]][
                np.random.default_rng(scene.seed).integers(4)
            ]
        )
    )
    cover = cv2.GaussianBlur(mask, (0, 0), 0.8).astype(np.float32)[..., None] / 255
    colour = cv2.GaussianBlur(shade, (0, 0), 2.5)[..., None] * skin.astype(np.float32)
    photo[:] = photo * (1 - cover) + colour * cover
    sheet = np.zeros_like(mask)
    cv2.fillPoly(sheet, [np.round(np.clip(outline, -5000, 5000)).astype(np.int32)], 255)
    return bool(((mask > 127) & (sheet > 0)).any())


@dataclass(frozen=True)
class Camera:
    """The camera of a scene's photos; ``blurred`` are the views out of focus or shaken."""

    noise: float
    blur: float
    vignette: float
    tint: Array
    exposure: float
    blurred: NDArray[np.int64]


def camera_of(scene: Scene) -> Camera:
    """The camera that a scene's photos were taken with."""
    random = np.random.default_rng([scene.seed, 5])
    noise, blur, vignette = random.uniform(0.8, 3.0), random.uniform(0.5, 0.85), random.uniform(0.05, 0.3)
    tint = random.uniform([0.95, 0.97, 0.9], [1.08, 1.03, 1.08])
    exposure = random.uniform(0.78, 1.0)
    views = random.permutation(len(scene.views))
    return Camera(noise, blur, vignette, tint, exposure, views[: int(random.choice([0, 1, 2], p=[0.5, 0.35, 0.15]))])


def _develop(photo: Linear, scene: Scene, index: int, view: View) -> NDArray[np.uint8]:
    """Exposure, lens and sensor."""
    camera = camera_of(scene)
    random = np.random.default_rng([scene.seed, 6, index])
    if index in camera.blurred:
        if random.random() < 0.5:
            photo = cv2.GaussianBlur(photo, (0, 0), random.uniform(1.6, 2.6))
        else:
            photo = cv2.filter2D(photo, -1, _motion(random.uniform(4, 9), random.uniform(0, np.pi)))
    photo = cv2.GaussianBlur(photo, (0, 0), camera.blur)
    y = (np.arange(view.height, dtype=np.float32)[:, None] + 0.5) / view.height * 2 - 1
    x = (np.arange(view.width, dtype=np.float32)[None] + 0.5) / view.width * 2 - 1
    dim = 1 - np.float32(camera.vignette / 2) * (x * x + y * y)
    gain = camera.exposure * random.uniform(0.92, 1.08) * camera.tint * random.uniform(0.985, 1.015, 3)
    photo = photo * dim[..., None] * gain.astype(np.float32)
    # A shoulder instead of hard clipping, then sRGB, by a table of 4096 steps.
    level = np.arange(4096) / 2048
    level = np.where(level > 0.8, 0.8 + 0.2 * (1 - np.exp(-(level - 0.8) / 0.2)), level)
    encoded = np.where(level <= 0.0031308, 12.92 * level, 1.055 * np.maximum(level, 1e-9) ** (1 / 2.4) - 0.055)
    table = (255 * encoded).astype(np.float32)
    image = table[np.clip(photo * 2048, 0, 4095).astype(np.uint16)]
    grain = random.standard_normal(image.shape, dtype=np.float32)
    image += np.float32(camera.noise) * cv2.GaussianBlur(grain, (0, 0), 0.5)
    soft = cv2.GaussianBlur(image, (0, 0), 1.2)
    image = cv2.addWeighted(image, 1.3, soft, -0.3, 0)
    return np.clip(image + 0.5, 0, 255).astype(np.uint8)


def _motion(length: float, angle: float) -> Linear:
    """A kernel as of a camera that moved by ``length`` pixels."""
    size = int(np.ceil(length)) | 1
    kernel = np.zeros((size + 2, size + 2), np.float32)
    middle = (size + 1) / 2
    reach = np.array([np.cos(angle), np.sin(angle)]) * length / 2
    ends = [tuple(np.round((middle + sign * reach) * 16).astype(int).tolist()) for sign in (-1, 1)]
    cv2.line(kernel, ends[0], ends[1], 1.0, 1, cv2.LINE_AA, 4)
    return kernel / kernel.sum()
