"""Edits the page: which way up it is, and where it ends."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty

from ...core.arrays import Array
from ...core.errors import UsageError
from ...core.page.page import check_corners, turn_of
from ..files.kept import Arrays
from ..jobs.requests import AnyRequest
from ..plan import Known, Plan, plan
from ..scene.chosen import active_document
from ..scene.edits import edits
from ..scene.modes import in_edit_mode, set_mode
from ..scene.page_object import corners_moved, framed_corners
from ..scene.read_back import read_back
from ..scene.roles import PAGE_FRAME
from ..state import LaidOut, reached
from .run_stages import StageOperator


class _PageOperator(StageOperator):
    role = PAGE_FRAME

    def plan(self, known: Known) -> Plan:
        reached(known.state, LaidOut)
        return plan(known, ("lay_out", "page"))


class ORIGAMI_OT_turn_page(_PageOperator, bpy.types.Operator):
    """Turn the page by a quarter and make it again"""

    bl_idname = "origami.turn_page"
    bl_label = "Turn Page"
    label = "Turn Page"

    clockwise: BoolProperty(name="Clockwise", description="Turn to the right instead of to the left", default=True)

    def prepare(self, context: bpy.types.Context) -> tuple[AnyRequest, Arrays]:
        """As for `StageOperator`, with the page turned by another quarter."""
        document = self.document
        state = reached(read_back(document).state, LaidOut)
        turn = turn_of(state.sheet, state.flat, state.sheet_reference) + (90 if self.clockwise else 270)
        document.collection.origami.settings.page.turn = str(turn % 360)
        return super().prepare(context)


class ORIGAMI_OT_apply_page_frame(_PageOperator, bpy.types.Operator):
    """Cut the page to its frame and make it again; a frame that is not a rectangle is straightened into one"""

    bl_idname = "origami.apply_page_frame"
    bl_label = "Apply Frame"
    label = "Apply Frame"

    @classmethod
    def missing(cls, context: bpy.types.Context) -> str:
        """A frame whose corners were moved."""
        document = active_document(context)
        frame = None if document is None else document.object(PAGE_FRAME)
        if document is not None and frame is not None and not in_edit_mode(frame) and "frame" not in edits(document):
            return "The frame is already where the page ends: move its corners first (Edit Frame)"
        return super().missing(context)

    def corners(self, plan: Plan) -> Array | None:
        """The corners of the frame."""
        if plan.stages[0] != "lay_out":
            raise UsageError("The sheet was edited since it was unwrapped: press Unwrap, then move the corners.")
        frame_object, flat = self.object, reached(plan.start, LaidOut).flat
        set_mode(frame_object, "OBJECT")
        if not corners_moved(frame_object, flat):
            raise UsageError("The frame is already where the page ends: move its corners first.")
        corners = framed_corners(frame_object, flat)
        check_corners(corners)
        return corners


CLASSES = (ORIGAMI_OT_turn_page, ORIGAMI_OT_apply_page_frame)
