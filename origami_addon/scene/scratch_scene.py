"""A temporary scene with one object, for Blender's operators that work on the selection."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy


@contextmanager
def alone(shown: bpy.types.Object) -> Iterator[bpy.types.Scene]:
    """Run the block in a new scene in which ``shown`` is the only object, selected and active, without its parent."""
    scene = bpy.data.scenes.new("origami scratch")
    scene.view_settings.view_transform = "Standard"
    scene.collection.objects.link(shown)
    layer = scene.view_layers[0]
    shown.select_set(True, view_layer=layer)
    layer.objects.active = shown
    parent = shown.parent
    try:
        shown.parent = None  # an export leaves out what hangs on an object of another scene
        layer.update()
        with bpy.context.temp_override(
            scene=scene, view_layer=layer, object=shown, active_object=shown, selected_objects=[shown]
        ):
            yield scene
    finally:
        bpy.data.scenes.remove(scene)
        shown.parent = parent
