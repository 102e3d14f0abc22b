"""Edits the paper's edge."""

from __future__ import annotations

import bpy

from ...core.errors import OrigamiError
from ..scene.roles import OUTLINE
from ..scene.show import find_camera
from ..state import Found
from .look import look_through, make_active
from .needs import DocumentOperator


class ORIGAMI_OT_edit_outline(DocumentOperator, bpy.types.Operator):
    """Edit the paper's edge over the reference photo: move, add or delete points, then re-run from here"""

    bl_idname = "origami.edit_outline"
    bl_label = "Edit Outline"
    bl_options = {"REGISTER", "UNDO"}
    role = OUTLINE

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Look through the reference camera and edit the curve."""
        outline = self.object
        try:
            camera_object = find_camera(self.document, self.document.reached(Found).reference)
            make_active(context, outline)
        except OrigamiError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        look_through(context, camera_object)
        bpy.ops.object.mode_set(mode="EDIT")
        return {"FINISHED"}


CLASSES = (ORIGAMI_OT_edit_outline,)
