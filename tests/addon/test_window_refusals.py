"""What the buttons say without the photos or the results that they need."""

from __future__ import annotations

import pytest


def test_buttons_say_why_they_are_grey(lasting_add_on, empty_scene):
    import bpy

    for operator, why in (
        (bpy.ops.origami.rectify, "Add the photos"),
        (bpy.ops.origami.run_stage, "Add the photos"),
        (bpy.ops.origami.edit_outline, "find the sheet first"),
        (bpy.ops.origami.look_through, "place the photos first"),
        (bpy.ops.origami.turn_page, "no page yet"),
        (bpy.ops.origami.edit_page_frame, "no page yet"),
        (bpy.ops.origami.apply_page_frame, "no page yet"),
        (bpy.ops.origami.show_as, "no page yet"),
        (bpy.ops.origami.remove_photo, "no photo"),
        (bpy.ops.origami.apply_preset, "Add the photos"),
        (bpy.ops.origami.stop, "Nothing is running"),
        (bpy.ops.origami.cancel, "Nothing is running"),
    ):
        with pytest.raises(RuntimeError, match=why):
            operator()


def test_a_folder_without_photos_is_reported(lasting_add_on, empty_scene, tmp_path):
    import bpy

    with pytest.raises(RuntimeError, match="no photos in"):
        bpy.ops.origami.add_photos(directory=f"{tmp_path}/", new=True)
    assert not bpy.data.collections


def test_two_photos_are_too_few(lasting_add_on, empty_scene, small_set):
    import bpy

    folder = small_set.photos[0].path.parent
    files = [{"name": photo.path.name} for photo in small_set.photos[:2]]
    bpy.ops.origami.add_photos(directory=f"{folder}/", files=files, new=True)
    with pytest.raises(RuntimeError, match="at least 3 photos are needed"):
        bpy.ops.origami.rectify()
    (collection,) = bpy.data.collections
    assert len(collection.origami.photos) == 2
    assert not collection.origami.place.done
