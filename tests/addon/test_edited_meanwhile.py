"""The user goes to Edit Mode while results arrive, also through another object with the same data."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from origami.core.errors import StepFailed
from origami.origami_addon.scene.modes import in_edit_mode, in_object_mode, set_mode
from origami.origami_addon.scene.sheet_mesh import set_uv


@pytest.fixture
def square(empty_scene):
    """An object with one face, and a second one with the same mesh."""
    bpy.ops.mesh.primitive_plane_add()
    first = bpy.context.active_object
    second = bpy.data.objects.new("second", first.data)
    bpy.context.scene.collection.objects.link(second)
    return first, second


def edit(chosen):
    bpy.context.view_layer.objects.active = chosen
    bpy.ops.object.mode_set(mode="EDIT")


def test_a_mesh_is_in_edit_mode_through_each_of_its_objects(square):
    first, second = square
    assert not in_edit_mode(first)
    edit(second)
    assert in_edit_mode(first) and in_edit_mode(second)
    set_mode(first, "OBJECT")
    assert (second.mode, in_edit_mode(first)) == ("OBJECT", False)


def test_a_uv_map_is_written_whichever_object_is_edited(square):
    first, second = square
    edit(second)
    with in_object_mode(first):
        set_uv(first.data, "page", np.full((4, 2), 0.5))
    assert [tuple(each.vector) for each in first.data.uv_layers["page"].uv] == [(0.5, 0.5)] * 4


def test_more_uv_maps_than_blender_allows_are_a_sentence(square):
    first, _ = square
    while first.data.uv_layers.new() is not None:
        pass
    with pytest.raises(StepFailed, match="as many as Blender allows"):
        set_uv(first.data, "page", np.zeros((4, 2)))
