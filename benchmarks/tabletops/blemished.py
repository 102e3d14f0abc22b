"""A scene's photos, spoilt by a lamp's reflection, the photographer's shadow, a hand or motion."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from . import photo as photos
from .cameras import View
from .raster import Linear, in_order, paint, see
from .scene import Scene
from .shapes import Array, Random, in_space

Spoil = Callable[[Linear], Linear]

KINDS = ("glare", "gloss", "shadow", "hand", "pale hand", "motion")
# Exponent of the reflection's lobe and its light in paper's: coated paper, that burns out, and a sheen, that does not.
_COATED, _SHEEN = ((150.0, 1500.0), (0.8, 4.0)), ((15.0, 60.0), (0.05, 0.25))
_LAMP_DISTANCE = 1500.0
# Linear light of skin of three tones, and of what is hardly darker than paper: a pale hand in bright light, a cuff.
_SKIN = np.float32([[0.73, 0.41, 0.28], [0.2, 0.08, 0.05], [0.5, 0.22, 0.12]])
_PALE = np.float32([0.7, 0.62, 0.56])
# Share of the light that a passing shadow takes.
_SHADE = (0.2, 0.6)


def painted(scene: Scene, index: int) -> Linear:
    """The photo of a view in linear light, before the lens, with nothing passing in front of it."""
    view = scene.views[index]
    rays = view.rays()
    picture = photos._ground(scene, view, rays)
    for layer in in_order(scene.layers, view):
        paint(picture, layer, view, rays)
    photos._shine(picture, scene, view)
    return picture


def sharp(scene: Scene) -> NDArray[np.int64]:
    """The views that the generator has not blurred at random."""
    return np.setdiff1d(np.arange(len(scene.views)), photos.camera_of(scene).blurred)


def developed(scene: Scene, index: int, picture: Linear) -> NDArray[np.uint8]:
    """The photo as the sensor and JPEG record it."""
    pixels = photos._develop(picture, scene, index, scene.views[index])
    _, stored = cv2.imencode(".jpg", pixels[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 92])
    return np.ascontiguousarray(cv2.imdecode(stored, cv2.IMREAD_COLOR)[..., ::-1])


def spoil(kind: str, scene: Scene, aimed_at: int, random: Random) -> Callable[[Linear, int], Linear]:
    """How a blemish spoils a view: a function of its painted picture and its index.

    Parameters
    ----------
    kind : str
        One of `KINDS`. Glare and gloss come from one lamp, placed so that the view ``aimed_at`` has the reflection on
        the sheet; in the others it is elsewhere. All else is random for each view.
    """
    if kind in ("glare", "gloss"):
        exponent, strength = _COATED if kind == "glare" else _SHEEN
        power, light = np.exp(random.uniform(*np.log(exponent))), random.uniform(*strength)
        lamp = _lamp(scene, aimed_at, random)
        return lambda picture, index: picture + np.float32(light) * _lobe(scene, scene.views[index], lamp, power)
    seed = int(random.integers(2**31))

    def passing(picture: Linear, index: int) -> Linear:
        own = np.random.default_rng([seed, index])
        if kind == "shadow":
            return picture * _shade(scene, scene.views[index], own)
        if kind == "motion":
            return _moved(picture, own)
        return _hand(picture, scene, scene.views[index], own, pale=kind == "pale hand")

    return passing


def _place(scene: Scene, random: Random) -> tuple[Array, Array]:
    """A place on the sheet, away from its edge, and the sheet's normal there."""
    sheet = scene.sheet
    flat = np.array([[sheet.width, sheet.height]]) * random.uniform(0.2, 0.8, 2)
    point = in_space(sheet.facets, flat)[0]
    off = [abs((point - facet.origin) @ facet.normal) + _outside(facet.flat, flat[0]) for facet in sheet.facets]
    return point, sheet.facets[int(np.argmin(off))].normal


def _outside(polygon: Array, point: Array) -> float:
    return max(0.0, -float(cv2.pointPolygonTest(polygon.astype(np.float32), tuple(map(float, point)), True)))


def _lamp(scene: Scene, index: int, random: Random) -> Array:
    point, normal = _place(scene, random)
    toward = scene.views[index].centre - point
    toward /= np.linalg.norm(toward)
    return point + _LAMP_DISTANCE * (2 * (toward @ normal) * normal - toward)


