"""Sides of the page become straight, and the correction stays near them."""

from __future__ import annotations

import numpy as np
import sheets
from origami.core.straighten import straighten_sides


def test_straight_sides_stay_where_they_are():
    sheet, flat = sheets.mesh(sheets.one_fold(), 0.05)
    np.testing.assert_allclose(straighten_sides(sheet, flat), flat, atol=1e-12)


def test_a_wave_goes_and_fades_inwards():
    sheet, flat = sheets.mesh(sheets.plane(), 0.02)
    top = flat[:, 1] < 1e-9
    waving = flat.copy()
    waving[top, 1] += 0.01 * np.sin(20 * flat[top, 0])
    straight = straighten_sides(sheet, waving)
    assert np.ptp(straight[top, 1]) < 1e-12
    moved = np.abs(straight - waving)[:, 1]
    # At most exp(-x) of the correction is left x fading lengths away from a straight edge.
    far = flat[:, 1] > 0.15
    assert moved[far].max() < 1.5 * np.exp(-5) * moved[top].max()
    np.testing.assert_allclose(straight[:, 0], waving[:, 0], atol=1e-9)


def test_a_round_sheet_is_left_alone():
    sheet, flat = sheets.mesh(sheets.plane(), 0.05)
    wide = flat.copy()
    wide[:, 0] += 0.2 * np.sin(np.pi * flat[:, 1])
    np.testing.assert_array_equal(straighten_sides(sheet, wide), wide)
