"""Gates between the steps: plausible results pass, each absurd one is refused with its figure and a message."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from origami.core.camera import Camera
from origami.core.checks.gates import Refusal, refuse_flat, refuse_page, refuse_sheet
from origami.core.sheet import FlatMap, Sheet

SIDE = 21


def sheet(width: float = 1.0, height: float = 1.0, fold: float = 0.0) -> Sheet:
    """A sheet from (0, 0) to (width, height), its right half turned up by ``fold`` degrees about the middle."""
    u, v = (axis.ravel() for axis in np.meshgrid(np.linspace(0, width, SIDE), np.linspace(0, height, SIDE)))
    beyond = np.maximum(u - width / 2, 0)
    angle = np.radians(fold)
    xyz = np.stack([u - beyond * (1 - np.cos(angle)), v, -beyond * np.sin(angle)], 1)
    index = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    boundary = np.concatenate([index[0, :-1], index[:-1, -1], index[-1, :0:-1], index[:0:-1, 0]])
    ridges = (index[:, SIDE // 2],) if fold else ()
    return Sheet(xyz, triangles, ridges, boundary)


def flat_of(width: float = 1.0, height: float = 1.0) -> np.ndarray:
    u, v = np.meshgrid(np.linspace(0, width, SIDE), np.linspace(0, height, SIDE))
    return np.stack([u.ravel(), v.ravel()], 1)


def camera(x: float) -> Camera:
    """A camera 1.5 m above the sheet's plane that sees x - 0.75 to x + 0.75 and as much of y about 0.5."""
    center = np.array([x, 0.5, -1.5])
    return Camera(f"{x}", 1000, 1000, 1000.0, np.array([500.0, 500]), np.zeros(2), np.eye(3), -center)


CAMERAS = [camera(x) for x in (0.4, 0.5, 0.6)]


def is_refused(refusal: Refusal | None, gate: str, figure: float, *, hopeless: bool) -> None:
    assert refusal is not None
    assert gate in refusal.gate
    assert refusal.figure == pytest.approx(figure, abs=0.01)
    assert refusal.hopeless is hopeless
    assert refusal.cause[0].isupper()
    assert not refusal.cause.endswith(".")


class TestSheet:
    @pytest.mark.parametrize("fold", [0.0, 60.0, 120.0])
    def test_plausible(self, fold: float) -> None:
        assert refuse_sheet(sheet(fold=fold), CAMERAS) is None

    def test_not_finite(self) -> None:
        good = sheet()
        vertices = good.vertices.copy()
        vertices[5] = np.nan
        refusal = refuse_sheet(replace(good, vertices=vertices), CAMERAS)
        assert refusal is not None
        assert refusal.hopeless

    def test_a_fold_onto_itself(self) -> None:
        is_refused(refuse_sheet(sheet(fold=165.0), CAMERAS), "fold", 165.0, hopeless=False)

    def test_larger_than_what_the_photos_show(self) -> None:
        """All three photos show x up to 1.15; of twenty columns of triangles, those with their middle there count."""
        is_refused(refuse_sheet(sheet(width=2.0), CAMERAS), "in view", 0.575, hopeless=False)
        is_refused(refuse_sheet(sheet(width=4.0), CAMERAS), "in view", 0.30, hopeless=True)

    def test_of_two_photos_both_must_show_it(self) -> None:
        assert refuse_sheet(sheet(), CAMERAS[:2]) is None


class TestFlat:
    def test_plausible(self) -> None:
        assert refuse_flat(sheet(fold=60.0), 297 * flat_of()) is None
        assert refuse_flat(sheet(), flat_of() * [1.01, 1]) is None

    def test_not_finite(self) -> None:
        refusal = refuse_flat(sheet(), np.full((SIDE * SIDE, 2), np.nan))
        assert refusal is not None
        assert refusal.hopeless

    @pytest.mark.parametrize("stretch, hopeless", [(0.04, False), (0.2, True)])
    def test_stretched_more_than_paper(self, stretch: float, hopeless: bool) -> None:
        """Longer in one direction only: relative to the map's own scale, half of it is stretch, half shrinkage."""
        found = np.sqrt(1 + stretch) - 1
        is_refused(refuse_flat(sheet(), flat_of() * [1 + stretch, 1]), "stretch", found, hopeless=hopeless)


class TestPage:
    def test_plausible(self) -> None:
        assert refuse_page(sheet(), FlatMap(flat_of(), 1.0, 1.0, "page heights", None)) is None
        assert refuse_page(sheet(), FlatMap(flat_of(210, 297), 210.0, 297.0, "mm", 210.0)) is None

    @pytest.mark.parametrize("height, hopeless", [(1.25, False), (2.0, True)])
    def test_white(self, height: float, hopeless: bool) -> None:
        refusal = refuse_page(sheet(), FlatMap(flat_of() / height, 1 / height, 1.0, "page heights", None))
        is_refused(refusal, "outside the sheet", 1 - 1 / height, hopeless=hopeless)
        assert refusal is not None
        assert f"{100 * (1 - 1 / height):.0f} %" in refusal.cause

    def test_no_size(self) -> None:
        refusal = refuse_page(sheet(), FlatMap(flat_of(), np.nan, 1.0, "page heights", None))
        assert refusal is not None
        assert refusal.hopeless
