from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.image import gradient_magnitude
from origami.core.paper.paper_mask import paper_mask, regions_of
from scipy import ndimage

SIZE = (150, 200)
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


def _regions(lab):
    return regions_of(lab, gradient_magnitude(lab, 1.0))


def _mask(lab, sheet, reach=15, **options):
    """With everything further than ``reach`` from the sheet's edge known."""
    inside = _where(sheet)
    inner = ndimage.distance_transform_edt(np.pad(inside, 1, mode="edge"))[1:-1, 1:-1] > reach
    outer = ndimage.distance_transform_edt(~inside) > reach
    return paper_mask(_regions(lab), inner, outer, options.get("expected", np.zeros(SIZE)))


def _off(mask, sheet):
    """By how many pixels, on the average along its border, a mask misses the sheet."""
    left, top, right, bottom = sheet
    return (mask != _where(sheet)).sum() / (2 * (right - left + bottom - top))


@pytest.mark.parametrize(
    "sheet",
    [(50, 40, 150, 120), (0, 40, 120, 120), (0, 0, 120, 120), (40, 0, 160, 110)],
    ids=["inside", "left side", "two sides", "top"],
)
@pytest.mark.parametrize("desk", [DESK, (88.0, 0.0, 2.0)], ids=["dark", "a little darker"])
def test_mask_is_the_sheet_wherever_it_leaves_the_photo(sheet, desk):
    mask = _mask(_lab([sheet], desk=desk), sheet)
    assert mask.shape == SIZE and mask.dtype == bool
    assert _off(mask, sheet) < 2


def test_with_nothing_of_the_surroundings_known_all_is_the_sheet():
    nothing = np.zeros(SIZE, bool)
    assert paper_mask(_regions(_lab([])), ~nothing, nothing, np.zeros(SIZE)).all()


def test_print_does_not_make_holes():
    sheet = (40, 30, 160, 120)
    lab = _lab([sheet])
    lab[70:80, 90:110] = (20.0, 0.0, 0.0)
    assert _off(_mask(lab, sheet), sheet) < 2


def test_another_sheet_near_by_is_left_out():
    sheet, second = (20, 30, 100, 120), (115, 30, 180, 120)
    assert _off(_mask(_lab([sheet, second]), sheet), sheet) < 2


def test_between_two_pages_that_look_alike_what_is_expected_decides():
    sheet = (20, 20, 100, 130)
    lab = _lab([(20, 20, 190, 130)])
    expected = np.clip((100 - np.indices(SIZE)[1]) / 15, -1, 1)
    assert _off(_mask(lab, sheet, expected=expected), sheet) < 2