def _lobe(scene: Scene, view: View, lamp: Array, power: float) -> Linear:
    """Light that the sheet reflects towards the camera (h, w, 1)."""
    places, _ = photos._coarse_points(view, float(scene.edge[:, 2].mean()))
    half = sum((end - places) / np.linalg.norm(end - places, axis=-1, keepdims=True) for end in (view.centre, lamp))
    half = photos._spread((half / np.linalg.norm(half, axis=-1, keepdims=True)).astype(np.float32), view)
    shine = np.zeros((view.height, view.width, 1), np.float32)
    for layer in scene.layers:
        seen = see(layer, view) if layer.name == "sheet" else None
        if seen is not None:
            cover, label = seen
            rows, columns = slice(cover.top, cover.top + len(label)), slice(cover.left, cover.left + label.shape[1])
            normal = np.vstack([np.zeros(3), layer.normals]).astype(np.float32)
            # A curled sheet is made of plane strips: its reflection must not show them.
            smooth = cv2.GaussianBlur(normal[label], (0, 0), 4)
            smooth /= np.maximum(np.linalg.norm(smooth, axis=-1, keepdims=True), 1e-6)
            cosine = (half[rows, columns] * smooth).sum(-1).clip(0)
            shine[rows, columns, 0] += cover.share * np.exp(power * np.log(np.maximum(cosine, 1e-6)))
    return shine


def _shade(scene: Scene, view: View, random: Random) -> Linear:
    """What is left of the light in a shadow with a soft edge that reaches into the sheet."""
    places, _ = photos._coarse_points(view, 0.0)
    reach = np.ptp(scene.edge, axis=0)[:2].max()
    point, _ = _place(scene, random)
    away = random.uniform(0, 2 * np.pi)
    way = np.array([np.cos(away), np.sin(away)])
    offset = places[..., :2] - point[:2]
    along, across = offset @ way, offset @ [-way[1], way[0]]
    size = reach * random.uniform(0.1, 0.25)
    edge = np.where(along > 0, np.abs(across) - size, np.hypot(along, across) - size)
    soft = reach * random.uniform(0.005, 0.04)
    dark = random.uniform(*_SHADE) / (1 + np.exp(np.clip(edge / soft, -30, 30)))
    return 1 - photos._spread(dark.astype(np.float32), view)[..., None]


def _hand(picture: Linear, scene: Scene, view: View, random: Random, pale: bool) -> Linear:
    """A forearm or a finger that reaches from the photo's border onto the sheet, with its shadow."""
    point, _ = _place(scene, random)
    centre = scene.edge.mean(0)
    way = (point - centre) / max(np.linalg.norm((point - centre)[:2]), 1e-6) * [1, 1, 0]
    reach = np.ptp(scene.edge, axis=0)[:2].max()
    ends = view.project(np.array([point, point + 3 * reach * way]))
    pixels = view.focal_length / np.linalg.norm(view.centre - point)
    wide = max(2, round(random.uniform(16, 60) * pixels))
    mask = np.zeros(picture.shape[:2], np.uint8)
    start, end = (tuple(np.clip(place, -20000, 20000).astype(int).tolist()) for place in ends)
    cv2.line(mask, start, end, 255, wide, cv2.LINE_AA)
    shadow = cv2.GaussianBlur(mask, (0, 0), 12).astype(np.float32) / 255
    cover = cv2.GaussianBlur(mask, (0, 0), 0.8).astype(np.float32)[..., None] / 255
    skin = _PALE if pale else _SKIN[random.integers(3)]
    return picture * (1 - 0.45 * shadow[..., None]) * (1 - cover) + skin * cover


def _moved(picture: Linear, random: Random) -> Linear:
    """Motion about a far corner: one side of the photo stays sharp."""
    kernel = photos._motion(random.uniform(7, 14), random.uniform(0, np.pi))
    height, width = picture.shape[:2]
    angle = random.uniform(0, 2 * np.pi)
    y, x = np.mgrid[-0.5 : 0.5 : height * 1j, -0.5 : 0.5 : width * 1j].astype(np.float32)
    share = np.clip(0.5 + 4 * (x * np.cos(angle) + y * np.sin(angle)), 0, 1)[..., None].astype(np.float32)
    return picture * (1 - share) + cv2.filter2D(picture, -1, kernel) * share
