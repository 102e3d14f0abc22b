"""The window continues a small document of the command line, whose objects a user may have touched."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from folded import folded_sheet
from folded_document import folded_document, pictures_of
from origami.core.errors import StepFailed, UsageError
from origami.origami_addon.report import Report
from origami.origami_addon.settings import RunSettings
from PIL import Image

CASE = folded_sheet()
STATE_AS_FOUND = {"blend": "NONE", "depth_test": "NONE", "point_size": 1.0}


@pytest.fixture
def document(add_on, tmp_path):
    """A document filled by the command line, with given creases and outline, and warnings in some steps."""
    from origami.origami_addon.scene.document_group import fill_group

    made = folded_document("Brief ü", CASE, tmp_path)
    outline = tuple((float(x), float(y)) for x, y in CASE.state.region.outline.polygon)
    creases = ((30.0, 350.0, 570.0, 350.0), (200.0, 40.0, 200.0, 600.5))
    settings = RunSettings(reference=CASE.model.cameras[0].name, outline=outline, creases=creases)
    report = Report({})
    with report.stage("read photos"):
        report.warn("One photo is a copy.")
    with report.stage("build surface") as figures:
        figures |= {"fold_angles_degrees": [57.3, float("nan")], "creases": 2}
        report.warn("Crease 3 lies outside.")
    fill_group(made, [], settings, report, {})
    return made


def test_the_window_goes_on_with_what_the_command_line_was_given(document, tmp_path):
    import bpy

    assert bpy.ops.origami.export_settings(filepath=str(tmp_path / "settings.json")) == {"FINISHED"}
    written = json.loads((tmp_path / "settings.json").read_text(encoding="utf-8"))
    assert written["creases"] == [[30, 350, 570, 350], [200, 40, 200, 600.5]]
    assert len(written["outline"]) == 4
    assert written["reference"] == CASE.model.cameras[0].name


def test_the_window_shows_the_warnings_of_the_command_line(document):
    group = document.collection.origami
    assert json.loads(group.place.warnings) == ["One photo is a copy."]
    assert json.loads(group.surface.warnings) == ["Crease 3 lies outside."]
    assert json.loads(group.find.warnings) == []


def test_a_sheet_is_coloured_by_its_bound_where_that_is_known(document):
    import bpy
    from origami.origami_addon.operators.look import ORIGAMI_OT_show_sheet
    from origami.origami_addon.scene.sheet_mesh import put_sheet

    with pytest.raises(RuntimeError, match="is not known"):
        bpy.ops.origami.show_sheet(by="BOUND")
    sheet = replace(CASE.sheet, bound=np.full(len(CASE.sheet.vertices), 0.01))
    shown = document.object("sheet")
    put_sheet(shown, sheet, CASE.flat, CASE.model.cameras[0], document.frame)
    assert bpy.ops.origami.show_sheet(by="BOUND") == {"FINISHED"}
    assert shown.data.color_attributes.active_color.name == "page bound color"
    assert bpy.ops.origami.show_sheet(by="VERTEX") == {"FINISHED"}
    assert shown.data.color_attributes.active_color.name == "stretch color"
    says = ORIGAMI_OT_show_sheet.description(bpy.context, SimpleNamespace(by="BOUND"))
    assert says.startswith("Blue where the page is exact")


def test_a_page_edited_by_hand_has_no_bound(document):
    from origami.origami_addon.scene.read_back import read_back

    known = replace(CASE.state, sheet=replace(CASE.sheet, bound=np.full(len(CASE.sheet.vertices), 0.01)))
    document.state = known
    assert read_back(document).state.sheet.bound is not None
    mesh = document.object("sheet").data
    for corner in mesh.loops:
        if corner.vertex_index == 40:
            mesh.uv_layers["page"].uv[corner.index].vector = (0.9, 0.9)
    assert read_back(document).state.sheet.bound is None


def test_an_erased_crease_leaves_the_others_their_numbers(document):
    """The list, the lines over the view and the button that drops a crease all refer to the same crease."""
    import bpy
    from mathutils import Vector
    from origami.origami_addon.operators.edit_creases import ORIGAMI_OT_drop_crease, creases_in_photo
    from origami.origami_addon.scene.read_back import read_back
    from origami.origami_addon.window import overlay
    from origami.origami_addon.window.crease_list import ListedCrease, listed_creases

    def without(number):
        return ORIGAMI_OT_drop_crease.creases(SimpleNamespace(index=number, object=sheet), read_back(document).state)

    sheet = document.object("sheet")
    valley, flat = CASE.sheet.ridges
    across, along = creases_in_photo(document.state)
    first, second = listed_creases(document)
    assert first.text == "valley, 57°"
    assert second.text.endswith(", 0°")
    assert (without(0), without(1)) == ([along], [across])

    sheet.vertex_groups["ridge"].remove(np.setdiff1d(valley, flat).tolist())
    sheet.vertex_groups["ridge"].add([5 * 25 + column for column in range(11, 24)], 1.0, "REPLACE")
    sheet.data.update()
    bpy.context.view_layer.update()
    assert listed_creases(document) == [ListedCrease(0, "erased", False), second]
    overlay._refresh(document)
    (known, color), (painted, unknown) = overlay._drawn.creases
    np.testing.assert_array_equal(known, [sheet.matrix_world @ sheet.data.vertices[vertex].co for vertex in flat])
    on_sheet, on_page = overlay._drawn.numbered[1]  # the erased one cannot be marked
    assert len(overlay._drawn.numbered) == 1
    np.testing.assert_array_equal(on_sheet, known)
    unit = 1e-3 if CASE.state.flat.unit == "mm" else 1 / CASE.state.flat.height
    places = np.column_stack([CASE.state.flat.uv[flat] * (unit, -unit), np.zeros(len(flat))])
    page = document.object("page")
    np.testing.assert_allclose(on_page, [page.matrix_world @ Vector(place) for place in places], atol=1e-6)
    assert len(painted) > 8
    assert color != unknown == overlay._UNKNOWN
    (left,) = without(1)
    assert left not in (across, along)
    with pytest.raises(UsageError, match="Crease 1 is no longer on the sheet"):
        without(0)


def drag_uv(document):
    layer = document.object("sheet").data.uv_layers["page"]
    for corner in layer.uv:
        corner.vector.x = 0.5 + 0.9 * (corner.vector.x - 0.5)


def paint_ridge(document):
    document.object("sheet").vertex_groups["ridge"].add([5 * 25 + column for column in range(11, 24)], 1.0, "REPLACE")


def move_vertex(document):
    document.object("sheet").data.vertices[200].co.z += 0.01


def move_outline(document):
    document.object("outline").data.splines[0].points[0].co.x *= 0.9


def move_corner(document):
    document.object("page frame").data.vertices[0].co.x += 0.01


@pytest.mark.parametrize(
    "edit, role, part, first",
    [
        (move_outline, "outline", "outline", "surface"),
        (move_vertex, "sheet", "vertices", "unwrap"),
        (paint_ridge, "sheet", "creases", "unwrap"),
        (drag_uv, "sheet", "page", "page"),
        (move_corner, "page frame", "frame", "page"),
    ],
)
def test_the_panel_says_from_which_stage_on_an_edit_counts(document, edit, role, part, first):
    """For a dragged UV map it once said that Unwrap should run, which discards the drag."""
    import bpy
    from origami.origami_addon.scene.edits import edits
    from origami.origami_addon.scene.read_back import read_back
    from origami.origami_addon.stages import STAGES
    from origami.origami_addon.window.stage_text import state_of

    edit(document)
    document.object(role).data.update_tag()
    bpy.context.view_layer.update()
    edited = [stage for stage in STAGES if state_of(document, stage).text.startswith("Edited by hand")]
    assert edited == list(STAGES[STAGES.index(first) :])
    assert edits(document) == {part}
    assert read_back(document).edited == {part} - {"frame"}


def test_points_that_cannot_be_read_are_not_drawn(document):
    """In Edit Mode their attributes are empty; points of another document do not count."""
    import bpy
    from origami.origami_addon.scene.document import new_document
    from origami.origami_addon.window import overlay

    points = document.object("points")
    count = len(points.data.vertices)

    def drawn():
        overlay._drawn.key = ()
        overlay._refresh(document)
        assert len(overlay._drawn.points) == len(overlay._drawn.colors)
        return len(overlay._drawn.points)

    bpy.context.view_layer.objects.active = points
    assert drawn() == count
    bpy.ops.object.mode_set(mode="EDIT")
    assert drawn() == 0
    bpy.ops.object.mode_set(mode="OBJECT")
    assert drawn() == count
    overlay._refresh(new_document("without points", bpy.context.scene))
    assert len(overlay._drawn.points) == len(overlay._drawn.colors) == 0


def test_a_failure_while_drawing_leaves_the_view_as_it_was(document, monkeypatch):
    import bpy
    from origami.origami_addon.window import overlay

    state = {}

    def fail(*_):
        raise ValueError

    setters = {f"{name}_set": lambda value, name=name: state.update({name: value}) for name in STATE_AS_FOUND}
    shaders = SimpleNamespace(from_builtin=lambda _: None)
    monkeypatch.setitem(sys.modules, "gpu", SimpleNamespace(state=SimpleNamespace(**setters), shader=shaders))
    monkeypatch.setitem(sys.modules, "gpu_extras.batch", SimpleNamespace(batch_for_shader=fail))
    bpy.context.scene.origami.show_errors = True
    with pytest.raises(ValueError):
        overlay._draw()
    assert state == STATE_AS_FOUND


def test_a_deleted_group_of_ridges_can_be_painted_again(document):
    import bpy

    sheet = document.object("sheet")
    sheet.vertex_groups.remove(sheet.vertex_groups["ridge"])
    assert bpy.ops.origami.paint_ridges() == {"FINISHED"}
    assert (sheet.mode, sheet.vertex_groups.active.name) == ("WEIGHT_PAINT", "ridge")


def test_an_outline_without_its_camera_is_reported(document):
    import bpy

    bpy.data.objects.remove(document.objects("camera")[0])
    with pytest.raises(RuntimeError, match="run Place Photos again"):
        bpy.ops.origami.edit_outline()
    assert document.object("outline").mode == "OBJECT"


def test_a_sheet_deleted_during_a_comparison_is_reported(document):
    import bpy
    from origami.origami_addon.operators.compare import ORIGAMI_OT_compare_methods

    bpy.data.objects.remove(document.object("sheet"))
    running = SimpleNamespace(object=document.object("sheet"))
    with pytest.raises(StepFailed, match="was deleted"):
        next(ORIGAMI_OT_compare_methods.apply(running, bpy.context, {"done": "arap"}, None))


def test_a_scene_with_a_camera_of_the_users_keeps_its_settings(document, tmp_path):
    import bpy

    scene = bpy.context.scene
    assert scene.camera["photo"] == CASE.model.cameras[0].name
    mine = bpy.data.objects.new("hero", bpy.data.cameras.new("hero"))
    scene.collection.objects.link(mine)
    scene.camera = mine
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 1234, 567, 50
    scene.unit_settings.system, scene.view_settings.view_transform = "IMPERIAL", "AgX"
    folded_document("another", CASE, tmp_path / "others")
    assert scene.camera == mine
    render = scene.render
    assert (render.resolution_x, render.resolution_y, render.resolution_percentage) == (1234, 567, 50)
    assert (scene.unit_settings.system, scene.view_settings.view_transform) == ("IMPERIAL", "AgX")


def test_a_second_document_stands_beside_the_first_and_its_origin_moves_all_of_it(document, tmp_path):
    import bpy
    from origami.origami_addon.scene.free_ground import stand_beside_others
    from origami.origami_addon.scene.show import show_page, show_sheet

    another = folded_document("another", CASE, tmp_path / "others")
    stand_beside_others(another, ("sheet", "page frame"))
    bpy.context.view_layer.update()
    first, second = (corners_on_the_ground(each) for each in (document, another))
    assert first[:, 0].max() < second[:, 0].min()
    sheet, camera, origin = another.object("sheet"), another.objects("camera")[0], another.object("origin")
    np.testing.assert_allclose(sheet.matrix_world.translation, origin.location, atol=1e-6)
    apart = camera.matrix_world.translation - sheet.matrix_world.translation
    origin.location = (3, 4, 0.5)
    for _ in (
        *show_sheet(another, CASE.state, pictures_of(CASE, tmp_path / "others")),
        *show_page(another, CASE.state, tmp_path / "page.jpg", pack=False),
    ):
        pass
    stand_beside_others(another, ("sheet", "page frame"))
    bpy.context.view_layer.update()
    assert tuple(origin.location) == (3, 4, 0.5)
    np.testing.assert_allclose(sheet.matrix_world.translation, (3, 4, 0.5), atol=1e-6)
    np.testing.assert_allclose(camera.matrix_world.translation - sheet.matrix_world.translation, apart, atol=1e-5)


def corners_on_the_ground(document) -> np.ndarray:
    corners = []
    for role in ("sheet", "page frame"):
        shown = document.object(role)
        matrix = np.array(shown.matrix_world)
        corners += [matrix[:2, :3] @ corner[:] + matrix[:2, 3] for corner in shown.bound_box]
    return np.array(corners)


def test_pages_of_other_photos_lie_beside_the_page_until_it_is_made_again(document, tmp_path):
    import bpy
    from origami.origami_addon.scene.roles import OTHER_PAGE
    from origami.origami_addon.scene.show import show_other_page, show_page

    picture = tmp_path / "other_light.png"
    Image.new("RGB", (40, 50), (20, 30, 90)).save(picture)
    before = set(bpy.data.images)
    for name in ("ultraviolet", "raking", "ultraviolet"):
        for _ in show_other_page(document, CASE.flat, name, picture):
            pass
    page, *others = document.object("page"), *document.objects(OTHER_PAGE)
    assert [each["other_photos"] for each in others] == ["raking", "ultraviolet"]
    assert page.location.x < others[0].location.x < others[1].location.x
    for each in others:
        np.testing.assert_allclose(each.dimensions, page.dimensions)
        assert [layer.name for layer in each.data.uv_layers] == ["page"]
    added = set(bpy.data.images) - before
    assert {image.name for image in added} == {"Brief ü raking", "Brief ü ultraviolet"}
    assert all(image.packed_file is not None for image in added)
    for _ in show_page(document, CASE.state, tmp_path / "page.jpg", pack=False):
        pass
    assert document.objects(OTHER_PAGE) == []
    assert not {image.name for image in bpy.data.images} & {"Brief ü raking", "Brief ü ultraviolet"}
