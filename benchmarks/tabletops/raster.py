"""Photos of plane facets: which facet each pixel sees, where on it, and how much of the pixel is covered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from .cameras import View
from .shapes import Array, Facet, clip

Linear = NDArray[np.float32]

# Sub-pixels along each side of a pixel from which its coverage is counted.
FINE = 4
# Facets are cut into cells of at most this many millimetres, so that lens distortion bends their edges too, and so that
# painting the farther ones first hides what is hidden.
_CELL = 40.0
_NEAR = 40.0
_REMAP_WIDTH = 4096
# Texture pixels per photo pixel above which a texture is reduced first.
_MOST_MINIFIED = 1.3


def _linear_table() -> Linear:
    value = np.arange(256) / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).astype(np.float32)


TO_LINEAR = _linear_table()


@dataclass(eq=False)
class Part:
    """Facets of one look.

    Attributes
    ----------
    facets : list of Facet
    picture : (h, w, 3) uint8 array or None
        What is printed on them over their flat coordinates, ``scale`` pixels per millimetre; else ``colours``.
    light : (h, w) float32 array
        Over the same coordinates, ``light_scale`` pixels per millimetre.
    colours : (F, 3) array
        Linear colours, the light included, of facets without a picture.
    back : (3,) array or None
        Linear colour of the facets from behind; None for those of a solid, which nobody sees from behind.
    """

    facets: list[Facet]
    picture: NDArray[np.uint8] | None = None
    scale: float = 1.0
    light: Linear | None = None
    light_scale: float = 1.0
    colours: Array = field(default_factory=lambda: np.zeros((0, 3)))
    back: Array | None = None


@dataclass(eq=False)
class Layer:
    """What is painted as one: its parts, cut into cells, and the convex ground (K, 2) that it stands on."""

    name: str
    parts: list[Part]
    ground: Array

    def __post_init__(self) -> None:
        self.cells = [
            (number, index, cell)
            for number, part in enumerate(self.parts)
            for index, facet in enumerate(part.facets)
            for cell in cut(facet)
        ]
        self.corners = np.concatenate([cell.corners for _, _, cell in self.cells])
        self.ends = np.cumsum([len(cell.flat) for _, _, cell in self.cells])
        self.centres = np.stack([cell.corners.mean(0) for _, _, cell in self.cells])
        self.normals = np.stack([cell.normal for _, _, cell in self.cells])


def cut(facet: Facet) -> list[Facet]:
    """The facet in pieces of at most `_CELL` mm along u and v."""
    pieces = [facet.flat]
    for axis in (0, 1):
        direction = np.array([0.0, 1.0]) if axis == 0 else np.array([1.0, 0.0])
        low, high = facet.flat[:, axis].min(), facet.flat[:, axis].max()
        count = int(np.ceil((high - low) / _CELL))
        for line in low + (high - low) * np.arange(1, count) / count:
            point = np.full(2, line)
            pieces = [
                part for piece in pieces for part in (clip(piece, point, direction), clip(piece, point, -direction))
            ]
            pieces = [piece for piece in pieces if len(piece) >= 3]
    return [Facet(piece, facet.rotation, facet.origin) for piece in pieces]


@dataclass(frozen=True)
class Cover:
    """Where a layer covers a window of the photo, in sub-pixels, and where its first part is what is seen of it."""

    left: int
    top: int
    fine: NDArray[np.uint8]
    first: NDArray[np.uint8]

    @property
    def share(self) -> Linear:
        shape = (self.fine.shape[1] // FINE, self.fine.shape[0] // FINE)
        return cv2.resize(self.fine, shape, interpolation=cv2.INTER_AREA).astype(np.float32) / 255


def see(layer: Layer, view: View) -> tuple[Cover, NDArray[np.int32]] | None:
    """The layer's cover, and one plus the number of the cell that each pixel of its window sees; None where unseen."""
    in_camera = layer.corners @ view.rotation.T + view.translation
    depth = np.minimum.reduceat(in_camera[:, 2], np.r_[0, layer.ends[:-1]])
    pixels = view.project(layer.corners)
    low = np.maximum(np.floor(pixels.min(0)).astype(int) - 2, 0)
    high = np.minimum(np.ceil(pixels.max(0)).astype(int) + 2, [view.width, view.height])
    if (high <= low).any():
        return None
    away = view.centre - layer.centres
    front = (away * layer.normals).sum(1) > 0
    hollow = np.array([layer.parts[number].back is not None for number, _, _ in layer.cells])
    size = high - low
    fine = np.zeros((size[1] * FINE, size[0] * FINE), np.uint8)
    first = fine if len(layer.parts) == 1 else np.zeros_like(fine)
    label = np.zeros((size[1], size[0]), np.int32)
    # OpenCV has a pixel's centre at whole numbers, with sixteenths as the last four bits.
    at_pixels = np.round((pixels - low - 0.5) * 16).astype(np.int32)
    at_fine = np.round(((pixels - low) * FINE - 0.5) * 16).astype(np.int32)
    starts = np.r_[0, layer.ends[:-1]]
    for index in np.argsort(-(away**2).sum(1)):
        if depth[index] < _NEAR or not (front[index] or hollow[index]):
            continue
        part = slice(starts[index], layer.ends[index])
        cv2.fillConvexPoly(label, at_pixels[part], int(index) + 1, cv2.LINE_8, 4)
        cv2.fillConvexPoly(fine, at_fine[part], 255, cv2.LINE_8, 4)
        if first is not fine:
            cv2.fillConvexPoly(first, at_fine[part], 0 if layer.cells[index][0] else 255, cv2.LINE_8, 4)
    return Cover(int(low[0]), int(low[1]), fine, first), label


