"""UV layout and crease pattern, as drawings and in the format of origami software."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest
from folded import HEIGHT_MM, WIDTH_MM, folded_sheet
from origami.core.errors import StepFailed
from origami.core.numeric.polygon import signed_area
from origami.core.sheet import FlatMap
from origami.origami_addon.export.fold_file import write_fold
from origami.origami_addon.export.svg_files import write_crease_svg, write_uv_layout

SVG = "{http://www.w3.org/2000/svg}"
FOLD = 0.5  # radians by which each half of the sheet rises from its valley


@pytest.fixture(scope="module")
def case():
    return folded_sheet(FOLD)


@pytest.fixture
def out(tmp_path):
    folder = tmp_path / "Ausgabe ü 1"
    folder.mkdir()
    return folder


def without_size(flat: FlatMap) -> FlatMap:
    scaled = replace(flat, uv=flat.uv / HEIGHT_MM, width=WIDTH_MM / HEIGHT_MM, height=1.0)
    return replace(scaled, unit="page heights", world_scale=None)


def test_uv_layout_is_drawn_in_millimetres(case, out):
    write_uv_layout(out / "uv_layout.svg", case.sheet, case.flat)
    root = ElementTree.parse(out / "uv_layout.svg").getroot()
    left, top, width, height = (float(value) for value in root.get("viewBox").split())
    assert (root.get("width"), root.get("height")) == (f"{width:g}mm", f"{height:g}mm")
    assert (left, top, left + width, top + height) == pytest.approx((-4, -4, 164, 204))
    assert root[0].get("d") == "M0 0H160V200H0Z"
    assert [path.get("id") for path in root] == ["page", "mesh", "ridges", "boundary"]
    assert root[2].get("d").count("M") == 2


def test_uv_layout_of_unknown_size_has_no_unit(case, out):
    write_uv_layout(out / "uv_layout.svg", case.sheet, without_size(case.flat))
    assert "mm" not in (out / "uv_layout.svg").read_text().split(">")[0]


def test_crease_pattern_is_drawn_in_millimetres_with_a_layer_for_each_kind(case, out):
    write_crease_svg(out / "crease_pattern.svg", case.sheet, case.flat)
    root = ElementTree.parse(out / "crease_pattern.svg").getroot()
    left, top, width, height = (float(value) for value in root.get("viewBox").split())
    assert (root.get("width"), root.get("height")) == (f"{width:g}mm", f"{height:g}mm")
    assert (left, top, left + width, top + height) == pytest.approx((-4, -4, 164, 204))
    layers = {layer.get("id"): list(layer) for layer in root}
    assert {name: len(lines) for name, lines in layers.items()} == {"paper": 8, "valley": 2, "open": 2}
    assert {name: lines[0].get("stroke") for name, lines in layers.items()} == {
        "paper": "#000",
        "valley": "#00f",
        "open": "#888",
    }
    for line in layers["valley"]:
        assert {float(line.get(name)) for name in ("y1", "y2")} == {100.0}
        assert line.find(f"{SVG}title").text == "valley, 57°"
        assert line.get("stroke-dasharray") == "4 2"
    for line in layers["open"]:
        assert [float(line.get(name)) for name in ("x1", "x2")] == pytest.approx([WIDTH_MM / 3] * 2, abs=0.01)


def test_mountains_have_their_own_look(out):
    case = folded_sheet(-FOLD)
    write_crease_svg(out / "crease_pattern.svg", case.sheet, case.flat)
    root = ElementTree.parse(out / "crease_pattern.svg").getroot()
    (layer,) = (layer for layer in root if layer.get("id") == "mountain")
    assert layer[0].get("stroke") == "#f00"
    assert layer[0].get("stroke-dasharray") == "7 1.5 0.7 1.5"


def test_crease_pattern_of_unknown_size_has_no_unit(case, out):
    write_crease_svg(out / "crease_pattern.svg", case.sheet, without_size(case.flat))
    text = (out / "crease_pattern.svg").read_text(encoding="utf-8")
    assert "mm" not in text.split(">")[0]
    root = ElementTree.fromstring(text)
    assert float(root[0][0].get("stroke-width")) == pytest.approx(0.35 / 297, rel=1e-4)


@pytest.fixture
def fold(case, out):
    write_fold(out / "crease_pattern.fold", case.sheet, case.flat)
    return json.loads((out / "crease_pattern.fold").read_text(encoding="utf-8"))


def test_fold_file_says_what_it_is(fold):
    assert fold["file_spec"] == 1.2
    assert fold["file_creator"].startswith("Origami ")
    assert fold["file_classes"] == ["singleModel"]
    assert fold["frame_classes"] == ["creasePattern"]
    assert {"2D", "noJoins"} <= set(fold["frame_attributes"])
    assert fold["frame_unit"] == "mm"


def test_fold_file_holds_the_crease_pattern(fold):
    vertices = np.array(fold["vertices_coords"])
    edges, letters = np.array(fold["edges_vertices"]), np.array(fold["edges_assignment"])
    angles = np.array(fold["edges_foldAngle"])
    assert (len(vertices), len(edges), len(fold["faces_vertices"])) == (9, 12, 4)
    assert len(letters) == len(angles) == len(edges)
    assert edges.min() == 0
    assert edges.max() == len(vertices) - 1
    assert sorted(letters.tolist()) == sorted("BBBBBBBBVVFF")
    np.testing.assert_allclose(angles[letters == "V"], np.degrees(2 * FOLD), atol=0.01)
    assert (angles[letters != "V"] == 0).all()
    # y points up: the valley is in the middle, the corners around it
    np.testing.assert_allclose(vertices[edges[letters == "V"]][..., 1], HEIGHT_MM / 2, atol=0.01)
    assert [0.0, HEIGHT_MM] in vertices.tolist()
    sides = {tuple(sorted(edge)) for edge in edges.tolist()}
    for face in fold["faces_vertices"]:
        assert signed_area(vertices[face]) > 0  # counter-clockwise with y up
        assert {tuple(sorted(side)) for side in zip(face, np.roll(face, -1).tolist())} <= sides


def test_fold_file_holds_the_folded_form(fold):
    (frame,) = fold["file_frames"]
    assert frame["frame_classes"] == ["foldedForm"]
    assert (frame["frame_parent"], frame["frame_inherit"]) == (0, True)
    flat, folded = np.array(fold["vertices_coords"]), np.array(frame["vertices_coords"])
    np.testing.assert_allclose(*lengths_of(fold), rtol=1e-4)
    # the printed side looks up; along a valley the paper is lowest
    on_crease = np.isclose(flat[:, 1], HEIGHT_MM / 2, atol=0.01)
    np.testing.assert_allclose(folded[on_crease, 2], 0, atol=0.01)
    np.testing.assert_allclose(folded[~on_crease, 2], HEIGHT_MM / 2 * np.sin(FOLD), rtol=1e-4)
    for face in fold["faces_vertices"]:
        first, second, third = folded[face[:3]]
        assert np.cross(second - first, third - first)[2] > 0


def lengths_of(fold: dict) -> list[np.ndarray]:
    """Lengths of the edges, on the page and folded."""
    places = [np.array(frame["vertices_coords"])[fold["edges_vertices"]] for frame in (fold, fold["file_frames"][0])]
    return [np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) for ends in places]


def test_crease_that_ends_inside_is_continued_by_a_join(case, out):
    half = case.sheet.ridges[0][: len(case.sheet.ridges[0]) // 2]
    write_fold(out / "half.fold", replace(case.sheet, ridges=(half,)), case.flat)
    fold = json.loads((out / "half.fold").read_text(encoding="utf-8"))
    assert "joins" in fold["frame_attributes"]
    assert sorted(fold["edges_assignment"]) == sorted("BBBBBBVJ")
    assert len(fold["faces_vertices"]) == 2


def test_fold_file_of_unknown_size_is_in_page_heights(case, out):
    write_fold(out / "crease_pattern.fold", case.sheet, without_size(case.flat))
    fold = json.loads((out / "crease_pattern.fold").read_text(encoding="utf-8"))
    assert fold["frame_unit"] == "unit"
    assert np.max(fold["vertices_coords"]) == 1.0
    flat, folded = lengths_of(fold)
    np.testing.assert_allclose(folded, flat, rtol=1e-4)


@pytest.mark.parametrize("write", [write_uv_layout, write_crease_svg, write_fold])
def test_unwritable_place_is_reported(case, out, write):
    (out / "file").mkdir()
    with pytest.raises(StepFailed, match="file could not be written"):
        write(out / "file", case.sheet, case.flat)
