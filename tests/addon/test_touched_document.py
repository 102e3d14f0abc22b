"""A small document as the command line, or a user who touched its objects, leaves it to the window."""

from __future__ import annotations

import json

import pytest
from folded import folded_sheet
from origami.origami_addon.files.image_files import write_jpeg
from origami.origami_addon.report import Report
from origami.origami_addon.scene.camera_object import VIEWS, write_views
from origami.origami_addon.scene.show import Pictures, build_document
from origami.origami_addon.settings import RunSettings

CASE = folded_sheet()


@pytest.fixture
def document(empty_scene, tmp_path):
    """A document that the command line filled: creases and outline were given, and some steps had warnings."""
    from origami import register, unregister
    from origami.origami_addon.scene.document_group import fill_group

    register()
    write_jpeg(tmp_path / "page.jpg", CASE.photos[0], 100)
    views = list(write_views(tmp_path / VIEWS, CASE.model.cameras, CASE.photos.__getitem__))
    pictures = Pictures(views, [tmp_path / "page.jpg"] * 2, pack=False)
    made = build_document("Brief ü", CASE.state, pictures, tmp_path / "page.jpg")
    outline = tuple((float(x), float(y)) for x, y in CASE.state.region.outline.polygon)
    creases = ((30.0, 350.0, 570.0, 350.0), (200.0, 40.0, 200.0, 600.5))
    settings = RunSettings(reference=CASE.model.cameras[0].name, outline=outline, creases=creases)
    report = Report({})
    with report.stage("read photos"):
        report.warn("One photo is a copy.")
    with report.stage("reconstruct surface") as figures:
        figures |= {"fold_angles_degrees": [57.3, float("nan")], "creases": 2}
        report.warn("Crease 3 lies outside.")
    fill_group(made, [], settings, report)
    yield made
    unregister()


def test_the_window_goes_on_with_what_the_command_line_was_given(document, tmp_path):
    import bpy

    assert bpy.ops.origami.export_settings(filepath=str(tmp_path / "settings.json")) == {"FINISHED"}
    told = json.loads((tmp_path / "settings.json").read_text(encoding="utf-8"))
    assert told["creases"] == [[30, 350, 570, 350], [200, 40, 200, 600.5]]
    assert len(told["outline"]) == 4
    assert told["reference"] == CASE.model.cameras[0].name


def test_the_window_shows_the_warnings_of_the_command_line(document):
    group = document.collection.origami
    assert json.loads(group.place.warnings) == ["One photo is a copy."]
    assert json.loads(group.surface.warnings) == ["Crease 3 lies outside."]
    assert json.loads(group.find.warnings) == []
