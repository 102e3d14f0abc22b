"""The generated tables are exact and reproducible, and the measurements on them are correct."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import flat_scene
import numpy as np
import pytest

cv2 = pytest.importorskip("cv2", reason="the benchmark's requirements are not installed")

from origami.benchmarks.tabletops import (  # noqa: E402
    bends,
    cameras,
    changed,
    files,
    measure,
    page_truth,
    photo,
    raster,
    scene,
    shapes,
)
from origami.core.errors import StepFailed  # noqa: E402
from origami.core.paper.outline import Outline  # noqa: E402
from origami.origami_addon.settings import RunSettings  # noqa: E402
from origami.origami_addon.state import Region  # noqa: E402
from scipy.spatial import cKDTree  # noqa: E402

SMALL = (320, 240)


@pytest.mark.parametrize("kind", scene.SHEETS)
def test_sheets_are_bent_without_stretch_or_tear(kind):
    for seed in range(12):
        sheet = bends.KINDS[kind](np.random.default_rng(seed))
        rotations = np.stack([facet.rotation for facet in sheet.facets])
        np.testing.assert_allclose(rotations @ rotations.transpose(0, 2, 1), [np.eye(3)] * len(rotations), atol=1e-9)
        assert np.linalg.det(rotations).min() > 0
        flat = np.concatenate([facet.flat for facet in sheet.facets])
        corners = scene.corners_of(sheet.facets)
        same = cKDTree(flat).query_pairs(1e-7, output_type="ndarray")
        assert len(same) >= 2 * (len(sheet.facets) - 1)
        np.testing.assert_allclose(corners[same[:, 0]], corners[same[:, 1]], atol=1e-6)
        area = sum(cv2.contourArea(facet.flat.astype(np.float32)) for facet in sheet.facets)
        assert area == pytest.approx(sheet.width * sheet.height, rel=1e-5)
        assert corners[:, 2].min() >= -1e-9
        if kind != "book":  # whose page lies on others
            assert corners[:, 2].min() == pytest.approx(0, abs=1e-9)


def test_a_mirrored_page_is_as_exact():
    right = bends.book(np.random.default_rng(3))
    left = scene.mirrored(right)
    flat = np.random.default_rng(0).uniform(0, 1, (50, 2)) * [right.width, right.height]
    there = shapes.in_space(left, flat * [-1, 1] + [right.width, 0])
    np.testing.assert_allclose(there, shapes.in_space(right.facets, flat) * [-1, 1, 1], atol=1e-9)
    assert all(facet.normal[2] > 0 for facet in left)


def test_an_edge_has_its_length_and_its_corners():
    sheet = bends.folded(np.random.default_rng(1))
    edge = shapes.border(sheet.facets, sheet.width, sheet.height)
    length = np.linalg.norm(np.roll(edge, -1, 0) - edge, axis=1).sum()
    assert length == pytest.approx(2 * (sheet.width + sheet.height), rel=1e-9)


@pytest.mark.parametrize("kind", changed.SHEETS)
def test_bends_change_without_stretch_or_tear(kind):
    for seed in range(4):
        sheet = bends.KINDS[kind](np.random.default_rng(seed))
        assert [facet.rotation for facet in changed.bent_by(sheet.facets, 1.0)] == [
            pytest.approx(facet.rotation, abs=1e-9) for facet in sheet.facets
        ]
        facets = changed.bent_by(sheet.facets, 0.6)
        flat = np.concatenate([facet.flat for facet in facets])
        corners = scene.corners_of(facets)
        same = cKDTree(flat).query_pairs(1e-7, output_type="ndarray")
        np.testing.assert_allclose(corners[same[:, 0]], corners[same[:, 1]], atol=1e-6)
    fold = bends.folded(np.random.default_rng(2)).facets
    assert changed.largest_bend(changed.bent_by(fold, 0.5)) == pytest.approx(changed.largest_bend(fold) / 2)


def test_a_sheet_changes_between_the_photos_and_nothing_else_does(tmp_path):
    seed = 1005  # folded, on wood
    for kind in ("moved", "bent"):
        files.write(seed, tmp_path / kind, SMALL, kind)
        truth = json.loads((tmp_path / kind / "truth.json").read_text())
        change = truth["change"]
        assert 2 <= len(truth["photos"]) - change["first_photo"] <= len(truth["photos"]) / 2
        before, after = (
            [shapes.Facet(*(np.array(each[part]) for part in ("flat", "rotation", "origin"))) for each in facets]
            for facets in (truth["facets"], change["facets"])
        )
        bends_differ = changed.largest_bend(after) - changed.largest_bend(before)
        if kind == "moved":
            assert bends_differ == pytest.approx(0, abs=1e-6)
            turn = after[0].rotation @ before[0].rotation.T
            assert np.degrees(np.arccos((np.trace(turn) - 1) / 2)) == pytest.approx(change["turn"])
            np.testing.assert_allclose(turn[2], [0, 0, 1], atol=1e-9)
        else:
            assert abs(bends_differ) == pytest.approx(change["bend"])
            assert min(corner[2] for facet in after for corner in facet.corners) == pytest.approx(0, abs=1e-9)
    files.write(seed, tmp_path / "still", SMALL)
    still = json.loads((tmp_path / "still" / "truth.json").read_text())["photos"]
    assert [photo["translation"] for photo in still] == [photo["translation"] for photo in truth["photos"]]
    assert [photo["outline"] for photo in still][:2] == [photo["outline"] for photo in truth["photos"]][:2]
    assert still[-1]["outline"] != truth["photos"][-1]["outline"]


def test_sixty_seeds_have_every_kind():
    for first in (0, 1000):
        kinds = [scene.kinds(seed) for seed in range(first, first + 60)]
        assert min(Counter(table for table, _ in kinds).values()) >= 4
        assert min(Counter(sheet for _, sheet in kinds).values()) >= 6
        assert len(set(kinds)) == 60
        assert {table for table, _ in kinds} == set(scene.TABLES)


@pytest.fixture(scope="module", params=[4, 6, 13])
def small_scene(request) -> scene.Scene:
    """A receipt on metal, a bent one on wood, a book or so: whatever the seed has."""
    return scene.make(request.param, SMALL)


def test_outline_agrees_with_what_is_painted(small_scene):
    layer = next(layer for layer in small_scene.layers if layer.name == "sheet")
    for index, view in enumerate(small_scene.views):
        if index in small_scene.cut_off:
            continue
        seen = raster.see(layer, view)
        assert seen is not None
        cover, _ = seen
        outline = photo.visible_edge(view.project(small_scene.edge), cover)
        contours, _ = cv2.findContours(cover.first, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        painted = max(contours, key=cv2.contourArea)[:, 0] / raster.FINE + [cover.left, cover.top]
        assert flat_scene.distance_to(outline, painted).max() < 1
        assert flat_scene.distance_to(painted, outline).max() < 1


def test_every_pixel_of_the_sheet_knows_its_place(small_scene):
    layer = next(layer for layer in small_scene.layers if layer.name == "sheet")
    view = small_scene.views[0]
    seen = raster.see(layer, view)
    assert seen is not None
    cover, label = seen
    rows, columns = np.nonzero(label)
    cell = label[rows, columns] - 1
    mine = np.array([number == 0 for number, _, _ in layer.cells])[cell]
    rows, columns, cell = rows[mine][::7], columns[mine][::7], cell[mine][::7]
    pixels = np.stack([columns + cover.left, rows + cover.top], -1) + 0.5
    x, y = view.undistort(pixels).T.astype(np.float32)
    u, v = raster.flat_places(layer, view, cell, x, y)
    places = np.stack([layer.cells[c][2].in_space(np.array([a, b])) for c, a, b in zip(cell, u, v, strict=True)])
    np.testing.assert_allclose(view.project(places), pixels, atol=0.02)


def test_lens_distortion_is_undone():
    view = scene.make(2, SMALL).views[0]
    bent = type(view)(view.width, view.height, view.focal_length, -0.06, view.rotation, view.translation)
    pixels = np.random.default_rng(0).uniform(0, 1, (100, 2)) * [view.width, view.height]
    np.testing.assert_allclose(bent.distort(bent.undistort(pixels)), pixels, atol=1e-4)
    x, y = bent.rays()
    at = np.stack(np.meshgrid(np.arange(view.width), np.arange(view.height)), -1) + 0.5
    np.testing.assert_allclose(np.stack([x, y], -1), bent.undistort(at), atol=1e-4)


def test_a_seed_gives_the_same_files(tmp_path):
    for name in ("first", "second"):
        files.write(5, tmp_path / name, SMALL)
    first, second = ({p.name: p.read_bytes() for p in (tmp_path / n).rglob("*.*")} for n in ("first", "second"))
    assert first == second
    truth = json.loads((tmp_path / "first" / "truth.json").read_text())
    assert {"truth.json", "contact.jpg", *(shown["file"] for shown in truth["photos"])} == set(first)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["first", "second"]


SQUARE = np.array([[10.0, 10], [110, 10], [110, 110], [10, 110]])


def test_overlap_of_known_rectangles():
    size = (200, 200)
    assert measure.overlap(SQUARE, SQUARE[::-1], size) == 1
    assert measure.overlap(SQUARE, SQUARE + np.array([50, 0]), size) == pytest.approx(1 / 3, abs=0.01)
    # What lies outside the frame does not count.
    longer = SQUARE + np.array([[0, 0], [0, 0], [0, 900], [0, 900]])
    assert measure.overlap(SQUARE, longer, (200, 110)) == 1
    assert measure.overlap(SQUARE, SQUARE + 500, size) == 0


@pytest.mark.parametrize(
    ("shift", "warnings", "shown", "verdict", "warned", "false"),
    [
        (0, [], {}, "right", "no", False),
        (0, ["Look at it."], {}, "right", "yes", True),
        (0, ["Look at it."], {"cut_off": True}, "right", "yes", False),
        (0, ["2 sheets are in view; the one in the middle that most photos show was taken."], {}, "right", "no", False),
        (2, [], {}, "near", "no", False),
        (20, ["Look at it."], {}, "wrong", "yes", False),
    ],
)
def test_verdicts(shift, warnings, shown, verdict, warned, false):
    photo = {"width": 200, "height": 200, "outline": SQUARE.tolist(), "cut_off": False, "hand_on_sheet": False} | shown
    region = Region(0, Outline(SQUARE + np.array([shift, 0]), 0.9, ()), np.ones(3, bool))
    row = measure.judge(region, photo, warnings)
    assert (row["verdict"], row["warned"], row["false_warning"]) == (verdict, warned, false)


def test_a_scene_is_measured(tmp_path, monkeypatch):
    """Stand-ins for the finder: one that knows the sheet, one that is wrong without a warning, one that refuses."""
    files.write(7, tmp_path / "scenes" / "0007", SMALL)
    truth = json.loads((tmp_path / "scenes" / "0007" / "truth.json").read_text())
    shown = truth["photos"][1]
    outline = np.array(shown["outline"])

    class Model:
        cameras = tuple(type("Camera", (), {"name": photo["file"]}) for photo in truth["photos"])

    def place(work):
        with work.report.stage("place photos"):
            return Model()

    def finder(found):
        def find_sheet(model, work):
            with work.report.stage("find sheet"):
                if found is None:
                    raise StepFailed("Too few points; take more photos.")
                return Region(1, Outline(found, 0.8, ()), np.ones(1, bool))

        return find_sheet

    monkeypatch.setattr(measure.steps, "place_photos", place)
    tables = {}
    for name, found in (("right", outline), ("wrong", outline * 0.7), ("failed", None)):
        monkeypatch.setattr(measure.steps, "find_sheet", finder(found))
        out = tmp_path / name
        summary, each = measure.run(tmp_path / "scenes", out, [7], RunSettings(), lambda text: None)
        tables[name] = summary.rows[0]
        assert each.rows[0]["verdict"] == name
        assert (out / "tables.md").is_file()
        assert Path(out / "pictures" / "0007.jpg").is_file() == (name != "failed")
    assert tables["right"]["median"] > 0.999
    assert (tables["right"]["right"], tables["right"]["false"], tables["right"]["silent"]) == (1, 0, 0)
    assert (tables["wrong"]["wrong"], tables["wrong"]["silent"]) == (1, 1)
    assert (tables["failed"]["failed"], tables["failed"]["silent"]) == (1, 0)


@pytest.mark.parametrize("factor", [1.9, 2.0, 2.1, 2.37])
def test_a_print_that_is_reduced_keeps_its_place(factor):
    """An edge near the end of a page 1001 pixels wide; OpenCV would keep to the factor and round the size."""
    picture = np.zeros((301, 1001, 3), np.uint8)
    picture[:, 950:] = 255
    part = raster.Part([], picture, 1.0)
    layer, view = SimpleNamespace(centres=np.zeros((1, 3))), SimpleNamespace(focal_length=1.0, centre=[0, 0, factor])
    u = np.linspace(940, 960, 2001, dtype=np.float32)
    seen = raster._look_up(part, u, np.full_like(u, 150), layer, view)[:, 0]
    half = u[np.argmin(np.abs(seen - raster.TO_LINEAR[128]))]
    assert half == pytest.approx(950, abs=0.2)


@pytest.mark.parametrize("lens", cameras.LENSES)
def test_flat_places_are_found_again_through_the_lens_of_a_phone(tmp_path, lens):
    files.write(6, tmp_path / "scene", SMALL, lens=lens)
    truth = json.loads((tmp_path / "scene" / "truth.json").read_text(encoding="utf-8"))
    shown = truth["photos"][0]
    view = page_truth.view_of(shown)
    assert view.k2 < 0
    assert any(view.row_shift) == (lens == "unsteady phone")
    facets = [
        shapes.Facet(*(np.array(each[name]) for name in ("flat", "rotation", "origin"))) for each in truth["facets"]
    ]
    flat = np.random.default_rng(1).uniform(0.05, 0.95, (200, 2)) * truth["page_mm"]
    found = page_truth.true_flat(truth, shown, view.project(shapes.in_space(facets, flat)))
    hidden = np.linalg.norm(found - flat, axis=1) > 1e-3
    assert hidden.mean() < 0.1  # by a steep part of the sheet
