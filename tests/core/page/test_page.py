"""Pages: cut along their sides, upright, in true size."""

from __future__ import annotations

import numpy as np
import pytest
import sheets
from cut_sheets import outer_part
from origami.core.errors import UsageError
from origami.core.page.page import PaperSize, framed, lay_out, turn_of

UP = np.array([0.0, -1.0])


def _turned(flat: np.ndarray, degrees: float) -> np.ndarray:
    angle = np.radians(degrees)
    return flat @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) * 3.0 + 7.0


@pytest.mark.parametrize("degrees", [0, 12, 100, 185, 275])
@pytest.mark.parametrize("make", [sheets.plane, sheets.one_fold])
def test_sides_lie_along_the_axes_and_up_is_the_photo_s_up(make, degrees):
    sheet, flat = sheets.mesh(make(), 0.05)
    page = lay_out(sheet, _turned(flat, degrees), sheets.camera(), UP)
    np.testing.assert_allclose(page.uv, flat, atol=1e-6)
    assert page.height == pytest.approx(1.0)
    assert page.width == pytest.approx(0.7)
    assert page.unit == "page heights"
    assert page.world_scale is None


def test_quarter_turns_are_clockwise():
    sheet, flat = sheets.mesh(sheets.plane(), 0.05)
    page = lay_out(sheet, flat, sheets.camera(), UP, quarter_turns=1)
    assert page.width == pytest.approx(1 / 0.7)
    top_left = np.argmin(flat.sum(1))
    np.testing.assert_allclose(page.uv[top_left], [page.width, 0], atol=1e-9)


def test_photo_taken_from_the_side():
    """With the photo's right as up, the page's left side is at the bottom."""
    sheet, flat = sheets.mesh(sheets.plane(), 0.05)
    page = lay_out(sheet, flat, sheets.camera((0, 0)), np.array([1.0, 0.0]))
    top_left = np.argmin(flat.sum(1))
    np.testing.assert_allclose(page.uv[top_left], [0, page.height], atol=1e-9)


def test_known_size_gives_millimetres_whichever_way_round():
    sheet, flat = sheets.mesh(sheets.plane(), 0.05)
    for paper in (PaperSize(140.0, 200.0), PaperSize(200.0, 140.0)):
        page = lay_out(sheet, flat, sheets.camera(), UP, paper)
        assert (page.width, page.height, page.unit) == (pytest.approx(140), pytest.approx(200), "mm")
        assert page.world_scale == pytest.approx(200.0)


def test_roll_width_alone_gives_millimetres():
    sheet, flat = sheets.mesh(sheets.plane(), 0.05)
    page = lay_out(sheet, flat, sheets.camera(), UP, PaperSize(80.0))
    assert page.width == pytest.approx(80.0)
    assert page.height == pytest.approx(80.0 / 0.7)


def test_roll_width_is_the_width_of_the_page_as_it_is_read():
    sheet, flat = sheets.mesh(sheets.plane(), 0.05)
    page = lay_out(sheet, flat, sheets.camera(), UP, PaperSize(80.0), quarter_turns=1)
    assert (page.width, page.height) == (pytest.approx(80.0), pytest.approx(80.0 * 0.7))


def test_a_named_size_is_met_exactly_where_the_shape_agrees():
    sheet, flat = sheets.mesh(sheets.plane(), 0.05)
    page = lay_out(sheet, flat * [1.01, 1.0], sheets.camera(), UP, PaperSize(140.0, 200.0))
    assert (page.width, page.height) == (pytest.approx(140.0), pytest.approx(200.0))


def test_another_shape_than_the_named_one_keeps_its_own():
    sheet, flat = sheets.mesh(sheets.plane(), 0.05)
    page = lay_out(sheet, flat * [1.2, 1.0], sheets.camera(), UP, PaperSize(140.0, 200.0))
    assert page.width / page.height == pytest.approx(0.84)
    assert page.width * page.height == pytest.approx(140 * 200)


def _waving(amplitude: float):
    """A flat page whose right side waves, and the waves reach 1 % into the page."""
    sheet, flat = sheets.mesh(sheets.plane(), 0.02)
    near = np.exp(-(sheets.WIDTH - flat[:, 0]) / 0.01)
    return sheet, flat, flat + np.c_[amplitude * near * np.sin(9 * flat[:, 1]), np.zeros(len(flat))]


def test_the_page_ends_along_its_waving_side_and_the_print_stays():
    sheet, _, waving = _waving(0.01)
    page = lay_out(sheet, waving, sheets.camera(), UP)
    assert page.width == pytest.approx(sheets.WIDTH, abs=0.01)
    np.testing.assert_allclose(page.uv - page.uv[0], waving - waving[0], atol=1e-4)


