"""Places of the page in its photos, and which of them a photo shows."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.errors import UsageError
from origami.workflow.delivery.finished_run import finished_run
from origami.workflow.delivery.page_in_photos import page_in_photos


@pytest.fixture
def page(run_folder):
    return page_in_photos(finished_run(run_folder))


def on_sheet(case, u, v):
    """Points of the folded sheet in the world, from its own formula."""
    a, b, c = case.sheet.vertices[[0, 24, 25 * 30]]
    across = (b - a) / case.flat.width
    middle = case.sheet.vertices[25 * 15]
    down = np.where((v < case.flat.height / 2)[:, None], middle - a, c - middle) / (case.flat.height / 2)
    return middle + across * u[:, None] + down * (v - case.flat.height / 2)[:, None]


@pytest.mark.parametrize("index", [0, 1, 2])
def test_pixels_of_the_page_are_where_the_camera_sees_them(case, page, index):
    columns, rows = (each.ravel() for each in np.meshgrid(np.arange(5, 640, 70), np.arange(5, 800, 60)))
    u, v = (columns + 0.5) / 640 * case.flat.width, (rows + 0.5) / 800 * case.flat.height
    expected = case.model.cameras[index].project(on_sheet(case, u, v))
    places = page.view(index).places(columns, rows)
    known = np.isfinite(places.pixels[:, 0])
    assert known.sum() > 100
    # The map has sixteenths of a pixel and finer.
    np.testing.assert_allclose(places.pixels[known], expected[known], atol=0.04)


def test_a_half_that_turns_its_back_is_not_shown(page):
    columns, rows = np.full(80, 300), np.arange(0, 800, 10)
    assert page.view(0).places(columns, rows).shown.all()
    shown = page.view(2).places(columns, rows).shown
    upper, lower = shown[rows < 390], shown[rows > 410]
    assert sorted([upper.mean(), lower.mean()]) == [0, 1]


def test_what_the_map_states_is_exact(case, page):
    view = page.view(1)
    on_page, in_photo = view.stated()
    columns, rows = np.floor(on_page).astype(int).T.clip(0, [[639], [799]])
    u, v = (on_page / (640, 800) * (case.flat.width, case.flat.height)).T
    # Of the way back, the map has what lies straight between the corners of a triangle in the photo.
    np.testing.assert_allclose(in_photo, case.model.cameras[1].project(on_sheet(case, u, v)), atol=0.1)
    assert (page.photo[rows, columns] == 1).mean() > 0.9


def test_files_that_do_not_belong_together_are_named(run_folder):
    with np.load(run_folder / "sheet.npz") as stored:
        arrays = dict(stored)
    np.savez(run_folder / "sheet.npz", **arrays | {"cam_names": arrays["cam_names"][::-1]})
    with pytest.raises(UsageError, match="are of different runs"):
        page_in_photos(finished_run(run_folder))
    np.savez(run_folder / "sheet.npz", **{name: array for name, array in arrays.items() if name != "cam_rotations"})
    with pytest.raises(UsageError, match="has no cam_rotations: an earlier version"):
        page_in_photos(finished_run(run_folder))
    (run_folder / "sheet.npz").write_bytes((run_folder / "map.npz").read_bytes()[:1000])
    with pytest.raises(UsageError, match=r"sheet\.npz cannot be read"):
        page_in_photos(finished_run(run_folder))
    (run_folder / "sheet.npz").unlink()
    with pytest.raises(UsageError, match=r"holds no sheet\.npz"):
        page_in_photos(finished_run(run_folder))


def test_folders_that_hold_no_finished_run(tmp_path):
    with pytest.raises(UsageError, match=r"holds no report\.json, so no run has finished"):
        finished_run(tmp_path)
    with pytest.raises(UsageError, match=r"holds no report\.json"):
        finished_run(tmp_path / "missing")
    for content in ("[]", "{}", '{"inputs": []}'):
        (tmp_path / "report.json").write_text(content)
        with pytest.raises(UsageError, match="not a report of Origami"):
            finished_run(tmp_path)
    (tmp_path / "report.json").write_text("{")
    with pytest.raises(UsageError, match="cannot be read"):
        finished_run(tmp_path)
    sheets = '[{"folder": "sheet-1", "failure": null}, {"folder": "sheet-2", "failure": "It failed."}]'
    (tmp_path / "report.json").write_text(f'{{"inputs": [], "stages": [], "outputs": {{}}, "sheets": {sheets}}}')
    with pytest.raises(UsageError, match=r"several sheets; name the folder of one of them: \S*sheet-1\."):
        finished_run(tmp_path)
