"""Printed pages of words, tables and pictures, no two of them alike."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import cv2
import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from .shapes import Random

Picture = NDArray[np.uint8]

_FONTS = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
_TEXT_FONTS = ("DejaVuSans", "DejaVuSerif", "STIXGeneral", "DejaVuSansMono")
_HEADING_FONTS = ("DejaVuSans-Bold", "DejaVuSerif-Bold", "STIXGeneralBol", "DejaVuSansDisplay")
_SYLLABLES = (
    "ba be ci co da di el en fa fo ga ge ha he il in ja jo ka ki la le ma mo na no or os pa pe qua ra ro sa se ta to "
    "un ur va vi wa we xi ya ze tri ster lung berg tion ment ight cho plan gra"
).split()


@cache
def font(name: str, pixels: int) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(str(_FONTS / f"{name}.ttf"), max(6, pixels))


def words(random: Random, count: int) -> list[str]:
    """Made-up words, some of them numbers."""
    made = []
    for _ in range(count):
        if random.random() < 0.08:
            made.append(str(random.integers(1, 99999)))
            continue
        word = "".join(random.choice(_SYLLABLES, random.integers(1, 5)))
        made.append(word.capitalize() if random.random() < 0.15 else word)
    return made


def fractal(random: Random, height: int, width: int, power: float) -> NDArray[np.float32]:
    """Noise whose amplitude falls with frequency to the ``power``; mean 0, deviation 1."""
    fy, fx = np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)[None]
    frequency = np.hypot(fy, fx)
    frequency[0, 0] = 1
    shape = frequency.shape
    spectrum = (random.standard_normal(shape) + 1j * random.standard_normal(shape)) / frequency**power
    spectrum[0, 0] = 0
    noise = np.fft.irfft2(spectrum, (height, width)).astype(np.float32)
    return (noise - noise.mean()) / noise.std()


def photograph(random: Random, height: int, width: int) -> Picture:
    """A landscape-like picture: sky, ridges one before the other, blots of colour."""
    rows = np.linspace(0, 1, height, dtype=np.float32)[:, None]
    hue = random.uniform(0.6, 1.2, 3)
    cloud = fractal(random, height, width, 1.9)
    image = (
        np.stack([110 + 90 * rows + 16 * cloud, 150 + 60 * rows + 12 * cloud, 205 + 20 * rows + 9 * cloud], -1) * hue
    )
    grain = fractal(random, height, width, 1.1)
    top = random.uniform(0.2, 0.45) * height
    for k in range(5):
        ridge = top + k * height * 0.13 + height * 0.1 * fractal(random, 4, width, 1.5)[0]
        below = np.arange(height)[:, None] > ridge[None]
        colour = random.uniform(25, 165, 3)
        image = np.where(below[..., None], colour + 24 * np.roll(grain, 37 * k, 1)[..., None], image)
    for _ in range(random.integers(6, 30)):
        centre = tuple(int(v) for v in random.uniform(0, 1, 2) * [width, height])
        axes = tuple(int(v) + 2 for v in random.uniform(0.005, 0.06, 2) * width)
        colour = tuple(float(v) for v in random.uniform(10, 245, 3))
        cv2.ellipse(image, centre, axes, float(random.uniform(0, 180)), 0, 360, colour, -1, cv2.LINE_AA)
    return np.clip(image, 0, 255).astype(np.uint8)


class Page:
    """A page that is being printed; positions and sizes are millimetres."""

    def __init__(self, random: Random, width: float, height: float, scale: float, paper: Picture, ink: Picture) -> None:
        self.random, self.width, self.height, self.scale = random, width, height, scale
        size = (round(width * scale), round(height * scale))
        self.image = Image.new("RGB", size, tuple(int(v) for v in paper))
        self.draw = ImageDraw.Draw(self.image)
        self.ink = tuple(int(v) for v in ink)
        self.paper = tuple(int(v) for v in paper)
        self.accent = tuple(int(v) for v in np.clip(random.uniform(20, 190, 3), 0, 255))
        self.margin = min(width, height) * random.uniform(0.06, 0.13)
        self.text_font = _TEXT_FONTS[random.choice(len(_TEXT_FONTS), p=[0.35, 0.3, 0.25, 0.1])]
        self.heading_font = _HEADING_FONTS[random.integers(len(_HEADING_FONTS))]

    def px(self, millimetres: float) -> float:
        return millimetres * self.scale

    def line(self, x: float, y: float, text: str, size: float, name: str | None = None, fill: object = None) -> float:
        """One line of text with its top left corner at (x, y); its width."""
        drawn = font(name or self.text_font, round(self.px(size)))
        self.draw.text((self.px(x), self.px(y)), text, font=drawn, fill=fill or self.ink)
        return drawn.getlength(text) / self.scale

    def paragraph(self, x: float, y: float, width: float, lines: int, size: float) -> float:
        """Lines of words, the last one short; the y below them."""
        drawn = font(self.text_font, round(self.px(size)))
        pool = words(self.random, int(lines * width / size / 2) + 8)
        for number in range(lines):
            most = self.px(width) * (self.random.uniform(0.3, 0.9) if number == lines - 1 else 1)
            text = ""
            while pool and drawn.getlength(text + " " + pool[0]) <= most:
                text = f"{text} {pool.pop(0)}".strip()
            self.draw.text((self.px(x), self.px(y)), text, font=drawn, fill=self.ink)
            y += 1.35 * size
        return y

    def box(self, x: float, y: float, across: float, down: float, **how: object) -> None:
        corners = [self.px(x), self.px(y), self.px(x + max(across, 0.1)), self.px(y + max(down, 0.1))]
        self.draw.rectangle(corners, **how)

    def picture(self, x: float, y: float, width: float, height: float) -> None:
        made = photograph(self.random, 240, max(24, int(240 * width / height)))
        made_image = Image.fromarray(made).resize((round(self.px(width)), round(self.px(height))), Image.BICUBIC)
        self.image.paste(made_image, (round(self.px(x)), round(self.px(y))))

    def logo(self, x: float, y: float, size: float) -> None:
        random = self.random
        for _ in range(random.integers(2, 6)):
            a, b = np.sort(random.uniform(0, size, (2, 2)), axis=0)
            corners = [self.px(x + a[0]), self.px(y + a[1]), self.px(x + b[0] + 1), self.px(y + b[1] + 1)]
            colour = tuple(int(v) for v in random.uniform(10, 220, 3))
            if random.random() < 0.5:
                self.draw.ellipse(corners, fill=colour)
            else:
                self.draw.rectangle(corners, fill=colour)

    def table(self, x: float, y: float, width: float, rows: int, size: float) -> float:
        random, columns = self.random, int(self.random.integers(3, 6))
        pitch = 1.8 * size
        self.box(x, y, width, pitch, fill=self.accent)
        for row in range(rows):
            top = y + row * pitch
            if row:
                self.box(x, top, width, 0.15, fill=self.ink)
            for column in range(columns):
                text = str(random.integers(1, 99999)) if column and row else words(random, 1)[0].capitalize()
                fill = self.paper if row == 0 else self.ink
                self.line(x + width * column / columns + 1, top + 0.25 * size, text, size, fill=fill)
        self.draw.rectangle([self.px(x), self.px(y), self.px(x + width), self.px(y + rows * pitch)], outline=self.ink)
        return y + (rows + 1) * pitch

    def pixels(self) -> Picture:
        """The page as it leaves the printer, its edges softened by half a pixel."""
        return cv2.GaussianBlur(np.asarray(self.image), (0, 0), 0.6)


def _text_page(page: Page, heading: bool = True) -> None:
    random, margin = page.random, page.margin
    size = random.uniform(2.3, 3.4) * min(1.0, page.width / 150)
    y = margin
    if heading:
        text = " ".join(words(random, int(random.integers(2, 5)))).title()
        page.line(margin, y, text, 2.2 * size, page.heading_font)
        y += 4.2 * size
    columns = 2 if page.width > 140 and random.random() < 0.3 else 1
    gap = 6.0
    width = (page.width - 2 * margin - (columns - 1) * gap) / columns
    for column in range(columns):
        top = y
        while top < page.height - margin - 4 * size:
            x = margin + column * (width + gap)
            what = random.random()
            room = page.height - margin - top
            if what < 0.1 and room > 60:
                page.picture(x, top, width, 40)
                top += 40 + size
            elif what < 0.18 and room > 14 * size:
                top = page.table(x, top, width, 5, size)
            else:
                lines = int(min(random.integers(2, 9), room / (1.35 * size)))
                if lines < 1:
                    break
                top = page.paragraph(x, top, width, lines, size) + 0.9 * size


def _letter(page: Page) -> None:
    random, margin = page.random, page.margin
    page.logo(margin, margin, 16)
    page.line(margin + 22, margin + 3, " ".join(words(random, 2)).title(), 7, page.heading_font, page.accent)
    page.line(margin + 22, margin + 12, " ".join(words(random, 5)), 2.8)
    y = margin + 34
    y = page.paragraph(margin, y, 60, 4, 3.2) + 9
    for _ in range(int(random.integers(2, 5))):
        y = page.paragraph(margin, y, page.width - 2 * margin, int(random.integers(3, 7)), 3.1) + 3
        if y > page.height - margin - 50:
            break
    if y < page.height - margin - 60 and random.random() < 0.6:
        y = page.table(margin, y, page.width - 2 * margin, int(random.integers(3, 7)), 3.0)
    page.line(margin, page.height - margin - 4, " ".join(words(random, 8)), 2.4, fill=page.accent)


def _sparse(page: Page) -> None:
    """A letterhead with a few lines."""
    random, margin = page.random, page.margin
    page.logo(margin, margin, 14)
    page.line(margin + 20, margin + 2, " ".join(words(random, 2)).title(), 7, page.heading_font)
    page.paragraph(margin, margin + 32, 55, 3, 3.2)
    page.paragraph(margin, page.height * random.uniform(0.35, 0.5), page.width - 2 * margin, 3, 3.2)
    page.line(margin, page.height - margin - 4, " ".join(words(random, 9)), 2.4)


def _form(page: Page) -> None:
    random, margin = page.random, page.margin
    page.line(margin, margin, " ".join(words(random, 3)).upper(), 6, page.heading_font)
    y = margin + 14
    while y < page.height - margin - 12:
        cells = int(random.integers(1, 4))
        width = (page.width - 2 * margin) / cells
        height = random.uniform(8, 13)
        for cell in range(cells):
            x = margin + cell * width
            page.box(x, y, width - 2, height, outline=page.ink, width=max(1, round(page.px(0.25))))
            page.line(x + 1, y + 0.7, " ".join(words(random, 2)), 2.1)
            if random.random() < 0.6:
                page.line(x + 3, y + 3.6, words(random, 1)[0].title(), 3.6, "DejaVuSerif-Italic", (40, 50, 130))
        y += height + random.uniform(1, 4)


def _poster(page: Page) -> None:
    random, margin = page.random, page.margin
    y = margin
    for _ in range(int(random.integers(1, 3))):
        page.line(margin, y, words(random, 1)[0].upper(), page.width / 9, page.heading_font, page.accent)
        y += page.width / 7
    height = min(page.height * 0.4, page.height - y - margin - 30)
    if height > 20:
        page.picture(margin, y, page.width - 2 * margin, height)
        y += height + 6
    while y < page.height - margin - 12:
        y = page.paragraph(margin, y, page.width - 2 * margin, 2, 4.2) + 3


def _cover(page: Page) -> None:
    """A picture up to the edge of the paper, with a title."""
    random = page.random
    made = photograph(random, 900, round(900 * page.width / page.height))
    page.image.paste(Image.fromarray(made).resize(page.image.size, Image.BICUBIC))
    y = page.height * random.uniform(0.06, 0.5)
    light = (245, 240, 225) if random.random() < 0.6 else (20, 20, 30)
    for _ in range(int(random.integers(1, 4))):
        page.line(page.margin, y, words(random, 1)[0].title(), page.width / 8, page.heading_font, light)
        y += page.width / 6
    page.paragraph(page.margin, page.height * 0.8, page.width - 2 * page.margin, 3, 3.4)


def _receipt(page: Page) -> None:
    random = page.random
    size = page.width / 22
    y = 6.0
    page.line(page.width * 0.18, y, words(random, 1)[0].upper(), 2 * size, page.heading_font)
    y += 4 * size
    for _ in range(3):
        page.line(page.width * 0.15, y, " ".join(words(random, 2)), 0.9 * size)
        y += 1.3 * size
    while y < page.height - 30:
        text = " ".join(words(random, 2))[:17]
        page.line(3, y, text, 0.95 * size, "DejaVuSansMono")
        page.line(page.width * 0.77, y, f"{random.uniform(1, 99):.2f}", 0.95 * size, "DejaVuSansMono")
        y += 1.55 * size
        if random.random() < 0.08:
            page.line(3, y, "-" * 26, 0.95 * size, "DejaVuSansMono")
            y += 1.5 * size
    page.line(3, y, f"TOTAL {random.uniform(10, 900):.2f}", 1.6 * size, "DejaVuSansMono-Bold")
    x = 8.0
    while x < page.width - 8:
        bar = random.uniform(0.3, 1.4)
        page.box(x, y + 4 * size, bar, 11, fill=page.ink)
        x += bar + random.uniform(0.3, 1.3)


LAYOUTS = {
    "text": _text_page,
    "letter": _letter,
    "sparse": _sparse,
    "form": _form,
    "poster": _poster,
    "cover": _cover,
    "receipt": _receipt,
}


def printed(
    random: Random, layout: str, width: float, height: float, scale: float, paper: object, ink: object
) -> Picture:
    """A printed page as RGB at ``scale`` pixels per millimetre; ``paper`` and ``ink`` are sRGB colours."""
    page = Page(random, width, height, scale, np.asarray(paper), np.asarray(ink))
    LAYOUTS[layout](page)
    return page.pixels()
