"""Making room on the disk."""

from __future__ import annotations

import bpy

from ...core.errors import StepFailed
from ..work_folder import clear, kept_bytes
from .needs import Operator


class ORIGAMI_OT_clear_work(Operator, bpy.types.Operator):
    """Delete what is kept of finished steps to go on from; documents stay whole, another run takes longer once"""

    bl_idname = "origami.clear_work"
    bl_label = "Clear Kept Results"
    alone = True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Delete it."""
        before = kept_bytes()
        try:
            clear()
        except StepFailed as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{before / 1e6:.0f} MB freed")
        return {"FINISHED"}


CLASSES = (ORIGAMI_OT_clear_work,)