def paint(photo: Linear, layer: Layer, view: View, rays: tuple[Linear, Linear]) -> Cover | None:
    """Paint the layer over a linear photo (h, w, 3) in place; its cover."""
    seen = see(layer, view)
    if seen is None:
        return None
    cover, label = seen
    share = cover.share
    window = (slice(cover.top, cover.top + label.shape[0]), slice(cover.left, cover.left + label.shape[1]))
    spread = cv2.dilate(label.astype(np.float32), np.ones((3, 3))).astype(np.int32)
    label = np.where(label > 0, label, spread)
    rows, columns = np.nonzero((share > 0) & (label > 0))
    cell = label[rows, columns] - 1
    colour = np.zeros((len(cell), 3), np.float32)
    x, y = rays[0][window][rows, columns], rays[1][window][rows, columns]
    number = np.array([number for number, _, _ in layer.cells])[cell]
    front = ((view.centre - layer.centres) * layer.normals).sum(1) > 0
    for index, part in enumerate(layer.parts):
        mine = np.flatnonzero(number == index)
        if not len(mine):
            continue
        if part.picture is None:
            colours = np.stack([part.colours[facet] if k == index else np.zeros(3) for k, facet, _ in layer.cells])
            colour[mine] = colours[cell[mine]]
        else:
            u, v = flat_places(layer, view, cell[mine], x[mine], y[mine])
            colour[mine] = _look_up(part, u, v, layer, view)
        if part.back is not None:
            behind = mine[~front[cell[mine]]]
            colour[behind] = part.back
    weight = share[rows, columns][:, None]
    target = photo[window]
    target[rows, columns] = target[rows, columns] * (1 - weight) + colour * weight
    return cover


def flat_places(layer: Layer, view: View, cell: NDArray[np.int64], x: Linear, y: Linear) -> tuple[Linear, Linear]:
    """Flat coordinates on their cells of rays (x, y, 1)."""
    rotation = np.stack([piece.rotation for _, _, piece in layer.cells])
    origin = np.stack([piece.origin for _, _, piece in layer.cells])
    to_camera = np.stack(
        [
            rotation[:, :, 0] @ view.rotation.T,
            -rotation[:, :, 1] @ view.rotation.T,
            origin @ view.rotation.T + view.translation,
        ],
        -1,
    )
    with np.errstate(all="ignore"):
        inverse = np.linalg.inv(to_camera + 1e-9 * np.eye(3))
    rows = inverse.astype(np.float32)[cell]
    w = rows[:, 2, 0] * x + rows[:, 2, 1] * y + rows[:, 2, 2]
    u = (rows[:, 0, 0] * x + rows[:, 0, 1] * y + rows[:, 0, 2]) / w
    v = (rows[:, 1, 0] * x + rows[:, 1, 1] * y + rows[:, 1, 2]) / w
    return u, v


def _look_up(part: Part, u: Linear, v: Linear, layer: Layer, view: View) -> Linear:
    assert part.picture is not None
    picture, scale = part.picture, part.scale
    middle = layer.centres.mean(0)
    photo_scale = view.focal_length / np.linalg.norm(view.centre - middle)
    factor = scale / photo_scale
    if factor > _MOST_MINIFIED:
        # By its size: by a factor, OpenCV rounds the size and keeps to the factor, and the print would stretch.
        size = tuple(max(round(side / factor), 1) for side in picture.shape[1::-1])
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    across, down = picture.shape[1] / part.picture.shape[1] * scale, picture.shape[0] / part.picture.shape[0] * scale
    colour = TO_LINEAR[remap(picture, u * np.float32(across) - 0.5, v * np.float32(down) - 0.5)]
    if part.light is not None:
        colour = colour * remap(part.light, u * np.float32(part.light_scale), v * np.float32(part.light_scale))[:, None]
    return colour


def remap(image: NDArray, x: Linear, y: Linear) -> NDArray:
    """Bilinear values (N, ...) of an image at N places, the edge's beyond the edge."""
    count = len(x)
    lines = -(-count // _REMAP_WIDTH)
    pad = lines * _REMAP_WIDTH - count
    maps = [np.pad(part.astype(np.float32), (0, pad)).reshape(lines, _REMAP_WIDTH) for part in (x, y)]
    values = cv2.remap(image, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return values.reshape(lines * _REMAP_WIDTH, *image.shape[2:])[:count]


def in_order(layers: Sequence[Layer], view: View) -> list[Layer]:
    """The layers, those that others may hide first: of two beside each other the camera's side comes later."""
    rest, ordered = list(layers), []
    while rest:
        free = [layer for layer in rest if not any(_hides(layer, other, view) for other in rest if other is not layer)]
        ordered.append(free[0] if free else rest[0])
        rest.remove(ordered[-1])
    return ordered


def _hides(front: Layer, back: Layer, view: View) -> bool:
    """Whether a line on the ground has ``front`` and the camera on one side, and ``back`` on the other."""
    eye = view.centre[None, :2]
    along_front = (_beyond(front.ground, back.ground).min(0) > -1e-6) & (_beyond(front.ground, eye)[0] < 0)
    along_back = (_beyond(back.ground, front.ground).min(0) > -1e-6) & (_beyond(back.ground, eye)[0] > 0)
    return bool(along_front.any() or along_back.any())


def _beyond(polygon: Array, points: Array) -> Array:
    """How far points (K, 2) lie beyond the edges of a counter-clockwise polygon (N, 2), times their lengths: (K, N)."""
    edge = np.roll(polygon, -1, 0) - polygon
    normal = np.stack([edge[:, 1], -edge[:, 0]], -1)
    return np.einsum("nd,knd->kn", normal, points[:, None] - polygon)
