"""A run can read the outline and creases that it writes, and the picture shows them."""

from __future__ import annotations

import json

import numpy as np
import pytest
from folded import folded_sheet
from origami.core.errors import StepFailed
from origami.core.numeric.polygon import filled_polygon, signed_area
from origami.origami_addon.drawn_files import read_drawn
from origami.origami_addon.export.outline_files import (
    crease_ends,
    write_creases,
    write_outline,
    write_outline_picture,
)
from origami.origami_addon.settings import RunSettings
from origami.origami_addon.settings_json import from_json
from PIL import Image

NAME = "a/Foto ü 0.jpg"


@pytest.fixture(scope="module")
def case():
    return folded_sheet()


def test_creases_end_where_the_reference_photo_shows_their_ends(case):
    camera = case.model.cameras[0]
    ends = crease_ends(case.sheet, camera)
    assert ends.shape == (len(case.sheet.ridges), 2, 2)
    for found, ridge in zip(ends, case.sheet.ridges):
        np.testing.assert_allclose(found, camera.project(case.sheet.vertices[ridge])[[0, -1]])


def test_what_is_written_is_taken_again(case, tmp_path):
    polygon, creases = case.state.region.outline.polygon, crease_ends(case.sheet, case.model.cameras[0])
    write_outline(tmp_path / "outline.json", NAME, polygon)
    write_creases(tmp_path / "creases.json", NAME, creases)
    outline_of, outline = read_drawn(tmp_path / "outline.json", "outline")
    creases_of, lines = read_drawn(tmp_path / "creases.json", "creases")
    assert outline_of == creases_of == NAME
    settings = from_json({"reference": NAME, "outline": outline, "creases": lines})
    settings.check()
    np.testing.assert_allclose(settings.outline, polygon, atol=0.006)
    np.testing.assert_allclose(settings.creases, creases.reshape(-1, 4), atol=0.006)
    assert "ü" in (tmp_path / "outline.json").read_text(encoding="utf-8")


def test_an_outline_has_no_more_corners_than_it_takes(tmp_path):
    corners = np.array([[10.0, 10], [900, 40], [880, 700], [30, 690]])
    share = np.linspace(0, 1, 200, endpoint=False)[:, None]
    dense = np.concatenate([a + share * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0))])
    dense += np.random.default_rng(0).uniform(-0.05, 0.05, dense.shape)
    write_outline(tmp_path / "outline.json", NAME, dense)
    written = np.array(json.loads((tmp_path / "outline.json").read_text(encoding="utf-8"))["outline"])
    assert len(written) == 4
    nearest = np.linalg.norm(corners[:, None] - written, axis=2).min(axis=1)
    assert nearest.max() < 0.1


def test_an_outline_that_turns_back_at_a_corner_can_be_given_again(tmp_path):
    """Found like this at the corner of a letter: 0.06 pixels beyond it and back."""
    corner = [[1284.58, 1769.72], [1283.21, 1774.45], [1282.478, 1776.752], [1282.496, 1776.694], [1280.44, 1776.48]]
    polygon = np.array([[100.0, 1650.0], [120, 200], [1400, 300], *corner])
    write_outline(tmp_path / "outline.json", NAME, polygon)
    _, outline = read_drawn(tmp_path / "outline.json", "outline")
    settings = from_json({"reference": NAME, "outline": outline})
    settings.check()
    assert abs(signed_area(np.array(settings.outline))) == pytest.approx(abs(signed_area(polygon)), rel=1e-3)


def test_a_sheet_without_creases(tmp_path):
    write_creases(tmp_path / "creases.json", "1.jpg", np.zeros((0, 2, 2)))
    assert json.loads((tmp_path / "creases.json").read_text()) == {"reference": "1.jpg", "creases": []}
    assert from_json({"reference": "1.jpg", "creases": []}, RunSettings()).creases == ()


@pytest.mark.parametrize(("depth", "factor"), [(np.uint8, 1), (np.uint16, 2)])
def test_the_picture_shows_outline_and_creases(tmp_path, depth, factor):
    levels = np.iinfo(depth).max
    photo = np.full((1000 * factor, 1600 * factor, 3), levels // 2, depth)
    polygon = np.array([[200, 100], [1400, 100], [1400, 900], [200, 900]]) * factor
    creases = np.array([[[200, 500], [1400, 500]]]) * factor
    write_outline_picture(tmp_path / "outline.jpg", photo, polygon, creases, None)
    with Image.open(tmp_path / "outline.jpg") as picture:
        assert picture.size == (1600, 1000)
        shown = np.asarray(picture.convert("RGB"), int)
    for row, column in ((100, 700), (900, 700), (300, 200), (300, 1400)):
        red, _, blue = shown[row, column]
        assert red > blue + 60, "the outline is orange, and closed"
    red, _, blue = shown[500, 700]
    assert blue > red + 60, "the crease is blue"
    assert np.abs(shown[300, 700] - 128).max() < 6, "the photo is as it was"


def test_a_full_disk_is_reported(case, tmp_path):
    with pytest.raises(StepFailed, match=r"outline\.json could not be written"):
        write_outline(tmp_path / "nowhere" / "outline.json", NAME, case.state.region.outline.polygon)


def test_a_loop_at_a_corner_does_not_cost_the_rest_of_the_edge(tmp_path):
    """Found like this at a book's gutter: the whole curved side was written as one straight line."""
    share = np.linspace(0, 1, 400)[:, None]
    top = np.array([100.0, 300]) + share * [1000, 0] - 120 * np.sin(np.pi * share) * [0, 1]
    rest = np.array([[1100.0, 1500], [101, 1500], [101, 294], [97, 297]])
    polygon = np.concatenate([top, rest])
    write_outline(tmp_path / "outline.json", NAME, polygon)
    _, outline = read_drawn(tmp_path / "outline.json", "outline")
    written = np.array(outline)
    shape = (1700, 1300)
    both, either = (
        part(filled_polygon(written, shape), filled_polygon(polygon, shape)).sum()
        for part in (np.logical_and, np.logical_or)
    )
    assert both / either > 0.999
