"""Two facing pages are distinguished from one sheet, however that is folded or curled."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import sheets
from origami.core.checks.open_book import is_open_book
from origami.core.sheet import Sheet

ROWS, COLUMNS = 41, 61
# Both sides of the folds of a sheet folded into four panels, as the paper's set IV, and its ends.
FOLDS = [-1, -0.51, -0.5, 0, 0.01, 0.5, 0.51, 1]


def bent(slopes: np.ndarray, turned: bool = False) -> tuple[Sheet, np.ndarray]:
    """A sheet that has these slopes (radians) across its columns, seen from above, and its flat map."""
    step = 1.5 / (COLUMNS - 1)
    across = np.concatenate([[0], np.cumsum(np.cos(slopes))]) * step
    up = np.concatenate([[0], np.cumsum(np.sin(slopes))]) * step
    v, u = np.meshgrid(np.linspace(0, 1, ROWS), np.linspace(0, 1.5, COLUMNS), indexing="ij")
    # the camera looks down its z axis: y points down, and what rises towards it has a smaller z
    vertices = np.stack([np.broadcast_to(across, u.shape), v, 3 - np.broadcast_to(up, u.shape)], axis=-1)
    number = np.arange(ROWS * COLUMNS).reshape(ROWS, COLUMNS)
    corner, right, down, both = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    first, second = (np.stack(each, -1).reshape(-1, 3) for each in ((corner, down, right), (right, down, both)))
    uv = np.stack([v if turned else u, u if turned else v], axis=-1).reshape(-1, 2)
    flat_boundary = np.zeros(0, np.int64)
    return Sheet(vertices.reshape(-1, 3), np.concatenate([first, second]), [], flat_boundary), uv


def place() -> np.ndarray:
    return np.linspace(-1, 1, COLUMNS - 1)


def book(steepest: float = 25.0) -> np.ndarray:
    """Pages that are level at their outer edges and fall ever more steeply towards the gutter."""
    return np.radians(np.sign(place()) * steepest * (1 - abs(place())) ** 2)


@pytest.mark.parametrize("turned", [False, True])
def test_an_open_book_is_recognised_along_either_side(turned: bool) -> None:
    sheet, uv = bent(book(), turned)
    assert is_open_book(sheet, uv)


def test_a_book_lying_flat_is_not() -> None:
    assert not is_open_book(*bent(book(steepest=4.0)))


@pytest.mark.parametrize(
    "slopes",
    [
        lambda: np.zeros(COLUMNS - 1),
        lambda: np.radians(20 * np.sign(place())),  # folded once, a valley
        lambda: np.radians(-20 * np.sign(place())),  # and a mountain
        lambda: -book(),  # a ridge between two pages that hang down
        lambda: np.radians(30 * place()),  # curled up
        lambda: np.radians(-30 * place()),  # curled down
        lambda: np.radians(25 * np.sin(2 * np.pi * place())),  # waves
        lambda: np.radians(np.where(abs(place()) < 1 / 3, 20, -15)),  # folded twice
        lambda: np.radians(np.interp(place(), FOLDS, [4, 31, -24, 24, -33, -20, 13, 7])),  # folded three times
        lambda: np.radians(np.interp(place(), FOLDS, [7, 13, -20, -33, 24, -24, 31, 4])),
    ],
)
def test_one_sheet_is_not(slopes: Callable[[], np.ndarray]) -> None:
    assert not is_open_book(*bent(slopes()))


@pytest.mark.parametrize(
    "make", [sheets.one_fold, sheets.two_folds, sheets.three_folds, sheets.oblique_fold, sheets.cone, sheets.cross]
)
def test_folded_sheets_are_not(make: Callable[[], sheets.SyntheticSheet]) -> None:
    sheet, uv = sheets.mesh(make())
    assert not is_open_book(sheet, uv)
