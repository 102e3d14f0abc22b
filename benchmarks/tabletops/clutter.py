"""Things on a table beside the sheet: solids with some height, and flat things drawn into the table's picture."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import cv2
import numpy as np

from .grounds import Canvas, paste
from .lighting import Light
from .raster import TO_LINEAR, Layer, Part
from .shapes import Array, Facet, Random
from .written import Page, Picture, photograph, printed, words

# Least and largest distance from the sheet's ground to a thing beside it, millimetres.
_NEAREST, _FARTHEST = 4.0, 170.0
_TRIES = 60


def linear(colour: object) -> Array:
    return TO_LINEAR[np.clip(np.asarray(colour), 0, 255).astype(int)].astype(float)


def _prism(ground: Array, low: float, high: float) -> tuple[Facet, list[Facet]]:
    """Top and sides of an upright prism over a convex counter-clockwise polygon.

    The top's flat coordinates begin at the upper left of its box along the edge from corner 3 to corner 2.
    """
    along = ground[2] - ground[3]
    along = np.append(along / np.linalg.norm(along), 0)
    top_rotation = np.column_stack([along, np.cross([0, 0, 1], along), [0, 0, 1]])
    origin = np.append(ground[3], high)
    flat = (np.column_stack([ground, np.full(len(ground), high)]) - origin) @ top_rotation[:, :2] * [1, -1]
    top = Facet(flat, top_rotation, origin)
    top = Facet(flat - flat.min(0), top_rotation, top.in_space(flat.min(0)))
    sides = []
    for start, end in zip(ground, np.roll(ground, -1, 0)):
        way = end - start
        length = np.linalg.norm(way)
        edge = np.append(way / length, 0)
        rotation = np.column_stack([edge, [0, 0, 1], np.cross(edge, [0, 0, 1])])
        corners = np.array([[0, 0], [length, 0], [length, high - low], [0, high - low]])
        sides.append(Facet(corners, rotation, np.append(start, high)))
    return top, sides


def _rectangle(centre: Array, width: float, depth: float, turn: float) -> Array:
    """Counter-clockwise corners: bottom left, bottom right, top right, top left before the turn."""
    box = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array([width, depth]) / 2
    c, s = np.cos(turn), np.sin(turn)
    return centre + box @ np.array([[c, s], [-s, c]])


def _round(centre: Array, radius: float, turn: float, corners: int = 28) -> Array:
    angle = turn + np.linspace(0, 2 * np.pi, corners, endpoint=False)
    return centre + radius * np.stack([np.cos(angle), np.sin(angle)], -1)


def solid(
    name: str, ground: Array, low: float, high: float, light: Light, top: object, side: object, scale: float = 4.0
) -> Layer:
    """An upright prism whose top is a picture or a colour."""
    lid, sides = _prism(ground, low, high)
    parts = [Part(sides, colours=np.stack([linear(side) * light.on_face(facet.normal) for facet in sides]))]
    if isinstance(top, np.ndarray) and top.ndim == 3:
        bright = np.full((2, 2), light.on_face(lid.normal), np.float32)
        parts.append(Part([lid], top, scale, bright))
    else:
        parts.append(Part([lid], colours=linear(top)[None] * light.on_face(lid.normal)))
    return Layer(name, parts, ground)


def _phone(random: Random, centre: Array, turn: float, base: float, light: Light) -> Layer:
    width, depth, scale = 72.0, 150.0, 5.0
    top = np.full((round(depth * scale), round(width * scale), 3), random.uniform(8, 40), np.uint8)
    if random.random() < 0.5:
        top[30:-30, 15:-15] = cv2.resize(photograph(random, 360, 180), (top.shape[1] - 30, top.shape[0] - 60))
    else:
        cv2.rectangle(top, (18, 24), (110, 130), (50, 50, 54), -1, cv2.LINE_AA)
        cv2.circle(top, (62, 60), 22, (10, 10, 14), -1, cv2.LINE_AA)
    return solid("phone", _rectangle(centre, width, depth, turn), base, base + 8.5, light, top, (30, 30, 32), scale)


def _keyboard(random: Random, centre: Array, turn: float, base: float, light: Light) -> Layer:
    width, depth, scale = random.uniform(280, 430), 120.0, 3.5
    dark = random.random() < 0.6
    body, key, ink = (
        ((34, 34, 36), (56, 56, 60), (220, 220, 220)) if dark else ((206, 206, 204), (238, 238, 236), (60, 60, 60))
    )
    page = Page(random, width, depth, scale, np.array(body), np.array(ink))
    y = 8.0
    for _ in range(5):
        x = 8.0
        while x < width - 22:
            wide = random.choice([16.0, 16.0, 16.0, 16.0, 24.0, 36.0])
            wide = min(wide, width - 8 - x)
            page.box(x, y, wide, 17, fill=key)
            page.line(x + 4, y + 4, words(random, 1)[0][:1].upper(), 5, "DejaVuSans")
            x += wide + 3
        y += 20.5
    side = tuple(0.8 * v for v in body)
    return solid("keyboard", _rectangle(centre, width, depth, turn), base, base + 18, light, page.pixels(), side, scale)


def _book(random: Random, centre: Array, turn: float, base: float, light: Light) -> Layer:
    width, depth, scale = random.uniform(110, 170), random.uniform(160, 240), 4.0
    paper, ink = random.uniform(30, 230, 3), random.choice([(240, 236, 226), (20, 20, 24)])
    layout = random.choice(["cover", "poster"])
    top = printed(random, layout, width, depth, scale, paper, ink)
    ground = _rectangle(centre, width, depth, turn)
    return solid("book", ground, base, base + random.uniform(6, 30), light, top, (206, 198, 180), scale)


def _ruler(random: Random, centre: Array, turn: float, base: float, light: Light) -> Layer:
    width, depth, scale = 310.0, 30.0, 6.0
    body = random.choice([(232, 206, 150), (200, 202, 206), (230, 200, 60)])
    top = np.full((round(depth * scale), round(width * scale), 3), body, np.uint8)
    for millimetre in range(301):
        tick = 4 if millimetre % 10 else 9
        x = round((5 + millimetre) * scale)
        cv2.line(top, (x, 0), (x, round(tick * scale * 0.8)), (20, 20, 20), 1)
        if millimetre % 10 == 0:
            place = (x - 8, round(13 * scale))
            cv2.putText(top, str(millimetre // 10), place, cv2.FONT_HERSHEY_SIMPLEX, 0.7, (20, 20, 20), 1, cv2.LINE_AA)
    return solid("ruler", _rectangle(centre, width, depth, turn), base, base + 2, light, top, body, scale)


def _coin(random: Random, centre: Array, turn: float, base: float, light: Light) -> Layer:
    radius, scale = random.uniform(8, 13), 12.0
    colour = np.array(random.choice([(176, 130, 80), (190, 190, 192), (206, 172, 90)]))
    size = round(2 * radius * scale)
    y, x = np.mgrid[:size, :size] / size * 2 - 1
    rings = 1 + 0.15 * np.cos(np.hypot(x, y) * 14) + 0.12 * x
    top = np.clip(colour * rings[..., None], 0, 255).astype(np.uint8)
    text = str(random.choice([1, 2, 5, 10, 20, 50]))
    cv2.putText(top, text, (size // 4, size * 2 // 3), cv2.FONT_HERSHEY_DUPLEX, size / 50, (60, 50, 40), 3, cv2.LINE_AA)
    return solid("coin", _round(centre, radius, turn, 36), base, base + 2, light, top, colour * 0.7, scale)


def _cup(random: Random, centre: Array, turn: float, base: float, light: Light) -> Layer:
    radius, scale = random.uniform(36, 44), 6.0
    body = random.choice([(236, 234, 228), (60, 90, 140), (170, 60, 50), (40, 40, 42), (90, 140, 110)])
    size = round(2 * radius * scale)
    top = np.full((size, size, 3), body, np.uint8)
    middle = (size // 2, size // 2)
    cv2.circle(top, middle, round(size * 0.46), tuple(0.55 * v for v in body), -1, cv2.LINE_AA)
    cv2.circle(top, (size // 2 + 4, size // 2 + 6), round(size * 0.42), (70, 42, 24), -1, cv2.LINE_AA)
    lid, sides = _prism(_round(centre, radius, turn), base, base + random.uniform(75, 100))
    shades = np.stack([linear(body) * light.on_face(facet.normal) for facet in sides])
    bright = np.full((2, 2), 1.0, np.float32)
    return Layer("cup", [Part(sides, colours=shades), Part([lid], top, scale, bright)], _round(centre, radius, turn))


def _pen(random: Random, centre: Array, turn: float, base: float, light: Light) -> Layer:
    """A hexagonal prism lying down, with a grip and a tip."""
    length, radius = random.uniform(125, 175), random.uniform(3.5, 6)
    axis = np.array([np.cos(turn), np.sin(turn), 0])
    across, up = np.array([-axis[1], axis[0], 0]), np.array([0, 0, 1.0])
    body = random.choice([(30, 60, 160), (24, 24, 26), (190, 40, 40), (230, 190, 60), (40, 120, 70), (226, 226, 224)])
    pieces = [(0.0, 0.12, (214, 190, 150)), (0.12, 0.75, body), (0.75, 0.97, body), (0.97, 1.0, (60, 60, 62))]
    facets, colours = [], []
    angles = np.radians(np.arange(0, 361, 60) - 60)
    section = [radius * (np.cos(a) * across + np.sin(a) * up) for a in angles]
    start = np.append(centre, base + radius * np.sin(np.radians(60))) - axis * length / 2
    for begin, end, colour in pieces:
        for one, two in pairwise(section):
            edge = (two - one) / np.linalg.norm(two - one)
            normal = np.cross(axis, edge)
            normal = normal if normal @ (one + two) > 0 else -normal
            rotation = np.column_stack([axis, np.cross(normal, axis), normal])
            origin = start + one + axis * length * begin
            reach = (two - one) @ rotation[:, 1]
            span = length * (end - begin)
            facets.append(Facet(np.array([[0, 0], [span, 0], [span, -reach], [0, -reach]]), rotation, origin))
            colours.append(linear(colour) * max(light.on_face(normal), 0.05))
    for end, way, colour in ((0.0, -axis, pieces[0][2]), (1.0, axis, pieces[-1][2])):
        rotation = np.column_stack([np.cross(up, way), up, way])
        origin = start + axis * length * end
        flat = np.stack([[point @ rotation[:, 0], -point[2]] for point in section[:-1]])
        facets.append(Facet(flat, rotation, origin))
        colours.append(linear(colour) * light.on_face(way))
    return Layer("pen", [Part(facets, colours=np.array(colours))], _rectangle(centre, length, 2 * radius, turn))


def _box(random: Random, centre: Array, turn: float, base: float, light: Light) -> Layer:
    """A plain box: a stapler, a charger, a glasses case."""
    width, depth, height = random.uniform(40, 160), random.uniform(25, 70), random.uniform(12, 55)
    colour = random.uniform(15, 225, 3)
    return solid("box", _rectangle(centre, width, depth, turn), base, base + height, light, colour, colour * 0.9)


_MAKERS: dict[str, tuple[Callable[[Random, Array, float, float, Light], Layer], float]] = {
    "pen": (_pen, 0.2),
    "coin": (_coin, 0.14),
    "phone": (_phone, 0.15),
    "keyboard": (_keyboard, 0.1),
    "book": (_book, 0.12),
    "ruler": (_ruler, 0.09),
    "cup": (_cup, 0.12),
    "box": (_box, 0.08),
}


def apart(first: Array, second: Array) -> float:
    """The widest gap between two convex counter-clockwise polygons along an edge's normal; negative if they overlap."""
    widest = -np.inf
    for polygon, other in ((first, second), (second, first)):
        edge = np.roll(polygon, -1, 0) - polygon
        normal = np.stack([edge[:, 1], -edge[:, 0]], -1)
        normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
        widest = max(widest, float(np.einsum("nd,knd->kn", normal, other[:, None] - polygon).min(0).max()))
    return widest


