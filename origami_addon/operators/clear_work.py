"""Frees disk space."""

from __future__ import annotations

import bpy

from ...core.errors import StepFailed
from ..work_folder import clear, kept_bytes
from .needs import Operator


class ORIGAMI_OT_clear_work(Operator, bpy.types.Operator):
    """Delete the kept results of finished steps; documents are not affected, the next run takes longer"""

    bl_idname = "origami.clear_work"
    bl_label = "Clear Kept Results"
    alone = True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Delete the kept results."""
        before = kept_bytes()
        try:
            clear()
        except StepFailed as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{before / 1e6:.0f} MB freed")
        return {"FINISHED"}


CLASSES = (ORIGAMI_OT_clear_work,)
