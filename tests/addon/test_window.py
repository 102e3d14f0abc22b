"""The window's buttons, through the operators behind them: rectify, and re-run from any step."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from finished_document import stages


def test_every_stage_is_done_and_shown(document):
    assert all(stage.done for stage in stages(document).values())
    roles = [each["origami_role"] for each in document.collection.objects]
    assert set(roles) == {"origin", "camera", "outline", "page", "page frame", "points", "sheet"}
    assert roles.count("camera") == json.loads(stages(document)["place"].figures)["photos_placed"] == 6
    sheet = document.object("sheet")
    assert {"page", "photo"} <= {layer.name for layer in sheet.data.uv_layers}
    assert sheet.data.materials[0]["use"] == "page"


def test_the_scene_keeps_its_own_settings(document):
    """Even one without a camera, a world and units of the user's."""
    import bpy

    scene = bpy.context.scene
    assert scene.camera is None and scene.world is None
    factory = bpy.data.scenes.new("factory")
    for group, names in {
        "render": ("resolution_x", "resolution_y", "resolution_percentage"),
        "view_settings": ("view_transform", "look", "exposure"),
        "unit_settings": ("system", "length_unit", "scale_length"),
    }.items():
        for name in names:
            assert getattr(getattr(scene, group), name) == getattr(getattr(factory, group), name), name


def test_pictures_are_part_of_the_file(document):
    import bpy

    shown = [image for image in bpy.data.images if image.get("origami_document") and "photo" not in image.name]
    assert len(shown) == 7
    assert all(image.packed_file is not None and image.size[0] > 0 for image in shown)


def test_a_paper_size_that_was_meant_in_inches_is_asked_about(document):
    import bpy

    page = document.collection.origami.settings.page
    page.paper, page.width, page.height = "other", 8.5, 11
    with pytest.raises(RuntimeError, match=r"did you mean Letter or 8\.5x11in"):
        bpy.ops.origami.rectify()
    page.width, page.height = 80, 0
    assert bpy.ops.origami.rectify() == {"FINISHED"}


def test_a_step_without_those_before_it_says_which(document):
    import bpy

    assert bpy.ops.origami.run_stage(stage="place") == {"FINISHED"}
    for stage in ("surface", "unwrap", "page"):
        with pytest.raises(RuntimeError, match="Find Sheet is not done yet: run it first"):
            bpy.ops.origami.run_stage(stage=stage)


def test_edit_mode_meanwhile_is_left(document, monkeypatch):
    import bpy
    from origami.origami_addon.jobs.process import Job
    from origami.origami_addon.scene.modes import set_mode

    said = Job.messages

    def messages(job, wait=0.0):
        set_mode(document.object("sheet"), "EDIT")
        return said(job, wait)

    monkeypatch.setattr(Job, "messages", messages)
    document.collection.origami.settings.surface.grid_rows = 36
    assert bpy.ops.origami.rectify() == {"FINISHED"}
    assert all(stage.done for stage in stages(document).values())


def test_a_deleted_camera_is_reported_before_anything_changes(document):
    import bpy

    before = document.state_digest()
    bpy.data.objects.remove(document.objects("camera")[1])
    with pytest.raises(RuntimeError, match=r"The camera of .* is no longer in the collection"):
        bpy.ops.origami.run_stage(stage="unwrap")
    assert document.state_digest() == before


def test_a_deleted_sheet_comes_back_with_the_page(document):
    import bpy

    bpy.data.objects.remove(document.object("sheet"))
    assert bpy.ops.origami.run_stage(stage="page") == {"FINISHED"}
    assert document.object("sheet") is not None


def test_a_result_that_no_longer_fits_is_not_taken(document, monkeypatch):
    import bpy
    from origami.origami_addon.jobs.process import Job

    said = Job.messages

    def messages(job, wait=0.0):
        stages(document)["surface"].done = False  # as Undo leaves it
        return said(job, wait)

    monkeypatch.setattr(Job, "messages", messages)
    before = document.state_digest()
    with pytest.raises(RuntimeError, match="changed while the work ran"):
        bpy.ops.origami.run_stage(stage="unwrap")
    assert document.state_digest() == before


