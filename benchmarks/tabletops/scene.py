"""A scene from one seed: the table, the sheet, the things beside it, the light and the cameras."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from . import bends, clutter, grounds
from .bends import Bent
from .cameras import View, hand_held
from .lighting import Light, Map
from .raster import Layer, Part
from .shapes import Array, Facet, Random, border
from .written import Picture, printed

TABLES = (
    "wood",
    "light_wood",
    "dark_wood",
    "planks",
    "patterned_cloth",
    "chequered_cloth",
    "carpet",
    "stone",
    "newspaper",
    "white",
    "black",
    "papers",
    "board",
    "tiles",
    "metal",
)
SHEETS = tuple(bends.KINDS)

# Side of a table's picture and longer side of a page's, in long sides of a photo: as sharp as the photos, or sharper.
_TABLE_PIXELS, _PAGE_PIXELS = 2.88, 1.875
# Pixels of a table's picture per pixel of the map of light.
_LIGHT_STEP = 2
# A table is this many times as wide as the sheet is long.
_TABLE_SHARE = (3.6, 4.6)
_DENSE = ("text", "letter", "form", "poster")


def kinds(seed: int) -> tuple[str, str]:
    """The table and the sheet of a seed; sixty seeds in a row have each table four times, with different sheets."""
    turn, table = divmod(seed % 60, len(TABLES))
    return TABLES[table], SHEETS[(table + 3 * turn) % len(SHEETS)]


@dataclass
class Table:
    """The table's plane: its picture, the light on it, and where its top left corner and axes are in x, y and z."""

    picture: Picture
    scale: float
    light: Map
    corner: Array
    axes: Array
    gloss: float
    floor: Picture


@dataclass
class Scene:
    """Everything that the photos of a scene share."""

    seed: int
    table_kind: str
    paper_kind: str
    layout: str
    clutter: list[str]
    overlapping: list[str]
    sheet: Bent
    table: Table
    light: Light
    layers: list[Layer]
    edge: Array
    views: list[View]
    cut_off: list[int]


def hull(points: Array) -> Array:
    """Convex hull (K, 2), counter-clockwise."""
    return points[ConvexHull(points).vertices]


def corners_of(facets: list[Facet]) -> Array:
    return np.concatenate([facet.corners for facet in facets])


def make(seed: int, size: tuple[int, int] = (1600, 1200)) -> Scene:
    """The scene of a seed; ``size`` is the photos' long and short side in pixels."""
    random = np.random.default_rng([seed, 1])
    table_kind, sheet_kind = kinds(seed)
    sheet = bends.KINDS[sheet_kind](np.random.default_rng([seed, 2]))
    light = _light(random, seed)
    paper_kind, layout, paper, ink = _paper(random, table_kind, sheet_kind)
    thickness = random.uniform(1.0, 5.5) if table_kind == "board" else 0.0
    edge = border(sheet.facets, sheet.width, sheet.height)
    ground = hull(corners_of(sheet.facets)[:, :2])
    layers, under = [], []
    page_pixels = round(_PAGE_PIXELS * max(size))
    if sheet_kind == "book":
        layers, sheet, edge, ground = _open_book(random, sheet, page_pixels, layout, paper, ink, light)
    if table_kind == "board":
        under = [_board(random, ground, thickness, light)]
    cut_off = int(random.integers(1, 4)) if random.random() < 0.3 else 0
    photos = int(random.integers(6, 10))
    views = hand_held(np.random.default_rng([seed, 8]), edge, photos, size, min(cut_off, photos - 4))
    count = int(random.choice([0, 1, 2, 3, 5, 8], p=[0.1, 0.15, 0.25, 0.25, 0.2, 0.05]))
    taken = [under[0].ground if under else ground]
    things = clutter.scatter(random, taken, count, -thickness, light)
    things = [layer for layer in things if not any(_hides_sheet(layer, view, edge) for view in views)]
    overlapping = []
    if sheet_kind in ("flat", "curled", "folded") and random.random() < 0.12:
        overlapping.append(clutter.on_the_edge(random, edge, light))
    shading = [facet.corners for layer in things for part in layer.parts for facet in part.facets]
    if sheet_kind != "book":
        page = _page(random, sheet, page_pixels, layout, paper, ink)
        layers = [_sheet_layer(random, sheet, page, paper, light, shading, ground)]
    casters = [facet.corners for facet in sheet.facets] + shading
    casters += [facet.corners for layer in [*layers, *under] for part in layer.parts for facet in part.facets]
    pixels = round(_TABLE_PIXELS * max(size))
    table = _table(random, table_kind, pixels, sheet, thickness, light, casters, edge, len(things))
    if under:
        _light_on_board(under[0], light, [facet.corners for facet in sheet.facets] + shading, edge)
    cut = [index for index, view in enumerate(views) if _is_cut_off(view, edge)]
    return Scene(
        seed,
        table_kind,
        paper_kind,
        layout,
        sorted(layer.name for layer in things),
        sorted(layer.name for layer in overlapping),
        sheet,
        table,
        light,
        [*under, *layers, *things, *overlapping],
        edge,
        views,
        cut,
    )


