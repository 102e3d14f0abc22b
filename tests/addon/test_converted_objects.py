"""Whatever the user makes of a document's objects, the tab is drawn, and every button works or says why not."""

from __future__ import annotations

import importlib.util
import sys

import bpy
import pytest
from folded import folded_sheet
from folded_document import folded_document
from origami.core.errors import StepFailed
from origami.origami_addon.jobs import running
from origami.origami_addon.scene.roles import OUTLINE, PAGE_FRAME, POINTS, SHEET


@pytest.fixture
def document(add_on, tmp_path):
    made = folded_document("Brief", folded_sheet(), tmp_path, pack=True)
    bpy.context.scene.origami.document = made.collection
    bpy.context.view_layer.update()
    return made


@pytest.fixture
def tab(root):
    """What the tab shows: the buttons and the settings."""
    spec = importlib.util.spec_from_file_location("buttons", root / "tests" / "blender" / "buttons.py")
    buttons = importlib.util.module_from_spec(spec)
    sys.modules["buttons"] = buttons
    spec.loader.exec_module(buttons)
    yield buttons.shown
    del sys.modules["buttons"]


def convert(shown, kind):
    """As Object > Convert does it."""
    shown.hide_set(False)
    bpy.context.view_layer.objects.active = shown
    for each in bpy.context.view_layer.objects:
        each.select_set(each == shown)
    bpy.ops.object.convert(target=kind)


def to_curve(document):
    convert(document.object(SHEET), "CURVE")


def to_mesh(document):
    convert(document.object(OUTLINE), "MESH")


def frame_to_curve(document):
    convert(document.object(PAGE_FRAME), "CURVE")


def points_to_curve(document):
    convert(document.object(POINTS), "CURVE")


def empty_sheet(document):
    document.object(SHEET).data.clear_geometry()


def empty_frame(document):
    document.object(PAGE_FRAME).data.clear_geometry()


def empty_points(document):
    document.object(POINTS).data.clear_geometry()


def other_points(document):
    """As where the points of an earlier model are left."""
    attribute = document.object(POINTS).data.attributes["point"]
    attribute.data.foreach_set("value", [value.value + 1 for value in attribute.data])


def no_outline_points(document):
    document.object(OUTLINE).data.splines.clear()


def excluded(document):
    bpy.context.view_layer.layer_collection.children[document.collection.name].exclude = True


def hidden(document):
    document.collection.hide_viewport = True


def elsewhere(document):
    bpy.data.scenes.new("other").collection.children.link(document.collection)
    bpy.context.scene.collection.children.unlink(document.collection)


CHANGES = (
    *(
        to_curve,
        to_mesh,
        frame_to_curve,
        points_to_curve,
        empty_sheet,
        empty_frame,
        empty_points,
        other_points,
        no_outline_points,
    ),
    *(excluded, hidden, elsewhere),
)
# They ask, or begin a job.
NOT_PRESSED = {
    "add_photos",
    "add_folders",
    "export",
    "find_photos",
    "add_other_light",
    "export_settings",
    "rectify_all",
}


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_the_tab_works_or_says_why_not(document, tab, change, monkeypatch):
    from origami.origami_addon.operators import job_operator
    from origami.origami_addon.window import overlay, panels

    def refuse(*_):
        raise StepFailed("No job here.")

    monkeypatch.setattr(job_operator, "Job", refuse)
    change(document)
    bpy.context.view_layer.update()
    window = bpy.context.window_manager.windows[0]
    area = next(each for each in window.screen.areas if each.type == "VIEW_3D")
    region = next(each for each in area.regions if each.type == "UI")
    with bpy.context.temp_override(window=window, area=area, region=region):
        buttons, _ = tab(panels)
    overlay._drawn.key = ()
    overlay._refresh(document)
    running.forget_failures()
    pressed = 0
    for button in sorted(buttons, key=lambda each: each.operator == "delete_document"):
        if button.operator in NOT_PRESSED or not button.is_enabled():
            continue
        bpy.context.scene.origami.document = document.collection
        pressed += 1
        try:
            button.call(**button.properties)
        except RuntimeError as error:
            assert "Traceback" not in str(error), (str(button), str(error))
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
    assert pressed


def test_edits_of_a_copy_are_not_edits_of_the_document(document):
    from origami.origami_addon.scene.edits import edits

    copy = document.object(SHEET).copy()
    copy.data = copy.data.copy()
    copy.name = "z"
    bpy.context.scene.collection.objects.link(copy)
    copy.data.vertices[0].co.z += 1
    copy.data.update()
    bpy.context.view_layer.update()
    assert not edits(document)
    document.object(SHEET).data.vertices[0].co.z += 1
    document.object(SHEET).data.update()
    bpy.context.view_layer.update()
    assert "vertices" in edits(document)