def test_turning_the_page(document):
    import bpy
    from origami.origami_addon.scene.sheet_materials import page_image

    width, height = page_image(document).size
    assert bpy.ops.origami.turn_page(clockwise=True) == {"FINISHED"}
    assert tuple(page_image(document).size) == (height, width)
    assert bpy.ops.origami.turn_page(clockwise=False) == {"FINISHED"}
    assert tuple(page_image(document).size) == (width, height)


def test_settings_decide_where_a_run_begins(document):
    from origami.origami_addon.plan import first_stale
    from origami.origami_addon.scene.known import known_of

    group = document.collection.origami
    for change, stage in (
        (lambda: setattr(group.settings.image, "source", "reference"), "page"),
        (lambda: setattr(group.settings.page, "turn", "90"), "lay_out"),
        (lambda: setattr(group.settings.flatten, "ridge_rows", True), "unwrap"),
        (lambda: setattr(group.settings.surface, "grid_rows", 41), "surface"),
        (lambda: setattr(group.settings, "reference", group.photos[1].name), "find"),
        (lambda: setattr(group.photos[0], "use", False), "place"),
    ):
        change()
        assert first_stale(known_of(document)) == stage


def test_lost_photos_are_reported(document):
    import bpy

    group = document.collection.origami
    lost = [str(Path(path).with_name("lost.jpg")) for path in json.loads(group.photos_placed)]
    group.photos_placed = json.dumps(lost)
    with pytest.raises(RuntimeError, match=r"lost\.jpg .*Find Photos"):
        bpy.ops.origami.run_stage(stage="find")


def test_methods_are_compared_in_uv_maps_of_their_own(document):
    import bpy

    sheet = document.object("sheet")
    before = np.array([corner.vector[:] for corner in sheet.data.uv_layers["page"].uv])
    assert bpy.ops.origami.compare_methods() == {"FINISHED"}
    names = [layer.name for layer in sheet.data.uv_layers]
    assert names == [
        "page",
        "photo",
        "page arap",
        "page conformal_l1",
        "page lscm",
        "page geodesic",
        "page least_stretch",
    ]
    own, lscm = (
        np.array([corner.vector[:] for corner in sheet.data.uv_layers[name].uv]) for name in ("page arap", "page lscm")
    )
    np.testing.assert_allclose(own, before, atol=1e-6)
    assert 1e-6 < np.abs(own - lscm).max() < 0.1
    assert sheet.data.uv_layers.active.name == "page"


def test_nothing_is_done_twice(document):
    import bpy

    kept = document.collection["origami_state"]
    assert bpy.ops.origami.rectify() == {"CANCELLED"}
    assert document.collection["origami_state"] == kept


def test_other_photos_become_a_page_beside_the_page(document, small_set, tmp_path):
    import bpy
    from other_light_scene import negative
    from PIL import Image

    folder = tmp_path / "ultraviolet"
    folder.mkdir()
    photo = np.array(Image.open(small_set.photos[2].path))
    Image.fromarray(negative(photo)).save(folder / "one.png")
    assert bpy.ops.origami.add_other_light(directory=f"{folder}/") == {"FINISHED"}
    other, page = document.object("other page"), bpy.data.images["Brief ü page"]
    image = bpy.data.images["Brief ü ultraviolet"]
    assert other["other_photos"] == "ultraviolet"
    assert tuple(image.size) == tuple(page.size)
    assert image.packed_file is not None
    grey = [np.array(each.pixels[:]).reshape(-1, 4)[:, :3].mean(axis=1) for each in (image, page)]
    shown = grey[0] < 0.98  # the photo does not show all of the page
    assert np.corrcoef(grey[0][shown], grey[1][shown])[0, 1] < -0.5
    with pytest.raises(RuntimeError, match="There is no file or folder"):
        bpy.ops.origami.add_other_light(directory=f"{tmp_path / 'gone'}/")
