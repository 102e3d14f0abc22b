"""The buttons beside the progress bar."""

from __future__ import annotations

import bpy

from ..jobs import running


class _Ending:
    wish: running.Wish

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether anything runs."""
        if running.current() is None:
            cls.poll_message_set("Nothing is running")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Pass the request to the operator that follows the job."""
        now = running.current()
        if now is not None:
            now.wish = self.wish
        return {"FINISHED"}


class ORIGAMI_OT_stop(_Ending, bpy.types.Operator):
    """Stop the current run and keep the finished stages"""

    bl_idname = "origami.stop"
    bl_label = "Stop"
    wish = "stop"


class ORIGAMI_OT_cancel(_Ending, bpy.types.Operator):
    """Stop the current run and undo what it has done so far"""

    bl_idname = "origami.cancel"
    bl_label = "Cancel"
    wish = "cancel"


CLASSES = (ORIGAMI_OT_stop, ORIGAMI_OT_cancel)