def test_corners_that_are_wrong_neither_turn_the_page_nor_move_its_sides():
    sheet, flat = sheets.mesh(sheets.plane(), 0.02)
    wrong = flat.copy()
    for corner, move in (((0, 0), (-0.02, 0.01)), ((sheets.WIDTH, 1), (0.015, 0.02))):
        reach = np.linalg.norm(flat - corner, axis=1)
        wrong += np.maximum(1 - reach / 0.06, 0)[:, None] * move
    page = lay_out(sheet, _turned(wrong, 7), sheets.camera(), UP)
    inner = (np.abs(flat - [0.35, 0.5]) < [0.25, 0.4]).all(1)
    np.testing.assert_allclose(page.uv[inner], flat[inner], atol=5e-4)
    assert page.width == pytest.approx(sheets.WIDTH, abs=5e-4)


def test_a_bite_out_of_a_corner_does_not_turn_the_page():
    """A sheet without a corner shows corners elsewhere; the remaining sides still show its angle."""
    sheet, flat = sheets.mesh(sheets.plane(), 0.02)
    gone = (flat[:, 0] < 0.25) & (flat[:, 1] > 0.7)
    inside = ~gone[sheet.triangles].any(1)
    bitten = outer_part(sheet, inside)
    used = np.unique(sheet.triangles[inside])
    page = lay_out(bitten, _turned(flat[used], 7), sheets.camera(), UP)
    angle = np.degrees(np.arctan2(*(np.diff(page.uv[flat[used][:, 1] < 1e-9][[0, -1]], axis=0)[0][::-1])))
    assert abs(angle) < 0.3


def test_nothing_of_a_torn_side_is_cut_off():
    sheet, flat, waving = _waving(0.05)
    page = lay_out(sheet, waving, sheets.camera(), UP)
    right = flat[:, 0] > sheets.WIDTH - 1e-9
    assert np.ptp(page.uv[right, 0]) > 0.05
    assert (page.uv[right, 0] <= page.width).all()
    assert page.width == pytest.approx(sheets.WIDTH + 0.05, abs=2e-3)


@pytest.mark.parametrize("degrees", [0, 90, 180, 270])
def test_the_turn_of_a_page_is_reported(degrees):
    up = {0: (0, -1), 90: (-1, 0), 180: (0, 1), 270: (1, 0)}[degrees]
    sheet, flat = sheets.mesh(sheets.one_fold(), 0.05)
    page = lay_out(sheet, flat, sheets.camera(), np.array(up, float))
    assert turn_of(sheet, page, sheets.camera()) == degrees


def _page_of_plane(paper: PaperSize | None = None):
    sheet, flat = sheets.mesh(sheets.plane(), 0.05)
    return lay_out(sheet, flat, sheets.camera(), UP, paper)


def test_a_frame_where_the_page_ends_changes_nothing():
    page = _page_of_plane()
    same = framed(page, np.array([[0, 0], [0.7, 0], [0.7, 1], [0, 1]]))
    np.testing.assert_allclose(same.uv, page.uv, atol=1e-12)
    assert (same.width, same.height) == pytest.approx((0.7, 1.0))


def test_a_smaller_frame_cuts():
    page = _page_of_plane(PaperSize(140.0, 200.0))
    cut = framed(page, np.array([[10.0, 20], [130, 20], [130, 180], [10, 180]]))
    assert (cut.width, cut.height) == pytest.approx((120.0, 160.0))
    np.testing.assert_allclose(cut.uv, page.uv - [10, 20], atol=1e-9)
    assert cut.world_scale == page.world_scale


def test_a_frame_around_a_slanting_page_straightens_it():
    """A trapezium of known corners becomes the rectangle; straight lines stay straight."""
    page = _page_of_plane()
    corners = np.array([[0.1, 0.0], [0.6, 0.0], [0.7, 1.0], [0.0, 1.0]])
    straight = framed(page, corners)
    assert straight.height == 1.0
    assert straight.width == pytest.approx(0.6 / np.hypot(0.1, 1.0))
    for corner, target in zip(corners, [(0, 0), (1, 0), (1, 1), (0, 1)]):
        near = np.argmin(np.linalg.norm(page.uv - corner, axis=1))
        if np.allclose(page.uv[near], corner):
            np.testing.assert_allclose(straight.uv[near] / [straight.width, 1.0], target, atol=1e-9)
    middle_row = np.abs(page.uv[:, 1] - 0.5) < 1e-9
    assert np.ptp(straight.uv[middle_row, 1]) < 1e-9


@pytest.mark.parametrize(
    "corners",
    [
        [[0, 0], [0.7, 0], [0, 1], [0.7, 1]],  # crossed
        [[0, 1], [0.7, 1], [0.7, 0], [0, 0]],  # mirrored
        [[0, 0], [0.7, 0], [0.2, 0.2], [0, 1]],  # one inside
        [[0, 0], [0.35, 0], [0.7, 0], [0, 1]],  # no area at one corner
    ],
)
def test_corners_of_no_page_are_refused(corners):
    with pytest.raises(UsageError, match="corners"):
        framed(_page_of_plane(), np.array(corners, float))
