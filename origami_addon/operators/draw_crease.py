"""Draws a crease: one operator takes two clicks on the sheet, another one rebuilds the sheet with the crease.

There are two because Blender frees an operator once for each time it was made modal: one that waits for clicks and then
follows a job would be freed twice.
"""

from __future__ import annotations

import bpy
import numpy as np
from bpy.props import FloatVectorProperty
from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d
from mathutils import Vector
from mathutils.geometry import barycentric_transform

from ...core.arrays import Array
from ...core.errors import StepFailed
from ..jobs import running
from ..plan import Crease
from ..scene.chosen import active_document
from ..scene.modes import in_edit_mode
from ..scene.roles import SHEET
from ..scene.shape_keys import shown_positions, unfolded_share
from ..scene.sheet_mesh import transform
from ..state import Surfaced
from .clicks import view_under_mouse
from .edit_creases import CreaseOperator, creases_in_photo
from .needs import DocumentOperator
from .nested import start
from .status import clear_status

_HINT = "Click where the crease starts, then where it ends   ESC to cancel"
_drawings = 0  # how many were started: a later one takes over from the one before


class _Ends:
    """Where the crease is."""

    # Do not reuse the ends of the last time.
    start: FloatVectorProperty(
        name="Start",
        description="Where the crease starts, in pixels of the reference photo",
        size=2,
        options={"SKIP_SAVE"},
    )
    end: FloatVectorProperty(
        name="End",
        description="Where the crease ends, in pixels of the reference photo",
        size=2,
        options={"SKIP_SAVE"},
    )


class ORIGAMI_OT_draw_crease(_Ends, DocumentOperator, bpy.types.Operator):
    """Draw a straight crease between two clicks on the sheet, and rebuild the sheet with it"""

    bl_idname = "origami.draw_crease"
    bl_label = "Draw Crease"
    alone = True
    role = SHEET

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Wait for the clicks."""
        global _drawings
        if bpy.app.background or self.properties.is_property_set("end"):
            return self.execute(context)
        if context.area is None or context.area.type != "VIEW_3D":
            self.report({"ERROR"}, "Creases are drawn on the sheet: press Draw Crease in the sidebar of a 3D view")
            return {"CANCELLED"}
        _drawings += 1
        self._number = _drawings
        document = self.document
        self._document, self._title, self._state_digest = document.name, document.title, document.state_digest()
        self._clicks: list[Array] = []
        self._workspace = context.workspace.name
        context.window.cursor_modal_set("KNIFE")
        context.workspace.status_text_set(_HINT)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Take the clicks on the sheet; pass all other events on."""
        if self._number != _drawings:  # the button was pressed again: the later operator owns cursor and status
            return {"CANCELLED"}
        if running.current() is not None or (event.type in ("ESC", "RIGHTMOUSE") and event.value == "PRESS"):
            self.cancel(context)
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        view = view_under_mouse(context.window, event)
        if view is None:
            return {"PASS_THROUGH"}
        try:
            hit = self._on_sheet(view, event)
        except StepFailed as error:
            self.cancel(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if hit is None:
            self.report({"WARNING"}, "That is beside the sheet: click on the sheet")
            return {"RUNNING_MODAL"}
        self._clicks.append(hit)
        if len(self._clicks) < 2:
            return {"RUNNING_MODAL"}
        self.start, self.end = self._clicks
        self.cancel(context)
        return self.execute(context)

    def cancel(self, context: bpy.types.Context) -> None:
        """Put down the knife; Blender also calls this, for example when its window closes."""
        if context.window is not None:
            context.window.cursor_modal_restore()
        clear_status([self._workspace])

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Rebuild the sheet, without blocking the window if there is one."""
        ends = {"start": self.start, "end": self.end}
        return {"FINISHED"} if start(self, bpy.ops.origami.add_crease, **ends) else {"CANCELLED"}

    def _on_sheet(self, view: bpy.types.Region, event: bpy.types.Event) -> Array | None:
        """The place on the sheet under the mouse, in pixels of the reference photo; None beside the sheet.

        Raises
        ------
        StepFailed
            If it is no longer the sheet on which the crease was started.
        """
        document = active_document(bpy.context)
        if document is None or (document.name, document.state_digest()) != (self._document, self._state_digest):
            raise StepFailed(
                f"{self._title} has changed since the crease was started, perhaps by Undo, or another document was "
                "chosen: press Draw Crease again."
            )
        sheet_object = document.object(SHEET)
        if sheet_object is None or not sheet_object.visible_get() or in_edit_mode(sheet_object):
            raise StepFailed(
                "The sheet cannot be clicked on, because it is hidden, deleted or in Edit Mode: show it in Object "
                "Mode, or run Build Surface, then press Draw Crease again."
            )
        place = (event.mouse_x - view.x, event.mouse_y - view.y)
        to_local = sheet_object.matrix_world.inverted_safe()
        origin = to_local @ region_2d_to_origin_3d(view, view.data, place)
        direction = (to_local.to_3x3() @ region_2d_to_vector_3d(view, view.data, place)).normalized()
        found, location, _, face = sheet_object.ray_cast(origin, Vector(direction))
        if not found:
            return None
        in_model = transform(np.linalg.inv(document.frame), _on_folded(sheet_object, location, face)[None])
        return document.reached(Surfaced).sheet_reference.project(in_model)[0]


def _on_folded(sheet_object: bpy.types.Object, location: Vector, face: int) -> Array:
    """Where a place on a face of the sheet as it is shown is on the folded sheet."""
    mesh = sheet_object.data
    if unfolded_share(sheet_object) == 0 or face >= len(mesh.polygons):
        return np.array(location)
    corners, shown = list(mesh.polygons[face].vertices)[:3], shown_positions(sheet_object)
    folded = [mesh.vertices[corner].co for corner in corners]
    return np.array(barycentric_transform(location, *(Vector(shown[corner]) for corner in corners), *folded))


class ORIGAMI_OT_add_crease(_Ends, CreaseOperator, bpy.types.Operator):
    """Rebuild the sheet with a straight crease whose ends are known"""

    bl_idname = "origami.add_crease"
    bl_label = "Add Crease"
    bl_options = {"INTERNAL"}
    label = "Draw Crease"

    def creases(self, state: Surfaced) -> list[Crease]:
        """The existing creases and the one drawn."""
        return [*creases_in_photo(state), (*self.start, *self.end)]


CLASSES = (ORIGAMI_OT_draw_crease, ORIGAMI_OT_add_crease)
