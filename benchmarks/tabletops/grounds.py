"""Pictures of table tops, each with random scale, colour and contrast."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .shapes import Random
from .written import Picture, fractal

Tone = NDArray[np.float32]


@dataclass(frozen=True)
class Canvas:
    """A square picture that is being filled: its size in pixels and its pixels per millimetre."""

    random: Random
    size: int
    scale: float

    def noise(self, across: float, down: float | None = None) -> Tone:
        """Smooth noise with blots of ``across`` by ``down`` mm; deviation about 1."""
        down = across if down is None else down
        shape = [max(4, int(self.size / max(cell * self.scale, 1.0)) + 2) for cell in (down, across)]
        coarse = self.random.standard_normal(shape, dtype=np.float32)
        return cv2.resize(coarse, (self.size, self.size), interpolation=cv2.INTER_CUBIC)

    def ramp(self) -> tuple[Tone, Tone]:
        """Millimetres along x (1, n) and y (n, 1)."""
        steps = (np.arange(self.size, dtype=np.float32) + 0.5) / self.scale
        return steps[None, :], steps[:, None]

    def paint(self, tone: Tone, *colours: object) -> Picture:
        """``tone`` from 0 to 1 as a mix of the colours in their order."""
        stops = np.linspace(0, 255, len(colours))
        palette = np.stack([np.interp(np.arange(256), stops, channel) for channel in np.array(colours, float).T], -1)
        index = cv2.convertScaleAbs(np.clip(tone, 0, 1), alpha=255)
        return cv2.LUT(cv2.merge([index] * 3), palette.clip(0, 255).astype(np.uint8)[:, None])


def _shade(random: Random, colour: object, spread: float) -> NDArray[np.float64]:
    """A colour near the given one."""
    return np.clip(np.array(colour) * random.uniform(1 - spread, 1 + spread) * random.uniform(0.98, 1.02, 3), 4, 250)


def _grain(canvas: Canvas) -> Tone:
    """Wood along y."""
    random = canvas.random
    x, _ = canvas.ramp()
    pitch = random.uniform(9, 40)
    warp = canvas.noise(random.uniform(50, 120), random.uniform(250, 600))
    rings = np.sin((x / pitch + 0.7 * warp) * 2 * np.pi)
    tone = 0.5 + random.uniform(0.1, 0.3) * rings
    tone += random.uniform(0.08, 0.2) * canvas.noise(random.uniform(0.6, 1.4), random.uniform(12, 50))
    tone += random.uniform(0.02, 0.06) * canvas.noise(0.5, 5)
    pores = canvas.noise(0.5, random.uniform(3, 10))
    tone += random.uniform(0.0, 0.25) * np.maximum(pores - 1.6, 0)
    tone += 0.05 * canvas.noise(160)
    return tone


def _wood(canvas: Canvas, light: object, dark: object) -> Picture:
    random = canvas.random
    picture = canvas.paint(_grain(canvas), _shade(random, light, 0.12), _shade(random, dark, 0.15))
    return picture


def wood(canvas: Canvas) -> Picture:
    kinds = [((190, 140, 92), (128, 84, 50)), ((176, 116, 72), (110, 62, 34)), ((168, 132, 96), (110, 84, 60))]
    return _wood(canvas, *kinds[canvas.random.integers(3)])


def light_wood(canvas: Canvas) -> Picture:
    kinds = [((226, 202, 166), (196, 164, 122)), ((232, 214, 184), (208, 184, 148)), ((214, 204, 190), (180, 168, 152))]
    return _wood(canvas, *kinds[canvas.random.integers(3)])


def dark_wood(canvas: Canvas) -> Picture:
    kinds = [((96, 64, 44), (46, 28, 20)), ((74, 58, 50), (36, 28, 26)), ((110, 60, 42), (52, 24, 18))]
    return _wood(canvas, *kinds[canvas.random.integers(3)])


def planks(canvas: Canvas) -> Picture:
    """Boards with gaps between them, some weathered, with knots and leaves."""
    random = canvas.random
    width = random.uniform(60, 140)
    x, _ = canvas.ramp()
    number = (x / width).astype(int)
    tone = _grain(canvas) + random.uniform(-0.16, 0.16, number.max() + 1).astype(np.float32)[number]
    for _ in range(random.integers(3, 14)):
        centre = tuple(int(v) for v in random.uniform(0, canvas.size, 2))
        axes = np.array([1, random.uniform(1.2, 2.2)]) * random.uniform(3, 9) * canvas.scale
        cv2.ellipse(
            tone, centre, tuple(int(v) for v in axes), 0, 0, 360, float(random.uniform(0.85, 1.1)), -1, cv2.LINE_AA
        )
    kinds = [((150, 132, 112), (84, 72, 62)), ((186, 140, 96), (120, 84, 54)), ((120, 92, 72), (66, 48, 38))]
    light, dark = kinds[random.integers(3)]
    picture = canvas.paint(cv2.GaussianBlur(tone, (0, 0), 0.8), _shade(random, light, 0.1), _shade(random, dark, 0.1))
    gap = random.uniform(1.2, 6) * canvas.scale
    for edge in np.arange(1, number.max() + 1) * width * canvas.scale:
        cv2.line(
            picture,
            (int(edge), 0),
            (int(edge), canvas.size),
            tuple(random.uniform(12, 36) * np.array([1.1, 1, 0.9])),
            max(2, int(gap)),
        )
    if random.random() < 0.5:
        for _ in range(random.integers(10, 60)):
            _leaf(canvas, picture)
    return picture


def _leaf(canvas: Canvas, picture: Picture) -> None:
    random = canvas.random
    centre = random.uniform(0, canvas.size, 2)
    axes = np.array([1, random.uniform(0.25, 0.6)]) * random.uniform(3, 9) * canvas.scale
    colour = tuple(
        float(v) for v in _shade(random, [(196, 150, 40), (150, 100, 40), (110, 110, 40)][random.integers(3)], 0.2)
    )
    turn = float(random.uniform(0, 180))
    place, size = tuple(int(v) for v in centre), tuple(int(v) + 1 for v in axes)
    cv2.ellipse(picture, tuple(int(v) + 3 for v in centre), size, turn, 0, 360, (30, 25, 20), -1, cv2.LINE_AA)
    cv2.ellipse(picture, place, size, turn, 0, 360, colour, -1, cv2.LINE_AA)


def _weave(canvas: Canvas, picture: Picture, strength: float) -> Picture:
    """Threads and wrinkles on a picture."""
    tone = 1 + strength * (0.6 * canvas.noise(0.35, 1.2) + 0.6 * canvas.noise(1.2, 0.35)) + 0.025 * canvas.noise(60, 25)
    return cv2.multiply(picture, cv2.merge([tone] * 3), dtype=cv2.CV_8U)


def patterned_cloth(canvas: Canvas) -> Picture:
    return _flowers(canvas) if canvas.random.random() < 0.55 else _tartan(canvas)


def _flowers(canvas: Canvas) -> Picture:
    random = canvas.random
    background = random.choice([(235, 228, 214), (60, 70, 100), (150, 60, 60), (190, 205, 190), (232, 214, 120)])
    picture = np.full((canvas.size, canvas.size, 3), _shade(random, background, 0.1), np.uint8)
    pitch = random.uniform(22, 70) * canvas.scale
    colours = random.uniform(20, 240, (5, 3))
    for place in random.uniform(0, canvas.size, (int((canvas.size / pitch) ** 2), 2)):
        size, petals = pitch * random.uniform(0.12, 0.4), random.integers(4, 9)
        turn = random.uniform(0, 360)
        colour = tuple(float(v) for v in np.clip(colours[random.integers(5)] + random.normal(0, 12, 3), 0, 255))
        for k in range(petals):
            angle = np.radians(turn + 360 * k / petals)
            centre = tuple(int(v) for v in place + size * 0.62 * np.array([np.cos(angle), np.sin(angle)]))
            axes = (max(2, int(size * 0.45)), max(2, int(size * 0.24)))
            cv2.ellipse(picture, centre, axes, float(np.degrees(angle)), 0, 360, colour, -1, cv2.LINE_AA)
        middle = tuple(float(v) for v in colours[random.integers(5)])
        cv2.circle(picture, tuple(int(v) for v in place), max(2, int(size * 0.25)), middle, -1, cv2.LINE_AA)
    return _weave(canvas, picture, 0.04)


def _tartan(canvas: Canvas) -> Picture:
    random = canvas.random
    colours = [
        _shade(random, c, 0.3) for c in random.permutation([(150, 30, 36), (26, 60, 46), (28, 36, 84), (225, 215, 190)])
    ]

    def stripes() -> NDArray[np.float32]:
        line = np.zeros((canvas.size, 3), np.float32)
        at = 0
        while at < canvas.size:
            wide = int(random.choice([2, 4, 9, 16, 26]) * random.uniform(0.7, 1.3) * canvas.scale) + 1
            line[at : at + wide] = colours[random.choice(4, p=[0.45, 0.3, 0.15, 0.1])]
            at += wide
        return line

    picture = ((stripes()[None] + stripes()[:, None]) / 2).astype(np.uint8)
    return _weave(canvas, picture, 0.06)


def chequered_cloth(canvas: Canvas) -> Picture:
    random = canvas.random
    pitch = random.choice([random.uniform(6, 14), random.uniform(18, 45)])
    x, y = canvas.ramp()
    wave = 0.06 * pitch * canvas.noise(120)
    checks = (((x + wave) / pitch % 1 < 0.5).astype(np.float32) + ((y + wave) / pitch % 1 < 0.5)) / 2
    base = random.choice([(190, 50, 50), (50, 80, 150), (60, 120, 70), (90, 90, 95), (210, 150, 60)])
    white = _shade(random, (236, 232, 224), 0.05)
    picture = canvas.paint(cv2.GaussianBlur(checks, (0, 0), 0.7), white, (white + base) / 2, _shade(random, base, 0.15))
    return _weave(canvas, picture, 0.05)


def carpet(canvas: Canvas) -> Picture:
    random = canvas.random
    tuft = random.uniform(0.7, 2.0)
    tone = 0.5 + random.uniform(0.1, 0.2) * canvas.noise(tuft) + random.uniform(0.05, 0.13) * canvas.noise(tuft / 2)
    tone += random.uniform(0.0, 0.1) * canvas.noise(random.uniform(5, 15)) + 0.04 * canvas.noise(90)
    colour = random.choice(
        [(120, 110, 100), (150, 60, 55), (70, 90, 120), (170, 155, 130), (60, 60, 62), (110, 120, 90)]
    )
    colour = _shade(random, colour, 0.2)
    return canvas.paint(tone, colour * 0.3, colour, np.minimum(colour * 1.6, 250))


def stone(canvas: Canvas) -> Picture:
    return [_granite, _marble, _concrete][canvas.random.integers(3)](canvas)


def _granite(canvas: Canvas) -> Picture:
    random = canvas.random
    grain = random.uniform(0.7, 2.5)
    tone = 0.5 + 0.13 * canvas.noise(grain) + 0.1 * canvas.noise(2.2 * grain) + 0.07 * canvas.noise(0.4)
    tone += 0.35 * (canvas.noise(1.6 * grain) > 1.5) - 0.35 * (canvas.noise(1.3 * grain) > 1.6)
    base = _shade(random, random.choice([(140, 132, 126), (96, 96, 100), (170, 150, 140), (60, 62, 66)]), 0.15)
    return canvas.paint(cv2.GaussianBlur(tone, (0, 0), 0.6), base * 0.25, base, np.minimum(base * 1.7, 245))


def _marble(canvas: Canvas) -> Picture:
    random = canvas.random
    warp = canvas.noise(140) + 0.5 * canvas.noise(45) + 0.22 * canvas.noise(14)
    veins = np.exp(-np.abs(warp - random.uniform(-0.5, 0.5)) * random.uniform(8, 22))
    more = np.exp(-np.abs(canvas.noise(90) + 0.4 * canvas.noise(25) - 0.4) * 18)
    tone = 0.12 + 0.45 * veins + 0.3 * more + 0.04 * canvas.noise(30) + 0.015 * canvas.noise(0.8)
    light = _shade(random, random.choice([(232, 230, 226), (214, 204, 190), (70, 78, 74)]), 0.05)
    dark = (light * 0.5) if light.mean() > 110 else np.array([200, 196, 186])
    return canvas.paint(tone, light, dark)


def _concrete(canvas: Canvas) -> Picture:
    random = canvas.random
    tone = 0.5 + 0.09 * canvas.noise(70) + 0.06 * canvas.noise(14) + 0.05 * canvas.noise(3) + 0.04 * canvas.noise(0.7)
    tone -= 0.5 * np.maximum(canvas.noise(1.4) - 2.3, 0)
    base = _shade(random, (152, 150, 146), 0.2)
    return canvas.paint(tone, base * 0.55, base, np.minimum(base * 1.35, 240))


def white(canvas: Canvas) -> Picture:
    """Painted or laminated, hardly any texture."""
    random = canvas.random
    base = random.uniform(214, 244) * np.array([1, random.uniform(0.965, 1.0), random.uniform(0.91, 1.01)])
    tone = 0.5 + 0.10 * canvas.noise(120) + random.uniform(0.03, 0.12) * canvas.noise(0.9) + 0.05 * canvas.noise(8)
    picture = canvas.paint(tone, np.minimum(base * 0.94, 252), np.minimum(base * 1.06, 252))
    _wear(canvas, picture, -1, int(random.integers(20, 120)))
    return picture


def black(canvas: Canvas) -> Picture:
    random = canvas.random
    base = _shade(random, random.choice([(34, 34, 36), (24, 26, 30), (46, 40, 38)]), 0.25)
    tone = 0.5 + 0.1 * canvas.noise(100) + random.uniform(0.05, 0.2) * canvas.noise(0.8) + 0.06 * canvas.noise(6)
    picture = canvas.paint(tone, base * 0.6, base * 1.5)
    _wear(canvas, picture, 1, int(random.integers(100, 500)))
    return picture


def _wear(canvas: Canvas, picture: Picture, sign: int, count: int) -> None:
    """Scratches and specks, darker (-1) or lighter (1) than the table."""
    random = canvas.random
    for _ in range(count):
        place = random.uniform(0, canvas.size, 2)
        colour = np.clip(picture[tuple(place.astype(int))] + sign * random.uniform(5, 45), 0, 255)
        colour = tuple(float(v) for v in colour)
        if random.random() < 0.3:
            angle, length = random.uniform(0, np.pi), random.uniform(3, 40) * canvas.scale
            end = place + length * np.array([np.cos(angle), np.sin(angle)])
            cv2.line(
                picture, tuple(int(v) for v in place[::-1]), tuple(int(v) for v in end[::-1]), colour, 1, cv2.LINE_AA
            )
        else:
            size = max(1, int(random.uniform(0.2, 0.7) * canvas.scale))
            cv2.circle(picture, tuple(int(v) for v in place[::-1]), size, colour, -1, cv2.LINE_AA)


def tiles(canvas: Canvas) -> Picture:
    random = canvas.random
    pitch = random.choice([random.uniform(40, 70), random.uniform(90, 150), random.uniform(180, 260)])
    x, y = canvas.ramp()
    shift = random.uniform(0, pitch, 2).astype(np.float32)
    column, row = ((x + shift[0]) / pitch).astype(int), ((y + shift[1]) / pitch).astype(int)
    each = random.normal(0, 1, (row.max() + 1, column.max() + 1)).astype(np.float32)
    # Without individual marks, tiles are mistaken for each other when the photos are placed.
    tone = 0.5 + random.uniform(0.04, 0.12) * each[row, column]
    tone += 0.06 * canvas.noise(25) + random.uniform(0.05, 0.1) * canvas.noise(2.5) + 0.04 * canvas.noise(0.9)
    base = _shade(
        random, random.choice([(220, 214, 204), (176, 120, 90), (120, 130, 136), (90, 110, 104), (200, 190, 160)]), 0.12
    )
    picture = canvas.paint(tone, base * 0.65, base, np.minimum(base * 1.3, 246))
    joint = random.uniform(2, 5) / 2
    away = np.minimum(
        np.abs((x + shift[0] + pitch / 2) % pitch - pitch / 2), np.abs((y + shift[1] + pitch / 2) % pitch - pitch / 2)
    )
    cover = np.clip((joint - away) * canvas.scale + 0.5, 0, 1)
    _wear(canvas, picture, -1, int(random.integers(200, 800)))
    grout = canvas.paint(
        0.5 + 0.15 * canvas.noise(0.8), *(_shade(random, (150, 146, 140), 0.35) * f for f in (0.7, 1.3))
    )
    return _mixed(picture, grout, cover)


def metal(canvas: Canvas) -> Picture:
    """Brushed along x."""
    random = canvas.random
    tone = 0.5 + random.uniform(0.04, 0.1) * canvas.noise(random.uniform(25, 90), 0.35) + 0.05 * canvas.noise(8, 0.8)
    # Features on brush strokes alone slide along them, and contradict the cameras together.
    tone += 0.06 * canvas.noise(140) + 0.06 * canvas.noise(0.9) + 0.05 * canvas.noise(4)
    base = _shade(random, random.choice([(164, 166, 170), (130, 130, 134), (176, 166, 150)]), 0.12)
    picture = canvas.paint(tone, base * 0.6, np.minimum(base * 1.4, 245))
    _wear(canvas, picture, random.choice([-1, 1]), int(random.integers(300, 900)))
    return picture


def plain(canvas: Canvas) -> Picture:
    """A laminated desk of one colour."""
    random = canvas.random
    base = _shade(random, random.choice([(196, 192, 186), (150, 158, 166), (205, 198, 186), (110, 112, 116)]), 0.1)
    tone = 0.5 + 0.08 * canvas.noise(110) + 0.1 * canvas.noise(0.8) + 0.05 * canvas.noise(5)
    picture = canvas.paint(tone, base * 0.85, base * 1.15)
    _wear(canvas, picture, -1, int(random.integers(60, 200)))
    return picture


def _mixed(first: Picture, second: Picture, cover: Tone) -> Picture:
    weight = cv2.convertScaleAbs(cover, alpha=255)
    return cv2.add(
        cv2.multiply(first, cv2.merge([255 - weight] * 3), scale=1 / 255),
        cv2.multiply(second, cv2.merge([weight] * 3), scale=1 / 255),
    )


def paste(
    canvas: Canvas, table: Picture, item: Picture, centre: object, width: float, turn: float
) -> NDArray[np.float64]:
    """Lay a picture ``width`` mm wide on the table, with a soft shadow; its corners (4, 2) in the table's mm.

    ``centre`` is in mm from the table's top left corner, ``turn`` in degrees.
    """
    random = canvas.random
    height = width * item.shape[0] / item.shape[1]
    angle = np.radians(turn)
    along = np.array([np.cos(angle), np.sin(angle)])
    down = np.array([-along[1], along[0]])
    box = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array([width, height]) / 2
    corners = np.asarray(centre) + box[:, :1] * along + box[:, 1:] * down
    pixels = corners * canvas.scale
    spread = random.uniform(0.5, 2.5) * canvas.scale
    low = np.maximum(np.floor(pixels.min(0) - 4 * spread - 2), 0).astype(int)
    high = np.minimum(np.ceil(pixels.max(0) + 4 * spread + 2), canvas.size).astype(int)
    if (high <= low).any():
        return corners
    window = table[low[1] : high[1], low[0] : high[0]]
    shape = (window.shape[1], window.shape[0])
    fine = np.round((pixels - low) * 16).astype(np.int32)
    shadow = np.zeros(window.shape[:2], np.uint8)
    cv2.fillConvexPoly(shadow, fine + np.int32(16 * random.uniform(-0.7, 0.7, 2) * spread), 255, cv2.LINE_AA, 4)
    shadow = cv2.GaussianBlur(shadow, (0, 0), spread)
    strength = random.uniform(0.15, 0.5)
    window[:] = cv2.multiply(window, cv2.merge([1 - strength / 255 * shadow.astype(np.float32)] * 3), dtype=cv2.CV_8U)
    factor = item.shape[1] / (width * canvas.scale)
    if factor > 1.3:
        item = cv2.resize(item, None, fx=1 / factor, fy=1 / factor, interpolation=cv2.INTER_AREA)
    corner = np.array([[0, 0], [item.shape[1], 0], [item.shape[1], item.shape[0]]], np.float32)
    matrix = cv2.getAffineTransform(corner, (pixels[:3] - low).astype(np.float32))
    laid = cv2.warpAffine(item, matrix, shape, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    cover = np.zeros(window.shape[:2], np.uint8)
    cv2.fillConvexPoly(cover, fine, 255, cv2.LINE_AA, 4)
    window[:] = _mixed(window, laid, cover.astype(np.float32) / 255)
    return corners


TOPS: dict[str, Callable[[Canvas], Picture]] = {
    "wood": wood,
    "light_wood": light_wood,
    "dark_wood": dark_wood,
    "planks": planks,
    "patterned_cloth": patterned_cloth,
    "chequered_cloth": chequered_cloth,
    "carpet": carpet,
    "stone": stone,
    "white": white,
    "black": black,
    "tiles": tiles,
    "metal": metal,
    "plain": plain,
}
__all__ = ["TOPS", "Canvas", "fractal", "paste"]
