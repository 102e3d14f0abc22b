from __future__ import annotations

import numpy as np
import pytest
from origami.core.paper_mask import paper_mask

SIZE = (150, 200)
NOTHING = np.zeros((0, 2))
PAPER, DESK = (92.0, 0.0, 2.0), (45.0, 4.0, 8.0)


def _lab(sheets, desk=DESK, paper=PAPER):
    """Perceptual colours of plain rectangles ``left, top, right, bottom`` on a plain desk, with a little noise."""
    lab = np.empty((*SIZE, 3), np.float32)
    lab[:] = desk
    for sheet in sheets:
        lab[_where(sheet)] = paper
    return lab + np.random.default_rng(0).normal(scale=0.3, size=lab.shape).astype(np.float32)


def _where(sheet):
    left, top, right, bottom = sheet
    inside = np.zeros(SIZE, bool)
    inside[top:bottom, left:right] = True
    return inside


def _grid(left, top, right, bottom, step=4.0):
    x, y = np.meshgrid(np.arange(left, right, step), np.arange(top, bottom, step))
    return np.stack([x.ravel(), y.ravel()], axis=1)


def _off(mask, sheet):
    """By how many pixels, on the average along its border, a mask misses the sheet."""
    left, top, right, bottom = sheet
    return (mask != _where(sheet)).sum() / (2 * (right - left + bottom - top))


@pytest.mark.parametrize(
    "sheet",
    [(50, 40, 150, 120), (0, 40, 120, 120), (0, 0, 120, 150), (0, 0, 200, 110), (3, 3, 197, 147), (5, 0, 200, 150)],
    ids=["inside", "left side", "three sides", "three sides, wide", "narrow margin", "all but a narrow margin"],
)
def test_mask_is_the_sheet_wherever_it_leaves_the_photo(sheet):
    left, top, right, bottom = sheet
    mask = paper_mask(_lab([sheet]), _grid(left + 15, top + 15, right - 15, bottom - 15), NOTHING)
    assert mask.shape == SIZE and mask.dtype == bool
    assert _off(mask, sheet) < 2


def test_sheet_that_fills_the_photo_is_all_of_it():
    assert paper_mask(_lab([(0, 0, 200, 150)]), _grid(30, 30, 170, 120), NOTHING).all()


def test_desk_little_darker_is_told_from_the_sheet_and_one_just_like_it_is_kept():
    sheet = (50, 40, 150, 120)
    seeds = _grid(60, 50, 140, 110)
    assert _off(paper_mask(_lab([sheet], desk=(88.0, 0.0, 2.0)), seeds, NOTHING), sheet) < 2
    assert paper_mask(_lab([sheet], desk=PAPER), seeds, NOTHING).all()


def test_prints_without_seeds_do_not_make_holes():
    sheet = (40, 30, 160, 120)
    lab = _lab([sheet])
    lab[70:80, 90:110] = (20.0, 0.0, 0.0)
    seeds = _grid(50, 40, 150, 110)
    away = (np.abs(seeds - [100, 75]) > [14, 9]).any(axis=1)
    assert _off(paper_mask(lab, seeds[away], NOTHING), sheet) < 2


def test_another_sheet_is_left_out():
    sheet, second = (20, 30, 100, 120), (115, 30, 180, 120)
    mask = paper_mask(_lab([sheet, second]), _grid(30, 40, 90, 110), NOTHING)
    assert _off(mask, sheet) < 2


def test_of_two_adjoining_pages_the_seeded_is_taken_up_to_about_the_middle():
    sheet = (20, 20, 100, 130)
    lab = _lab([(20, 20, 200, 130)])
    lab[20:130, 99:101] -= 10
    mask = paper_mask(lab, _grid(30, 30, 92, 122), _grid(110, 30, 200, 122))
    assert _off(mask, sheet) < 2