def _hides_sheet(layer: Layer, view: View, edge: Array) -> bool:
    """Whether a thing beside the sheet stands in front of it: the photographer would have moved it away."""
    corners = np.concatenate([facet.corners for part in layer.parts for facet in part.facets])
    if ((corners @ view.rotation.T + view.translation)[:, 2] < 100).any():
        return True
    away = np.linalg.norm(view.centre[:2] - layer.ground, axis=1).min()
    if away > np.linalg.norm(view.centre[:2] - edge[:, :2], axis=1).max():
        return False
    masks = []
    for outline in (hull(view.project(corners)), view.project(edge)):
        mask = np.zeros((view.height // 4, view.width // 4), np.uint8)
        cv2.fillPoly(mask, [np.round(np.clip(outline / 4, -5000, 5000)).astype(np.int32)], 1)
        masks.append(mask)
    return bool((masks[0] & masks[1]).any())


def _is_cut_off(view: View, edge: Array) -> bool:
    pixels = view.project(edge)
    return bool(((pixels < 0) | (pixels > [view.width, view.height])).any())


def _light(random: Random, seed: int) -> Light:
    azimuth, height = random.uniform(0, 2 * np.pi), np.radians(random.uniform(28, 75))
    lamp = np.array([np.cos(azimuth) * np.cos(height), np.sin(azimuth) * np.cos(height), np.sin(height)])
    distance = random.choice([random.uniform(700, 1600), 1e5])
    return Light(lamp, random.uniform(0.3, 0.8), distance, random.uniform(0.03, 0.22), seed)


def _paper(random: Random, table: str, sheet: str) -> tuple[str, str, Array, Array]:
    """Kind of paper, layout, and the sRGB colours of paper and ink."""
    if table == "white":
        kind = random.choice(["white", "toned"], p=[0.85, 0.15])
    elif table == "black":
        kind = random.choice(["white", "strong", "cover", "dark"], p=[0.4, 0.1, 0.2, 0.3])
    else:
        kind = random.choice(
            ["white", "toned", "pastel", "strong", "cover", "dark"], p=[0.44, 0.14, 0.12, 0.08, 0.12, 0.1]
        )
    if sheet in ("receipt", "book") and kind not in ("white", "toned"):
        kind = "toned" if random.random() < 0.5 else "white"
    tint = {
        "white": [(247, 247, 244), (243, 243, 246), (249, 247, 240)],
        "toned": [(240, 230, 206), (222, 196, 156), (232, 220, 190)],
        "pastel": [(196, 222, 240), (246, 206, 212), (204, 234, 200), (248, 236, 170)],
        "strong": [(226, 80, 60), (60, 120, 190), (70, 160, 90), (240, 180, 40)],
        "cover": [(230, 230, 228)],
        "dark": [(36, 36, 40), (28, 34, 56), (60, 30, 34)],
    }[str(kind)]
    paper = np.clip(np.array(tint[random.integers(len(tint))]) * random.uniform(0.96, 1.01), 0, 252)
    ink = np.array([232, 228, 216]) if kind == "dark" else random.uniform(15, 60, 3)
    if kind == "cover":
        layout = "cover"
    elif sheet == "receipt":
        layout = "receipt"
    elif table in ("white", "black", "metal"):
        # Without texture beside the sheet, its print alone must suffice to place the photos.
        layout = random.choice(_DENSE)
    else:
        layout = "sparse" if random.random() < 0.15 else random.choice(_DENSE)
    return str(kind), str(layout), paper, ink


def _page(random: Random, sheet: Bent, pixels: int, layout: str, paper: Array, ink: Array) -> tuple[Picture, float]:
    scale = pixels / max(sheet.width, sheet.height)
    return printed(random, layout, sheet.width, sheet.height, scale, paper, ink), scale


def _sheet_layer(
    random: Random,
    sheet: Bent,
    page: tuple[Picture, float],
    paper: Array,
    light: Light,
    shading: list[Array],
    ground: Array,
) -> Layer:
    bright, scale = light.on_sheet(sheet.facets, sheet.width, sheet.height, shading)
    back = clutter.linear(paper) * 0.6
    return Layer("sheet", [Part(sheet.facets, page[0], page[1], bright, scale, back=back)], ground)


def mirrored(sheet: Bent) -> list[Facet]:
    """The facets of the facing page, on the other side of x = 0; its gutter is u = width."""
    mirror = np.diag([-1.0, 1, 1])
    facets = []
    for facet in sheet.facets:
        rotation = mirror @ facet.rotation @ np.diag([-1.0, 1, -1])
        rotation[:, 2] = np.cross(rotation[:, 0], rotation[:, 1])
        origin = mirror @ facet.in_space(np.array([sheet.width, 0.0]))
        facets.append(Facet((facet.flat * [-1, 1] + [sheet.width, 0])[::-1], rotation, origin))
    return facets


def _open_book(
    random: Random, right: Bent, pixels: int, layout: str, paper: Array, ink: Array, light: Light
) -> tuple[list[Layer], Bent, Array, Array]:
    """Both pages with the block under them, on their cover; the sheet is one of the pages."""
    left = Bent("book", right.width, right.height, mirrored(right))
    pages = [right, left] if random.random() < 0.5 else [left, right]
    parts = []
    for page, other in (pages, pages[::-1]):
        picture, scale = _page(random, page, pixels, layout if page is pages[0] else "text", paper, ink)
        bright, light_scale = light.on_sheet(page.facets, page.width, page.height, [], other.facets)
        parts.append(Part(page.facets, picture, scale, bright, light_scale, back=clutter.linear(paper) * 0.5))
    sides = [side for page in pages for side in _block(page)]
    tone = clutter.linear(paper * np.array([0.86, 0.82, 0.74]))
    stripes = random.uniform(0.85, 1.1, len(sides))
    shades = [tone * light.on_face(side.normal) * stripe for side, stripe in zip(sides, stripes)]
    parts.append(Part(sides, colours=np.array(shades)))
    outline = border(pages[0].facets, pages[0].width, pages[0].height)
    reach = corners_of([*right.facets, *left.facets])
    ground = hull(reach[:, :2])
    low, high = reach.min(0)[:2] - 4, reach.max(0)[:2] + 4
    box = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
    colour = random.choice([(90, 30, 34), (30, 40, 70), (40, 60, 44), (24, 24, 26), (190, 170, 130)])
    lifted = 2.4
    cover = clutter.solid("cover", box, 0, lifted, light, np.array(colour), np.array(colour))
    return [cover, Layer("sheet", parts, ground)], pages[0], outline, box


def _block(page: Bent) -> list[Facet]:
    """The book's leaves under a page, seen from the side: plane faces from the page's edge down to the table."""
    facets = []
    for facet in page.facets:
        for start, end in zip(facet.flat, np.roll(facet.flat, -1, 0)):
            middle = (start + end) / 2
            on_edge = min(abs(middle[1]), abs(middle[1] - page.height)) < 1e-6
            outer = abs(middle[0] - page.width) < 1e-6 or abs(middle[0]) < 1e-6
            corners = facet.in_space(np.stack([start, end]))
            if outer and abs(corners[:, 0]).max() < 1:
                continue
            if not (on_edge or outer):
                continue
            along = corners[1] - corners[0]
            across = np.array([along[0], along[1], 0])
            across /= np.linalg.norm(across)
            normal = np.cross([0, 0, 1.0], across)
            outward = corners.mean(0) - corners_of(page.facets).mean(0)
            if normal @ outward < 0:
                across, normal = -across, -normal
            rotation = np.column_stack([-across, [0, 0, 1], normal])
            origin = np.append(corners[0][:2], 0)
            high = (corners - origin) @ rotation[:, :2] * [1, -1]
            facets.append(Facet(np.concatenate([high, (high * [1, 0])[::-1]]), rotation, origin))
    return facets


def _board(random: Random, ground: Array, thickness: float, light: Light) -> Layer:
    """A clipboard, a desk pad, a cutting mat or a leather one, whose top is z = 0."""
    low, high = ground.min(0), ground.max(0)
    margin = random.uniform(6, 45, 4) if random.random() < 0.6 else random.uniform(50, 110, 4)
    low, high = low - margin[:2], high + margin[2:]
    wide, deep = high - low
    scale = 4.0
    canvas = grounds.Canvas(random, int(np.ceil(max(wide, deep) * scale)), scale)
    kind = random.choice(["hardboard", "leather", "mat", "plastic", "glass"])
    if kind == "hardboard":
        tone = 0.5 + 0.08 * canvas.noise(1.2, 0.6) + 0.05 * canvas.noise(0.5) + 0.05 * canvas.noise(40)
        base = np.array([(150, 104, 64), (176, 132, 86), (120, 84, 56)][random.integers(3)])
    elif kind == "leather":
        tone = 0.5 + 0.13 * canvas.noise(1.6) + 0.06 * canvas.noise(0.7) + 0.05 * canvas.noise(60)
        base = np.array([(70, 44, 32), (30, 30, 32), (110, 50, 40)][random.integers(3)])
    elif kind == "mat":
        x, y = canvas.ramp()
        lines = (np.minimum(x % 10, y % 10) < 0.4).astype(np.float32)
        tone = 0.45 + 0.25 * lines + 0.04 * canvas.noise(0.6)
        base = np.array([(40, 110, 80), (50, 70, 110)][random.integers(2)])
    else:
        tone = 0.5 + 0.03 * canvas.noise(0.9) + 0.05 * canvas.noise(50)
        base = np.array([(40, 42, 46), (196, 196, 190), (60, 90, 130), (214, 190, 170)][random.integers(4)])
    top = canvas.paint(tone, base * 0.5, base, np.minimum(base * 1.5, 245))
    top = np.ascontiguousarray(top[: int(np.ceil(deep * scale)), : int(np.ceil(wide * scale))])
    if kind == "hardboard":
        middle, clip_deep = top.shape[1] // 2, int(min(22, margin[3] * 0.8) * scale)
        cv2.rectangle(top, (middle - 55 * 4, 0), (middle + 55 * 4, clip_deep), (170, 172, 176), -1, cv2.LINE_AA)
        cv2.rectangle(top, (middle - 55 * 4, 0), (middle + 55 * 4, clip_deep), (90, 90, 94), 2, cv2.LINE_AA)
        cv2.circle(top, (middle, clip_deep // 2), max(3, clip_deep // 4), (60, 60, 62), -1, cv2.LINE_AA)
    box = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
    return clutter.solid("board", box, -thickness, 0.0, light, top, base * 0.7, scale)


def _light_on_board(board: Layer, light: Light, casters: list[Array], edge: Array) -> None:
    """Shadows of the things on it and beside it, on its top."""
    top = board.parts[1]
    corner = top.facets[0].origin
    scale = 2.0
    size = int(np.ceil(np.ptp(board.ground, axis=0).max() * scale))
    axes = np.array([[1.0, 0], [0, -1]])
    bright = light.on_plane(casters, corner, axes, size, scale)
    _contact(bright, edge, corner, axes, scale, 0.5)
    top.light, top.light_scale = bright, scale


def _contact(bright: Map, edge: Array, corner: Array, axes: Array, scale: float, strength: float) -> None:
    """The thin dark line where the sheet's edge touches its ground."""
    line = np.zeros(bright.shape, np.uint8)
    pixels = np.round((edge[:, :2] - corner[:2]) @ axes.T * scale * 16).astype(np.int32)
    low = edge[:, 2] - corner[2] < 1.2
    for start, end, touches in zip(pixels, np.roll(pixels, -1, 0), low):
        if touches:
            cv2.line(line, tuple(start.tolist()), tuple(end.tolist()), 255, 1, cv2.LINE_AA, 4)
    soft = cv2.GaussianBlur(line, (0, 0), 0.6)
    bright *= 1 - strength / 255 * soft.astype(np.float32)


def _table(
    random: Random,
    kind: str,
    pixels: int,
    sheet: Bent,
    thickness: float,
    light: Light,
    casters: list[Array],
    edge: Array,
    things: int,
) -> Table:
    length = max(sheet.width, sheet.height, 210.0)
    extent = length * random.uniform(*_TABLE_SHARE)
    canvas = grounds.Canvas(random, pixels, pixels / extent)
    turn = random.uniform(-25, 25) + random.choice([0, 90])
    angle = np.radians(turn)
    axes = np.array([[np.cos(angle), np.sin(angle)], [np.sin(angle), -np.cos(angle)]])
    # A table's edge may be near the sheet on one side, never under it.
    middle = np.array([extent / 2, extent / 2]) + random.uniform(-0.16, 0.16, 2) * extent
    corner = np.append(-middle @ axes, -thickness)
    top = kind
    if kind in ("papers", "newspaper", "board"):
        top = str(random.choice(["wood", "light_wood", "plain", "dark_wood", "stone", "planks"]))
    picture = grounds.TOPS[top](canvas)
    if top not in ("planks", "carpet") and random.random() < 0.5:
        clutter.small_things(random, canvas, picture, int(random.integers(1, 4 + things)))
    size = (sheet.width, sheet.height)
    if kind == "papers":
        clutter.papers(random, canvas, picture, middle, size, int(random.integers(2, 7)))
    elif kind == "newspaper":
        clutter.newspaper(random, canvas, picture, middle, size)
    elif random.random() < 0.15:
        clutter.papers(random, canvas, picture, middle + random.choice([-1, 1]) * np.array(size), size, 1)
    scale = canvas.scale / _LIGHT_STEP
    bright = light.on_plane(casters, corner, axes, pixels // _LIGHT_STEP, scale)
    if thickness == 0.0 and sheet.kind != "book":
        _contact(bright, edge, corner, axes, scale, random.uniform(0.2, 0.6))
    gloss = {"metal": 0.25, "tiles": 0.08, "black": 0.06, "white": 0.04, "stone": 0.05}.get(top, 0.02)
    floor = _floor(random)
    return Table(picture, canvas.scale, bright, corner, axes, gloss * random.uniform(0.4, 1.4), floor)


def _floor(random: Random) -> NDArray[np.uint8]:
    """The floor beyond the table, out of focus."""
    canvas = grounds.Canvas(random, 512, 0.15)
    tone = 0.5 + 0.2 * canvas.noise(300) + 0.15 * canvas.noise(60)
    if random.random() < 0.5:
        for _ in range(int(random.integers(3, 10))):
            low = random.integers(0, 480, 2)
            high = low + random.integers(20, 120, 2)
            tone[low[1] : high[1], low[0] : high[0]] = random.uniform(0, 1)
    colour = random.uniform(40, 170) * random.uniform(0.85, 1.15, 3)
    return cv2.GaussianBlur(canvas.paint(tone, colour * 0.4, np.minimum(colour * 1.5, 245)), (0, 0), 2.5)