def scatter(random: Random, taken: list[Array], count: int, base: float, light: Light) -> list[Layer]:
    """``count`` things beside the first of the grounds ``taken``, apart from each other; fewer if there is no room."""
    layers: list[Layer] = []
    names, weights = list(_MAKERS), np.array([weight for _, weight in _MAKERS.values()])
    sheet = taken[0]
    middle, reach = sheet.mean(0), np.ptp(sheet, axis=0).max() / 2
    for _ in range(count):
        make = _MAKERS[random.choice(names, p=weights / weights.sum())][0]
        seed = int(random.integers(2**31))
        for _ in range(_TRIES):
            angle, turn = random.uniform(0, 2 * np.pi, 2)
            centre = middle + random.uniform(0.5 * reach, 1.5 * reach + _FARTHEST) * np.array(
                [np.cos(angle), np.sin(angle)]
            )
            layer = make(np.random.default_rng(seed), centre, turn, base, light)
            gap = apart(sheet, layer.ground)
            if _NEAREST < gap < _FARTHEST and all(
                apart(ground, layer.ground) > 2 for ground in [*taken[1:], *(other.ground for other in layers)]
            ):
                layers.append(layer)
                break
    return layers


def on_the_edge(random: Random, border: Array, light: Light) -> Layer:
    """A coin or a pen that covers a little of the sheet's edge (K, 3)."""
    place = border[random.integers(len(border))]
    if random.random() < 0.5:
        return _coin(random, place[:2], 0.0, place[2] + 0.3, light)
    inward = border.mean(0)[:2] - place[:2]
    angle = np.arctan2(*inward[::-1]) + random.uniform(-0.6, 0.6)
    centre = place[:2] - 62 * np.array([np.cos(angle), np.sin(angle)])
    return _pen(random, centre, angle, place[2] + 0.3, light)


