"""Which regions are the photographed sheets, and which of them is at a place of a photo."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.paper.sheet_search import find_sheets
from origami.core.paper.sheets_in_view import sheet_under
from table_scene import flat_sheet, page, table_scene, wood


def square(low: float, high: float) -> np.ndarray:
    return np.array([[low, low], [high, low], [high, high], [low, high]])


def chequered(squares: int = 9) -> np.ndarray:
    """A cloth of light and dark squares, woven."""
    random = np.random.default_rng(4)
    row, column = np.indices((640, 640)) * squares // 640
    light = np.where((row + column) % 2, 0.9, 0.45)[..., None] * np.array([220, 210, 190])
    return np.clip(light + random.normal(scale=6, size=(640, 640, 1)), 0, 255)


def middles(scene) -> np.ndarray:
    return np.array([sheet.outline.mean(axis=0)[:2] for sheet in find_sheets(scene.model, scene.reduced)])


@pytest.mark.slow  # the tests of picking a sheet by a click find both of two sheets as well
@pytest.mark.parametrize(
    "places", [((-0.35, 0.0), (0.4, 0.05)), ((-0.3, -0.2), (0.35, 0.25))], ids=["side by side", "aslant"]
)
def test_photos_aimed_between_two_sheets_are_of_both(places):
    sheets = [(flat_sheet(at, turn, 0.5), page(0.6, seed=k)) for k, (at, turn) in enumerate(zip(places, (5.0, -20.0)))]
    found = middles(table_scene(sheets, wood()))
    assert len(found) == 2
    for at in places:
        assert np.linalg.norm(found - at, axis=1).min() < 0.05


@pytest.mark.parametrize(
    ("table", "scale"),
    [
        pytest.param(wood(), 0.5, id="wood, small"),
        pytest.param(wood(), 0.8, id="wood", marks=pytest.mark.slow),
        pytest.param(chequered(), 0.5, id="chequered, small", marks=pytest.mark.slow),
        pytest.param(chequered(), 0.8, id="chequered"),
        pytest.param(chequered(5), 0.5, id="wide chequered, small", marks=pytest.mark.slow),
        pytest.param(chequered(5), 0.8, id="wide chequered", marks=pytest.mark.slow),
    ],
)
def test_one_sheet_is_one_whatever_the_table(table, scale):
    found = middles(table_scene([(flat_sheet(scale=scale), page())], table, table_points=900))
    assert len(found) == 1
    assert np.linalg.norm(found[0]) < 0.05


def test_the_sheet_under_a_place():
    left, right = square(0, 10), square(20, 30)
    assert sheet_under([left, right], np.array([5.0, 5.0])) == 0
    assert sheet_under([left, right], np.array([25.0, 21.0])) == 1
    assert sheet_under([left, right], np.array([15.0, 5.0])) is None
    assert sheet_under([], np.array([5.0, 5.0])) is None


def test_of_several_sheets_under_a_place_the_smallest():
    outlines = [square(0, 100), square(40, 50)[::-1], square(30, 70)]
    assert sheet_under(outlines, np.array([45.0, 45.0])) == 1
    assert sheet_under(outlines, np.array([35.0, 35.0])) == 2
    assert sheet_under(outlines, np.array([5.0, 5.0])) == 0


def test_a_sheet_that_is_partly_behind_the_camera_is_under_no_place():
    outline = square(0, 10).astype(float)
    outline[2] = np.nan
    assert sheet_under([outline, square(-5, 50)], np.array([2.0, 2.0])) == 1


def test_the_sheet_under_a_pixel_of_a_photo():
    scene = table_scene([(flat_sheet((0.3, 0.1)), page())], wood())
    corners = np.array([[-0.3, -0.3, 0.0], [0.3, -0.3, 0.0], [0.3, 0.3, 0.0], [-0.3, 0.3, 0.0]])
    for camera in scene.model.cameras:
        outlines = [camera.project(corners + np.array([shift, 0.0, 0.0])) for shift in (-0.4, 0.4)]
        for index, shift in enumerate((-0.4, 0.4)):
            assert sheet_under(outlines, camera.project(np.array([shift, 0.0, 0.0]))) == index
