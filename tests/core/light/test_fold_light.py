"""Beside a fold, shading goes and print stays."""

import numpy as np
import pytest
from origami.core.light.fold_light import light_at_folds

ROWS, COLUMNS, FOLD = 60, 50, 30


def normals(angle=60.0):
    """Two plane halves that meet at a fold after row 30; zero outside the sheet."""
    half = np.radians(angle / 2)
    side = np.where(np.arange(ROWS) < FOLD, -1, 1)[:, None] * np.ones(COLUMNS)
    each = np.stack([0 * side, side * np.sin(half), np.cos(half) + 0 * side], axis=-1)
    each[[0, -1]] = each[:, [0, -1]] = 0
    return each


def even(brightness):
    """Log light (h, w, 3) of cells that are all even."""
    return np.repeat(brightness[..., None], 3, axis=-1)


def fine_light(brightness, angle=60.0, share=1.0, blank=None):
    known = np.ones(brightness.shape, bool)
    blank = brightness > -0.08 if blank is None else blank
    shares = np.broadcast_to(np.float32(share), brightness.shape)
    return light_at_folds(even(brightness), shares, known, blank, normals(angle))[..., 1]


def wedge():
    """Light that falls towards the fold from one side, and jumps back at it."""
    rows = np.arange(ROWS, dtype=float)
    fall = np.where(rows < FOLD, -0.3 * np.clip(1 - (FOLD - 1 - rows) / 6, 0, 1), 0)
    return np.repeat(fall[:, None], COLUMNS, axis=1)


def test_shading_that_deepens_towards_the_fold_is_light():
    left = (wedge() - fine_light(wedge()))[3:-3, 5:-5]
    shading = np.abs(wedge())[3:-3, 5:-5]
    assert np.abs(left).mean() < 0.3 * shading.mean()
    assert np.abs(left).max() < 0.6 * shading.max()  # within a cell of the jump


@pytest.mark.parametrize("tint", [0.06, 0.2])
def test_a_tinted_row_of_a_table_beside_the_fold_stays(tint):
    row = np.zeros((ROWS, COLUMNS))
    row[33:38, 10:40] = -tint
    fine = fine_light(row, blank=row > -0.08)
    assert np.abs(fine).max() < 0.1 * tint


def test_a_flat_sheet_has_no_light_of_folds():
    np.testing.assert_array_equal(fine_light(wedge(), angle=2.0), 0)


def test_between_letters_nothing_is_light():
    random = np.random.default_rng(1).uniform(-0.08, 0, (ROWS, COLUMNS))
    np.testing.assert_array_equal(fine_light(random, share=0.2), 0)
