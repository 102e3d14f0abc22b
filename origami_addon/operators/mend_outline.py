"""Mending the paper's edge."""

from __future__ import annotations

import bpy

from ...core.errors import StepFailed
from ..scene.read_back import reference_of
from ..scene.show import OUTLINE, find_camera
from .look import look_through, make_active
from .needs import active_document, has


class ORIGAMI_OT_edit_outline(bpy.types.Operator):
    """Edit the paper's edge over the reference photo: move, add or delete points, then run on from there"""

    bl_idname = "origami.edit_outline"
    bl_label = "Edit Outline"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether there is an outline."""
        return has(cls, context, OUTLINE)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Look through the reference camera and edit the curve."""
        document = active_document(context)
        assert document is not None
        outline = document.object(OUTLINE)
        assert outline is not None
        try:
            camera_object = find_camera(document, reference_of(document.state))
        except StepFailed as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        look_through(context, camera_object)
        make_active(context, outline)
        bpy.ops.object.mode_set(mode="EDIT")
        return {"FINISHED"}


CLASSES = (ORIGAMI_OT_edit_outline,)