def papers(
    random: Random, canvas: Canvas, table: Picture, middle: Array, sheet: tuple[float, float], count: int
) -> None:
    """Other printed sheets on the table (its mm), around and partly under the sheet in its middle."""
    for index in range(count):
        width, height = [(210, 297), (216, 279), (148, 210), (105, 148), (210, 297)][random.integers(5)]
        paper = random.choice([(246, 246, 243), (240, 232, 212), (238, 220, 150), (206, 226, 238), (245, 245, 245)])
        layout = random.choice(["text", "letter", "form", "poster", "sparse"], p=[0.35, 0.25, 0.2, 0.1, 0.1])
        item = printed(random, layout, width, height, canvas.scale, paper, (30, 30, 34))
        angle = 2 * np.pi * (index + random.uniform(-0.3, 0.3)) / count
        reach = np.array(sheet) / 2 * random.uniform(0.9, 1.5) + np.array([width, height]) / 2 * random.uniform(
            0.5, 1.2
        )
        centre = middle + reach * np.array([np.cos(angle), np.sin(angle)])
        paste(canvas, table, item, centre, width, random.normal(0, 30) + random.choice([0, 90, 180]))


def newspaper(random: Random, canvas: Canvas, table: Picture, middle: Array, sheet: tuple[float, float]) -> None:
    """Two sheets of newspaper under the sheet."""
    paper = np.clip(np.array([214, 210, 200]) * random.uniform(0.9, 1.05), 0, 245)
    for turn in (random.uniform(-40, 40), random.uniform(-25, 25)):
        width, height = random.uniform(300, 380), random.uniform(430, 560)
        page = Page(random, width, height, canvas.scale, paper, np.array([48, 46, 46]))
        y = 12.0
        page.line(14, y, " ".join(words(random, 4)).title(), 16, "DejaVuSerif-Bold")
        y += 28
        columns, gap = int(random.integers(4, 7)), 5.0
        wide = (width - 24 - (columns - 1) * gap) / columns
        for column in range(columns):
            top, x = y, 12 + column * (wide + gap)
            while top < height - 24:
                what = random.random()
                if what < 0.18 and top < height - 70:
                    tall = random.uniform(30, 55)
                    page.picture(x, top, wide, tall)
                    top += tall + 4
                elif what < 0.4:
                    page.line(x, top, " ".join(words(random, 2)).title()[: int(wide / 3.4)], 5.5, "DejaVuSerif-Bold")
                    top += 9
                else:
                    lines = int(min(random.integers(5, 16), (height - 14 - top) / 3.2))
                    if lines < 1:
                        break
                    top = page.paragraph(x, top, wide, lines, 2.35) + 3
        offset = random.uniform(-0.25, 0.25, 2) * np.array(sheet)
        paste(canvas, table, page.pixels(), middle + offset, width, turn)


