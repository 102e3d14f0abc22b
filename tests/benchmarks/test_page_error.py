"""The exact error of a page's pixels: known shifts, waves and shapes are measured as what they are."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import sheets

pytest.importorskip("cv2", reason="the benchmark's requirements are not installed")

from origami.benchmarks import page_error, truth

WIDTH, HEIGHT = 210.0, 300.0  # mm
PIXELS = (300, 210)
Flat = Callable[[np.ndarray], np.ndarray]


def write_scene(folder: Path, flat: np.ndarray, positions: np.ndarray) -> Path:
    """A scene with two photos of a sheet whose printed side looks along +z."""
    np.savez(folder / "gt_mesh.npz", xyz=positions, uv=flat)
    lens = {"width": 800, "height": 1000, "fx": 1200.0, "fy": 1200.0, "cx": 390.0, "cy": 510.0, "k1": -0.05, "k2": 0.02}
    down = np.diag([1.0, -1.0, -1.0])
    photos = [
        {"file": f"photos/{i}.jpg", "R": down.tolist(), "t_mm": (-down @ centre).tolist()} | lens
        for i, centre in enumerate(np.array([[0, 0, 500.0], [60, -40, 520.0]]))
    ]
    (folder / "scene.json").write_text(json.dumps({"page_mm": [WIDTH, HEIGHT], "photos": photos}))
    return folder


@pytest.fixture(scope="module")
def exact(tmp_path_factory) -> truth.Truth:
    """A letter in thirds; its creases run through nodes of the grid."""
    flat = np.stack(np.meshgrid(np.linspace(0, WIDTH, 211), np.linspace(0, HEIGHT, 301)), -1)
    positions = sheets.two_folds().in_space(flat / HEIGHT) * [HEIGHT, -HEIGHT, -HEIGHT]
    return truth.Truth(write_scene(tmp_path_factory.mktemp("scene"), flat, positions))


def page_of(exact: truth.Truth, shown: Flat, photo: int = 0) -> page_error.PageSource:
    """A page whose pixel at the flat place p, mm, shows ``shown(p)``; its unit is half a page height."""
    rows, columns = PIXELS
    grid = np.stack(np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5), -1)
    place = grid / [columns, rows] * [WIDTH, HEIGHT]
    surface = sheets.two_folds().in_space(shown(place) / HEIGHT) * [HEIGHT, -HEIGHT, -HEIGHT]
    name = f"{photo}.jpg"
    position = exact.cameras[name].project(surface)
    return page_error.PageSource(np.zeros(PIXELS, int), position, [name], place * 2 / HEIGHT)


@pytest.mark.parametrize("photo", [0, 1])
def test_a_true_page_has_no_error(exact, photo):
    figures = page_error.measure(exact, page_of(exact, lambda place: place, photo)).figures()
    assert figures["page_worst"] < 3e-3
    assert figures["rows_worst"] < 3e-3
    assert figures["aspect_percent"] == pytest.approx(0, abs=1e-3)
    assert figures["page_known"] == pytest.approx(1, abs=0.05)


def test_a_page_that_is_only_moved_turned_and_of_another_size_has_no_error(exact):
    turn = np.radians(0.5)
    similarity = 0.98 * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    figures = page_error.measure(exact, page_of(exact, lambda place: place @ similarity.T + [3, 2])).figures()
    assert figures["page_worst"] < 3e-3
    assert figures["rows_worst"] < 3e-3


def test_waves_along_rows(exact):
    amplitude = 0.3  # mm, 0.1 % of the height

    def waving(place: np.ndarray) -> np.ndarray:
        return place + np.stack(
            [np.zeros_like(place[..., 0]), amplitude * np.cos(place[..., 0] / WIDTH * 12 * np.pi)], -1
        )

    figures = page_error.measure(exact, page_of(exact, waving)).figures()
    assert figures["rows_rms"] == pytest.approx(0.1 / np.sqrt(2), rel=0.03)
    assert figures["rows_worst"] == pytest.approx(0.1, rel=0.05)
    assert figures["columns_worst"] < 5e-3
    assert figures["page_mean"] == pytest.approx(0.1 * 2 / np.pi, rel=0.05)


def test_waves_along_columns(exact):
    def waving(place: np.ndarray) -> np.ndarray:
        return place + np.stack([0.3 * np.cos(place[..., 1] / HEIGHT * 12 * np.pi), np.zeros_like(place[..., 1])], -1)

    figures = page_error.measure(exact, page_of(exact, waving)).figures()
    assert figures["columns_rms"] == pytest.approx(0.1 / np.sqrt(2), rel=0.03)
    assert figures["rows_worst"] < 5e-3


def test_a_page_that_is_too_wide(exact):
    """A page 1 % too wide: each of its pixels shows a place nearer to the left side than it should be."""
    figures = page_error.measure(exact, page_of(exact, lambda place: place / [1.01, 1])).figures()
    assert figures["aspect_percent"] == pytest.approx(1, abs=1e-3)
    assert figures["rows_rms"] < 1e-3
    assert figures["page_mean"] > 0.05


def test_pixels_that_show_something_else_count_but_do_not_move_the_page(exact):
    def torn(place: np.ndarray) -> np.ndarray:
        return np.where(place[..., 1:] > 0.9 * HEIGHT, place - [0, 30], place)

    error = page_error.measure(exact, page_of(exact, torn))
    length = np.linalg.norm(error.vectors, axis=2)
    assert np.nanmax(length[:260]) < 2e-3
    assert np.nanmean(length[280:]) == pytest.approx(10, abs=0.01)


def test_pixels_beyond_the_sheet_are_not_known(exact):
    error = page_error.measure(exact, page_of(exact, lambda place: place - [0, 30]))
    assert not np.isfinite(error.length[:25]).any()
    assert np.isfinite(error.length[35:-5, 5:-5]).all()
    assert error.figures()["page_known"] == pytest.approx(0.9, abs=0.03)


def test_of_a_sheet_that_covers_itself_the_upper_part_is_seen(tmp_path):
    """The lower half is folded up over the upper half, 5 mm above it; its back shows."""
    flat = np.stack(np.meshgrid(np.linspace(0, WIDTH, 106), np.linspace(0, HEIGHT, 151)), -1)
    u, v = flat[..., 0] - WIDTH / 2, HEIGHT / 2 - flat[..., 1]
    positions = np.stack([u, np.abs(v), np.where(v < 0, 5.0, 0.0)], -1)
    exact = truth.Truth(write_scene(tmp_path, flat, positions))
    column, row = exact.cameras["0.jpg"].project(np.array([0.0, 60.0, 5.0])).astype(int)
    np.testing.assert_allclose(exact.flat_in_photo("0.jpg")[row, column], [WIDTH / 2, HEIGHT / 2 + 60], atol=0.5)


def test_the_map_of_a_run_is_read(tmp_path):
    """A map of 30 x 22 pixels of photo b, of which one in four is read; the page is 11 x 15 mm."""
    position = np.stack(np.meshgrid(np.arange(22) + 0.5, np.arange(30) + 0.25), -1)
    scaled = np.rint(position * 16).astype(np.uint16)
    np.savez(
        tmp_path / "map.npz",
        photo=np.ones((30, 22), np.int16),
        position_delta=np.diff(scaled, axis=1, prepend=np.uint16(0)),
        position_scale=np.array(16),
        photo_names=np.array(["a.jpg", "b.jpg"]),
        page_size=np.array([11.0, 15.0]),
    )
    source = page_error.read_source(tmp_path / "map.npz")
    assert source.photo.shape == (7, 5)
    assert source.names[source.photo[0, 0]] == "b.jpg"
    np.testing.assert_allclose(source.position[1, 2], [10.5, 6.25])
    np.testing.assert_allclose(source.place[1, 2], [10.5 / 2, 6.5 / 2])
