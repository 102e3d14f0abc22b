"""The kinds of sheets in the scenes, each with random measures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .shapes import Array, Facet, Random, crossed, hinged, page_corners, rest, rolled

_SIZES = ((210.0, 297.0), (215.9, 279.4), (148.0, 210.0), (182.0, 257.0))
# Millimetres between the rulings of a smooth bend; with more, facets would show at the curled edge.
_STRIP = 2.5


@dataclass(frozen=True)
class Bent:
    """A page lying on the table (z = 0): its size in mm, and its facets."""

    kind: str
    width: float
    height: float
    facets: list[Facet]


def _size(random: Random) -> tuple[float, float]:
    width, height = _SIZES[random.choice(len(_SIZES), p=[0.45, 0.25, 0.2, 0.1])]
    return (height, width) if random.random() < 0.2 else (width, height)


def _positions(width: float, height: float, degrees: float) -> Array:
    across = np.array([-np.sin(np.radians(degrees)), np.cos(np.radians(degrees))])
    reach = np.abs((page_corners(width, height) - np.array([width, height]) / 2) @ across).max()
    return np.linspace(-reach, reach, max(3, round(2 * reach / _STRIP)) + 1)[:-1]


def flat(random: Random) -> Bent:
    """A nearly flat sheet: some of its edge is a millimetre or two above the table."""
    width, height = _size(random)
    degrees = random.uniform(0, 180)
    s = _positions(width, height, degrees)
    share = s / np.abs(s).max()
    slope = np.radians(random.uniform(0.0, 1.6)) * np.sin(share * random.uniform(1.0, 2.5) + random.uniform(-1, 1))
    return Bent("flat", width, height, rest(rolled(width, height, degrees, slope, s)))


def curled(random: Random) -> Bent:
    width, height = _size(random)
    degrees = random.choice([random.normal(90, 12), random.normal(0, 12), random.uniform(0, 180)])
    s = _positions(width, height, degrees)
    share = s / np.abs(s).max()
    turn = np.radians(random.uniform(14, 38))
    waves = random.choice(["arch", "bowl", "wave"], p=[0.3, 0.35, 0.35])
    slope = {
        "arch": -turn * share * (1 + 0.3 * random.standard_normal() * share),
        "bowl": turn * share * (1 + 0.3 * random.standard_normal() * share),
        "wave": 0.8 * turn * np.sin(share * random.uniform(2.2, 4.5) + random.uniform(0, 6.3)),
    }[waves]
    return Bent("curled", width, height, rest(rolled(width, height, degrees, slope, s)))


def _across(random: Random, width: float, height: float, share: float, tilt: float) -> tuple[Array, Array]:
    """A line across the page at ``share`` of its height, tilted by up to ``tilt`` degrees."""
    angle = np.radians(random.uniform(-tilt, tilt))
    return np.array([width / 2, share * height]), np.array([np.cos(angle), np.sin(angle)])


def _turned(kind: str, random: Random, make: Callable[[float, float], list[Facet]]) -> Bent:
    width, height = _size(random)
    return Bent(kind, width, height, rest(make(width, height)))


def folded(random: Random) -> Bent:
    angle = np.radians(random.uniform(12, 45)) * random.choice([-1, 1])

    def make(width: float, height: float) -> list[Facet]:
        if random.random() < 0.3:
            tilt = np.radians(90 + random.uniform(-12, 12))
            line = np.array([width * random.uniform(0.35, 0.65), height / 2]), np.array([np.cos(tilt), np.sin(tilt)])
        else:
            line = _across(random, width, height, random.uniform(0.4, 0.6), 10)
        return hinged(width, height, [(*line, angle)])

    return _turned("folded", random, make)


def trifold(random: Random) -> Bent:
    turns = np.radians(random.uniform(12, 42, 2)) * random.choice([-1, 1])
    turns = turns * ([1, -1] if random.random() < 0.5 else [1, 1])

    def make(width: float, height: float) -> list[Facet]:
        lines = [_across(random, width, height, share + random.normal(0, 0.01), 1.5) for share in (1 / 3, 2 / 3)]
        return hinged(width, height, [(*line, turn) for line, turn in zip(lines, turns, strict=True)])

    return _turned("trifold", random, make)


def cross(random: Random) -> Bent:
    width, height = _size(random)
    while True:
        vertex = np.array([width, height]) * random.uniform(0.42, 0.58, 2)
        a = 90 + random.choice([-1, 1]) * random.uniform(7, 16)
        b = 90 + random.choice([-1, 1]) * random.uniform(2, 6)
        facets = rest(crossed(width, height, vertex, (a, b), np.radians(random.uniform(0.2, 6))))
        steepest = np.degrees(np.arccos(min(facet.normal[2] for facet in facets)))
        if 12 < steepest < 36:
            return Bent("crossed", width, height, facets)


def receipt(random: Random) -> Bent:
    width, height = random.choice([58.0, 80.0, 80.0]), random.uniform(200, 330)
    s = _positions(width, height, random.normal(0, 2))
    share = s / np.abs(s).max()
    ends = np.radians(random.uniform(8, 30, 2))
    slope = ends[1] * np.clip(share, 0, 1) ** 2 - ends[0] * np.clip(-share, 0, 1) ** 2
    slope = slope + np.radians(random.uniform(0, 7)) * np.sin(share * random.uniform(3, 7) + random.uniform(0, 6))
    for _ in range(random.integers(0, 3)):
        slope = slope + np.radians(random.uniform(-22, 22)) * (share > random.uniform(-0.6, 0.6))
    return Bent("receipt", width, height, rest(rolled(width, height, random.normal(0, 1), slope, s)))


def book(random: Random) -> Bent:
    """The right page of an open book; its gutter is u = 0 and lies along y."""
    width, height = random.choice([(140.0, 210.0), (155.0, 235.0), (130.0, 198.0), (170.0, 240.0)])
    s = np.linspace(0, width, round(width / 2) + 1)[:-1]
    steep, reach = np.radians(random.uniform(35, 62)), random.uniform(10, 24)
    slope = steep * np.exp(-s / reach) - np.radians(random.uniform(2, 12)) * (s / width) ** random.uniform(0.8, 1.6)
    facets = rolled(width, height, 90, -slope[::-1], -(s[::-1] + s[1] - width / 2))
    corners = np.concatenate([facet.corners for facet in facets])
    # The page's gutter goes to x = 0, its foot to z = 0.
    gutter = corners[np.abs(np.concatenate([facet.flat for facet in facets])[:, 0]) < 1e-6].mean(0)
    shift = np.array([-gutter[0], height / 2, random.uniform(3, 18) - corners[:, 2].min()])
    return Bent("book", width, height, [facet.moved(np.eye(3), shift) for facet in facets])


KINDS: dict[str, Callable[[Random], Bent]] = {
    "flat": flat,
    "curled": curled,
    "folded": folded,
    "crossed": cross,
    "trifold": trifold,
    "book": book,
    "receipt": receipt,
}