def small_things(random: Random, canvas: Canvas, table: Picture, count: int) -> None:
    """Stains, crumbs, paper clips and notes drawn into the table's picture."""
    for _ in range(count):
        place = random.uniform(0.1, 0.9, 2) * canvas.size
        what = random.random()
        at = tuple(int(v) for v in place)
        if what < 0.25:
            ring = max(4, int(random.uniform(30, 42) * canvas.scale))
            low = np.maximum(np.array(at) - ring - 8, 0)
            window = table[low[1] : at[1] + ring + 8, low[0] : at[0] + ring + 8]
            stain = np.zeros(window.shape[:2], np.uint8)
            cv2.circle(
                stain,
                tuple(int(v) for v in np.array(at) - low),
                ring,
                255,
                max(2, int(1.6 * canvas.scale)),
                cv2.LINE_AA,
            )
            weight = 1 - random.uniform(0.1, 0.3) / 255 * cv2.GaussianBlur(stain, (0, 0), 2).astype(np.float32)
            window[:] = cv2.multiply(window, cv2.merge([weight, weight * weight, weight**3]), dtype=cv2.CV_8U)
        elif what < 0.55:
            _clip(random, canvas, table, place)
        elif what < 0.75:
            side = 76.0
            paper = random.choice([(246, 226, 120), (250, 180, 190), (170, 226, 180), (170, 210, 240)])
            page = Page(random, side, side, canvas.scale, np.array(paper), np.array([40, 50, 120]))
            for line in range(int(random.integers(1, 5))):
                page.line(6, 8 + 13 * line, " ".join(words(random, 2)), 8, "DejaVuSerif-Italic")
            paste(canvas, table, page.pixels(), place / canvas.scale, side, random.uniform(0, 360))
        else:
            for _ in range(int(random.integers(3, 25))):
                crumb = place + random.normal(0, 12 * canvas.scale, 2)
                colour = tuple(random.uniform(40, 200, 3))
                size = max(1, int(random.uniform(0.3, 1.2) * canvas.scale))
                cv2.circle(table, tuple(int(v) for v in crumb), size, colour, -1, cv2.LINE_AA)


def _clip(random: Random, canvas: Canvas, table: Picture, place: Array) -> None:
    """A paper clip."""
    wire = np.array([[8, 3], [26, 3], [29, 0], [26, -4], [3, -4], [0, -1], [2, 2], [22, 2], [23, 0], [21, -2], [9, -2]])
    angle = random.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    points = (place + wire @ turn.T * canvas.scale * random.uniform(0.8, 1.4)).astype(np.int32)
    wide = max(1, round(canvas.scale))
    colour = random.choice([(190, 192, 196), (200, 60, 60), (60, 90, 180), (60, 140, 80)])
    cv2.polylines(table, [points + wide], False, (40, 38, 36), wide, cv2.LINE_AA)
    cv2.polylines(table, [points], False, tuple(float(v) for v in colour), wide, cv2.LINE_AA)
