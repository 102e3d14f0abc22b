"""Taking another sheet by a click."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from table_scene import TWO_PLACES, two_sheets


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """The folder of photos aimed between two sheets."""
    return tmp_path_factory.mktemp("table")


@pytest.fixture(scope="module")
def found(lasting_add_on, folder, tmp_path_factory) -> Path:
    """A .blend whose photos are placed and whose first sheet is found."""
    import bpy
    from origami.origami_addon.scene.document import documents
    from origami.origami_addon.scene.known import settings_of
    from origami.origami_addon.scene.settings_group import settings_to_json
    from origami.origami_addon.scene.show import Pictures, show_cameras
    from origami.origami_addon.state import Placed

    table = two_sheets()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    paths = [folder / camera.name for camera in table.model.cameras]
    for path, photo in zip(paths, table.photos, strict=True):
        Image.fromarray(photo).save(path)
    assert bpy.ops.origami.add_photos(directory=f"{folder}/", preset="sheet", new=True) == {"FINISHED"}
    (document,) = documents()
    document.state = Placed(table.model)
    for _ in show_cameras(document, document.state, Pictures(paths, paths, pack=False)):
        pass
    group = document.collection.origami
    group.photos_placed = json.dumps([bpy.path.abspath(photo.path) for photo in group.photos])
    group.place.done = True
    group.place.settings = settings_of("place", settings_to_json(group.settings))
    assert bpy.ops.origami.run_stage(stage="find") == {"FINISHED"}
    path = tmp_path_factory.mktemp("document") / "found.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture
def document(found, reopen):
    """The document of `found`, reopened."""
    return reopen(found)


def middle(document) -> np.ndarray:
    """The middle of the found outline on the table."""
    region = document.state.region
    camera = document.state.model.cameras[region.reference]
    rays = camera.to_world_frame(
        np.column_stack([camera.undistort(region.outline.polygon), np.ones(len(region.outline.polygon))])
    )
    away = rays - camera.center
    return (camera.center + away * (-camera.center[2] / away[:, 2:])).mean(axis=0)[:2]


def pixel(document, place) -> tuple[float, float]:
    state = document.state
    return tuple(state.model.cameras[state.region.reference].project(np.array([*place, 0.0])))


def other_place(document) -> tuple[float, float]:
    return max(TWO_PLACES, key=lambda at: np.linalg.norm(middle(document) - at))


def test_the_sheet_under_the_place_is_taken(document):
    import bpy

    group = document.collection.origami
    assert len(document.state.region.in_view) == 2
    first, second = middle(document), other_place(document)
    assert bpy.ops.origami.pick_sheet(place=pixel(document, second)) == {"FINISHED"}
    assert group.settings.sheet == 2
    assert np.linalg.norm(middle(document) - second) < 0.05
    assert json.loads(group.find.settings)["sheet"] == 2
    assert bpy.ops.origami.pick_sheet(place=pixel(document, first)) == {"FINISHED"}
    assert group.settings.sheet == 1
    assert np.linalg.norm(middle(document) - first) < 0.01


def test_where_no_other_sheet_is(document):
    import bpy

    kept = document.collection["origami_state"]
    with pytest.raises(RuntimeError, match=r"No sheet was found there: .* Edit Outline"):
        bpy.ops.origami.pick_sheet(place=(1.0, 1.0))
    with pytest.raises(RuntimeError, match="already chosen"):
        bpy.ops.origami.pick_sheet(place=pixel(document, middle(document)))
    assert document.collection["origami_state"] == kept
    assert document.collection.origami.settings.sheet == 1


@pytest.fixture
def lost_photo(folder, found, tmp_path):
    """One of the photos is elsewhere."""
    photo = next(folder.iterdir())
    away = photo.rename(tmp_path / photo.name)
    yield
    away.rename(photo)


def test_a_pick_that_fails_changes_nothing(document, lost_photo):
    import bpy

    kept, place = document.collection["origami_state"], pixel(document, other_place(document))
    with pytest.raises(RuntimeError, match="no longer where they were"):
        bpy.ops.origami.pick_sheet(place=place)
    assert document.collection["origami_state"] == kept
    assert document.collection.origami.settings.sheet == 1
    assert document.collection.origami.find.done


def test_after_an_outline_by_hand_the_sheets_are_not_known(document):
    from dataclasses import replace

    import bpy

    state = document.state
    document.state = replace(state, region=replace(state.region, in_view=()))
    with pytest.raises(RuntimeError, match="press Find Sheet, then Pick Sheet again"):
        bpy.ops.origami.pick_sheet(place=(1.0, 1.0))


def test_the_sheets_in_view_survive_the_state_as_arrays(document):
    from origami.origami_addon.state import region_arrays, region_from_arrays

    region = document.state.region
    again = region_from_arrays(region_arrays(region))
    assert len(again.in_view) == 2
    assert all(map(np.array_equal, again.in_view, region.in_view))
    of_before = {name: array for name, array in region_arrays(region).items() if not name.startswith("edge")}
    assert region_from_arrays(of_before).in_view == ()


@pytest.fixture
def clicking(document, monkeypatch):
    """The waiting operator, in a view that shows the reference photo pixel for pixel, and its actions."""
    from origami.origami_addon.operators import pick_sheet

    camera = document.state.model.cameras[document.state.region.reference]
    said, taken, restored = [], [], []
    monkeypatch.setattr(pick_sheet, "view_under_mouse", lambda *_: SimpleNamespace(x=0, y=0))
    monkeypatch.setattr(pick_sheet, "_in_view", lambda edge, view: camera.project(edge))
    monkeypatch.setattr(pick_sheet, "clear_status", lambda *_: None)
    monkeypatch.setattr(pick_sheet, "_before", lambda **how: restored.append(not how))
    cursor = SimpleNamespace(cursor_modal_restore=lambda: None)
    operator = SimpleNamespace(
        _number=pick_sheet._picks,
        _edges=document.state.region.in_view,
        _document=document.name,
        _title=document.title,
        _state_digest=document.state_digest(),
        _workspace="",
        report=lambda kind, text: said.append(text),
        _take=lambda number: taken.append(number) or {"FINISHED"},
    )
    kind = pick_sheet.ORIGAMI_OT_pick_sheet
    operator.cancel = lambda context: kind.cancel(operator, context)
    operator._give_up = lambda context: kind._give_up(operator, context)

    def does(event: str, place=(0.0, 0.0)) -> set[str]:
        import bpy

        context = SimpleNamespace(window=cursor, scene=bpy.context.scene, active_object=None)
        mouse = SimpleNamespace(type=event, value="PRESS", mouse_x=place[0], mouse_y=place[1])
        return kind.modal(operator, context, mouse)

    return SimpleNamespace(does=does, said=said, taken=taken, restored=restored, operator=operator)


def test_a_click_takes_the_sheet_and_any_other_place_waits_for_one(document, clicking):
    assert clicking.does("MOUSEMOVE") == {"PASS_THROUGH"}
    assert clicking.does("LEFTMOUSE", (1.0, 1.0)) == {"RUNNING_MODAL"}
    assert clicking.does("LEFTMOUSE", pixel(document, middle(document))) == {"RUNNING_MODAL"}
    assert [text.partition(":")[0] for text in clicking.said] == [
        "No sheet was found there",
        "That sheet is already chosen",
    ]
    assert clicking.does("LEFTMOUSE", pixel(document, other_place(document))) == {"FINISHED"}
    assert clicking.taken == [2]


@pytest.mark.parametrize("key", ["ESC", "RIGHTMOUSE"])
def test_esc_gives_the_view_back_and_changes_nothing(document, clicking, key):
    clicking.does("LEFTMOUSE", (1.0, 1.0))
    assert clicking.does(key) == {"CANCELLED"}
    assert clicking.restored == [False, True]  # how transparent objects are, then everything
    assert clicking.taken == []
    assert document.collection.origami.settings.sheet == 1


def test_a_second_press_takes_over(clicking):
    clicking.operator._number -= 1
    assert clicking.does("ESC") == {"CANCELLED"}
    assert clicking.restored == []


def test_a_document_that_changed_meanwhile_is_reported(document, clicking):
    from dataclasses import replace

    state = document.state
    document.state = replace(state, region=replace(state.region, in_view=()))
    assert clicking.does("LEFTMOUSE", (1.0, 1.0)) == {"CANCELLED"}
    assert "press Pick Sheet again" in clicking.said[0]
    assert clicking.restored == [False, True]
    assert clicking.taken == []


def test_the_views_are_given_back(document):
    import bpy
    from origami.origami_addon.operators.look import look_through, views_to_restore
    from origami.origami_addon.scene.roles import CAMERA

    scene = bpy.context.scene
    before = scene.camera, scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage
    restore = views_to_restore(bpy.context)
    look_through(bpy.context, document.objects(CAMERA)[-1])
    scene.render.resolution_percentage = 50
    restore()
    assert before == (
        *(scene.camera, scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage),
    )
