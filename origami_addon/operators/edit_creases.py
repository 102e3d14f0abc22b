"""Edits the creases: drop one, or rebuild the sheet with the painted ones."""

from __future__ import annotations

import bpy
from bpy.props import IntProperty

from ...core.errors import UsageError
from ..plan import Crease, Known, Plan, plan
from ..scene.ridge_group import RIDGE_GROUP, read_creases
from ..scene.roles import SHEET
from ..scene.view import redraw_views
from ..stages import STAGES
from ..state import Surfaced, reached
from .look import make_active
from .needs import DocumentOperator
from .run_stages import StageOperator


class CreaseOperator(StageOperator):
    """Rebuilds the sheet with given creases, and the page from it."""

    role = SHEET

    def plan(self, known: Known) -> Plan:
        return plan(known, STAGES[STAGES.index("surface") :], creases=self.creases(reached(known.state, Surfaced)))

    def creases(self, state: Surfaced) -> list[Crease]:
        """The creases for the sheet, in pixels of the reference photo."""
        raise NotImplementedError


class ORIGAMI_OT_choose_crease(DocumentOperator, bpy.types.Operator):
    """Mark this crease with its number, on the sheet and on the page; again: no longer"""

    bl_idname = "origami.choose_crease"
    bl_label = "Choose Crease"
    bl_options = {"UNDO"}
    role = SHEET

    index: IntProperty(name="Crease", description="Which crease of the panel's list, counted from 0", min=0)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Choose it, or none."""
        group = self.document.collection.origami
        group.crease = -1 if group.crease == self.index else self.index
        redraw_views()
        return {"FINISHED"}


class ORIGAMI_OT_drop_crease(CreaseOperator, bpy.types.Operator):
    """Remove this crease and rebuild the sheet without it"""

    bl_idname = "origami.drop_crease"
    bl_label = "Drop Crease"
    label = "Drop Crease"

    index: IntProperty(name="Crease", description="Which crease of the panel's list, counted from 0", min=0)

    def creases(self, state: Surfaced) -> list[Crease]:
        """The existing creases except one."""
        # These come first, without erased ones; creases painted since then follow.
        known = list(read_creases(self.object).known)
        if self.index not in known:
            raise UsageError(f"Crease {self.index + 1} is no longer on the sheet: choose another one from the list.")
        there = creases_in_photo(state)
        del there[known.index(self.index)]
        return there


class ORIGAMI_OT_rebuild_sheet(CreaseOperator, bpy.types.Operator):
    """Rebuild the sheet with the creases as they are painted now, each a sharp straight fold"""

    bl_idname = "origami.rebuild_sheet"
    bl_label = "Rebuild with These Creases"
    label = "Rebuild Sheet"

    def creases(self, state: Surfaced) -> list[Crease]:
        """The existing creases."""
        return creases_in_photo(state)


class ORIGAMI_OT_paint_ridges(DocumentOperator, bpy.types.Operator):
    """Paint or erase creases as weights of the sheet's vertex group; then unwrap again, or rebuild the sheet"""

    bl_idname = "origami.paint_ridges"
    bl_label = "Paint Ridges"
    bl_options = {"REGISTER", "UNDO"}
    role = SHEET

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Go to Weight Paint with the group `ridge` active."""
        sheet_object = self.object
        try:
            make_active(context, sheet_object)
        except UsageError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        groups = sheet_object.vertex_groups
        # If the group was deleted, all creases count as erased.
        groups.active = groups.get(RIDGE_GROUP) or groups.new(name=RIDGE_GROUP)
        bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
        return {"FINISHED"}


def creases_in_photo(state: Surfaced) -> list[Crease]:
    """The ends of the sheet's creases in pixels of the reference photo, as stored in its file."""
    camera = state.sheet_reference
    ends = [camera.project(state.sheet.vertices[ridge[[0, -1]]]) for ridge in state.sheet.ridges]
    return [(float(a[0]), float(a[1]), float(b[0]), float(b[1])) for a, b in ends]


CLASSES = (ORIGAMI_OT_choose_crease, ORIGAMI_OT_drop_crease, ORIGAMI_OT_rebuild_sheet, ORIGAMI_OT_paint_ridges)
