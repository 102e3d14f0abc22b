"""The dewarping grid: exact to a pixel, valid, and with nothing where the photo shows nothing."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pytest
from origami.core.errors import StepFailed
from origami.workflow.delivery import dewarping
from origami.workflow.delivery.finished_run import finished_run
from origami.workflow.delivery.page_in_photos import page_in_photos

PAGE = f"{{{dewarping.NAMESPACE}}}"


@pytest.fixture
def page(run_folder):
    return page_in_photos(finished_run(run_folder))


def interpolated(grids, shape):
    """What a program that knows only the file finds for each pixel of the page; NaN where no grid is."""
    found = np.full((*shape, 2), np.nan)
    for columns, rows, points in grids:
        for (r, (top, bottom)), (c, (left, right)) in (
            (row, column) for row in enumerate(pairwise(rows)) for column in enumerate(pairwise(columns))
        ):
            y, x = np.mgrid[top : bottom + 1, left : right + 1]
            y, x = ((y - top) / (bottom - top))[..., None], ((x - left) / (right - left))[..., None]
            upper = points[r][c] * (1 - x) + points[r][c + 1] * x
            lower = points[r + 1][c] * (1 - x) + points[r + 1][c + 1] * x
            found[top : bottom + 1, left : right + 1] = upper * (1 - y) + lower * y
    return found


def read(path):
    """The grids of a file, checked against the rules of PAGE's schema for dewarping."""
    root = ElementTree.parse(path).getroot()
    assert root.tag == f"{PAGE}DwGts"
    tags = [each.tag.removeprefix(PAGE) for each in root]
    assert tags[:2] == ["Metadata", "DocumentImage"]
    assert set(tags[2:]) == {"Grid"}
    grids = []
    for grid in root.iter(f"{PAGE}Grid"):
        kinds = [each.tag.removeprefix(PAGE) for each in grid]
        assert kinds == sorted(kinds)  # columns first
        assert min(kinds.count("Column"), kinds.count("Row")) >= 2
        columns = [int(each.attrib["refLinePos"]) for each in grid.iter(f"{PAGE}Column")]
        rows = [int(each.attrib["refLinePos"]) for each in grid.iter(f"{PAGE}Row")]
        listed = [each.attrib["points"] for each in grid.iter(f"{PAGE}Row")]
        assert all(re.fullmatch(r"([0-9]+,[0-9]+ )+([0-9]+,[0-9]+)", points) for points in listed)
        points = np.array([[point.split(",") for point in row.split()] for row in listed], float)
        assert points.shape == (len(rows), len(columns), 2)
        assert (np.diff(points[..., 0], axis=1) > 0).all()  # sorted by x
        grids.append((columns, rows, points))
    return grids, root.find(f"{PAGE}DocumentImage").attrib["filename"], root.findtext(f"{PAGE}Metadata/{PAGE}Comments")


def test_the_file_alone_leads_to_the_photo_within_a_pixel(page, tmp_path):
    view = page.view(0)
    grid = dewarping.dewarping_grid(view, 0)
    dewarping.write_dewarping_xml(tmp_path / "grid.xml", grid, "PHOTO/a b ü.jpg", "A comment with <signs> & more.")
    grids, image, comment = read(tmp_path / "grid.xml")
    assert (image, comment) == ("PHOTO/a b ü.jpg", "A comment with <signs> & more.")
    found = interpolated(grids, page.photo.shape)
    own = page.photo == 0
    assert np.isfinite(found[own]).mean() > 0.999
    error = np.hypot(*np.moveaxis(found + 0.5 - page.position, -1, 0))[own]
    assert np.nanmax(error) <= 1
    assert np.nanmax(error) == pytest.approx(grid.largest_error, abs=0.2)
    assert len(grid.rows) * len(grid.columns) < 1000  # few lines, closer only at the crease


def test_a_part_that_the_photo_does_not_show_has_no_grid(page, tmp_path):
    view = page.view(2)
    grid = dewarping.dewarping_grid(view, dewarping.quarter_turns(view))
    assert 0.45 < grid.share < 0.5
    covered = np.zeros(grid.shown.shape, bool)
    for rows, columns in dewarping.rectangles(grid.shown):
        covered[rows, columns] = True
    assert (grid.shown | ~covered).all()


@pytest.mark.parametrize("turns", [1, 2])
def test_a_photo_that_lies_on_its_side_is_turned(page, turns, tmp_path):
    """The photo as it would be stored after that many turns against the clock."""
    camera, width, height = page.cameras[0], 600, 720
    back = (4 - turns) % 4
    position, size = dewarping.turned(page.position, (width, height), back)
    entries = page.to_page.astype(float)
    side = width if back % 2 == 0 else height
    turned_entries = np.stack([np.rot90(each[: height // 8, : width // 8], -back) for each in entries])
    assert turned_entries.shape[2] == side // 8
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    rotation = np.linalg.matrix_power(quarter, back) @ camera.rotation
    translation = np.linalg.matrix_power(quarter, back) @ camera.translation
    centre, _ = dewarping.turned(camera.principal_point, (width, height), back)
    lying = replace(
        camera, width=size[0], height=size[1], principal_point=centre, rotation=rotation, translation=translation
    )
    turned_page = replace(
        page, cameras=[lying, *page.cameras[1:]], position=position, to_page=turned_entries.astype(np.float32)
    )
    view = turned_page.view(0)
    assert dewarping.quarter_turns(view) == turns
    grid = dewarping.dewarping_grid(view, turns)
    upright = dewarping.dewarping_grid(page.view(0), 0)
    np.testing.assert_array_equal(grid.columns, upright.columns)
    assert np.abs(grid.points - upright.points).max() <= 1
    dewarping.write_dewarping_xml(tmp_path / "grid.xml", grid, "photo.tif", "")
    read(tmp_path / "grid.xml")


def test_a_photo_without_the_page(page):
    away = replace(page.cameras[0], translation=np.array([0, 0, -1000.0]))
    empty = replace(page, cameras=[away], photo=np.full_like(page.photo, 1), to_page=np.full_like(page.to_page, np.nan))
    with pytest.raises(StepFailed, match="shows nothing of the page"):
        dewarping.dewarping_grid(empty.view(0), 0)


def test_rectangles_are_those_of_the_complete_cells():
    shown = np.ones((4, 5), bool)
    assert dewarping.rectangles(shown) == [(slice(0, 4), slice(0, 5))]
    shown[0, 0] = False
    assert dewarping.rectangles(shown) == [(slice(0, 2), slice(1, 5)), (slice(1, 4), slice(0, 5))]
    assert dewarping.rectangles(np.zeros((3, 3), bool)) == []
