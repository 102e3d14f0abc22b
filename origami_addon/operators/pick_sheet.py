"""Chooses another sheet by a click: one operator takes the click, another one finds the sheet.

There are two for the reason given in `draw_crease.py`.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

import bpy
import numpy as np
from bpy.props import FloatVectorProperty
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

from ...core.arrays import Array
from ...core.errors import OrigamiError, StepFailed, UsageError
from ...core.paper.sheets_in_view import sheet_under
from ...core.setting import declaration
from ..jobs import running
from ..plan import Known, Plan, plan_stage
from ..scene.chosen import active_document
from ..scene.declared import declared_property
from ..scene.document import Document
from ..scene.roles import OUTLINE
from ..scene.sheet_mesh import transform
from ..scene.show import find_camera
from ..settings import RunSettings
from ..state import Found
from .clicks import view_under_mouse
from .look import Restore, look_through, views_to_restore
from .needs import DocumentOperator
from .nested import start
from .run_stages import StageOperator
from .status import clear_status

_HINT = "Click on the sheet to take   ESC to cancel"
_picks = 0  # how many were started: a later one takes over from the one before
_before: Restore | None = None  # restores the views to their state before the first operator that still waits


class ORIGAMI_OT_pick_sheet(DocumentOperator, bpy.types.Operator):
    """Click on another sheet in the reference photo to take that one"""

    bl_idname = "origami.pick_sheet"
    bl_label = "Pick Sheet"
    alone = True
    role = OUTLINE

    # Do not reuse the place of the last time.
    place: FloatVectorProperty(
        name="Place",
        description="A place on the sheet, in pixels of the reference photo",
        size=2,
        options={"SKIP_SAVE"},
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Show the reference photo and wait for the click."""
        global _picks, _before
        if bpy.app.background or self.properties.is_property_set("place"):
            return self.execute(context)
        if context.area is None or context.area.type != "VIEW_3D":
            self.report({"ERROR"}, "The photo is shown in a 3D view: press Pick Sheet in the sidebar of one")
            return {"CANCELLED"}
        document = self.document
        try:
            self._edges = _edges_in_scene(document)
            camera_object = find_camera(document, document.reached(Found).reference)
        except OrigamiError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        _picks += 1
        self._number = _picks
        self._document, self._title, self._state_digest = document.name, document.title, document.state_digest()
        self._workspace = context.workspace.name
        _before = _before or views_to_restore(context)
        look_through(context, camera_object, past_objects=True)
        context.window.cursor_modal_set("EYEDROPPER")
        context.workspace.status_text_set(_HINT)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Take the click on a sheet; pass all other events on."""
        if self._number != _picks:  # the button was pressed again: the later operator owns cursor and status
            return {"CANCELLED"}
        if running.current() is not None or (event.type in ("ESC", "RIGHTMOUSE") and event.value == "PRESS"):
            return self._give_up(context)
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        view = view_under_mouse(context.window, event)
        if view is None:
            return {"PASS_THROUGH"}
        document = active_document(context)
        if document is None or (document.name, document.state_digest()) != (self._document, self._state_digest):
            self.report(
                {"ERROR"},
                f"{self._title} has changed since Pick Sheet was pressed, perhaps by Undo, or another document was "
                "chosen: press Pick Sheet again.",
            )
            return self._give_up(context)
        place = np.array([event.mouse_x - view.x, event.mouse_y - view.y], float)
        try:
            number = _other_sheet(document, [_in_view(edge, view) for edge in self._edges], place)
        except UsageError as error:
            self.report({"WARNING"}, str(error))
            return {"RUNNING_MODAL"}
        self.cancel(context)
        return self._take(number)

    def _give_up(self, context: bpy.types.Context) -> set[str]:
        """End, and restore the views."""
        restore = _before
        self.cancel(context)
        if restore is not None:
            restore()
        return {"CANCELLED"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Restore the cursor; Blender also calls this, for example when its window closes."""
        global _before
        if _before is not None:
            _before(transparency_alone=True)
        _before = None
        if context.window is not None:
            context.window.cursor_modal_restore()
        clear_status([self._workspace])

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Take the sheet at the given place."""
        document = self.document
        try:
            camera = document.reached(Found).reference
            outlines = [camera.project(edge) for edge in _edges(document)]
            number = _other_sheet(document, outlines, np.array(self.place))
        except OrigamiError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self._take(number)

    def _take(self, number: int) -> set[str]:
        """Find the sheet, without blocking the window if there is one."""
        return {"FINISHED"} if start(self, bpy.ops.origami.take_sheet, number=number) else {"CANCELLED"}


class ORIGAMI_OT_take_sheet(StageOperator, bpy.types.Operator):
    """Find the sheet with a given number"""

    bl_idname = "origami.take_sheet"
    bl_label = "Pick Sheet"  # the name of its undo step
    bl_options = {"INTERNAL"}
    label = "Pick Sheet"

    number: declared_property(declaration(RunSettings, "sheet"))

    @property
    def sheet(self) -> int:
        """The number of the sheet to take."""
        return self.number

    def plan(self, known: Known) -> Plan:
        """Only the sheet: the user checks its edge first."""
        return plan_stage(known, "find")


def _edges(document: Document) -> tuple[Array, ...]:
    """World points along the edge of each sheet in view, in the frame of the sparse model.

    Raises
    ------
    StepFailed
        If they are not known.
    """
    region = document.reached(Found).region
    if not region.in_view:
        raise StepFailed(
            "Origami does not know which sheets are in view, because the outline was drawn by hand: press Find Sheet, "
            "then Pick Sheet again."
        )
    return region.in_view


def _edges_in_scene(document: Document) -> list[Array]:
    frame = document.frame
    return [transform(frame, edge) for edge in _edges(document)]


def _in_view(edge: Array, view: bpy.types.Region) -> Array:
    """World points (K, 3) of the scene as pixels (K, 2) of a 3D view, NaN behind it."""
    places = [location_3d_to_region_2d(view, view.data, Vector(point)) for point in edge]
    return np.array([(np.nan, np.nan) if place is None else tuple(place) for place in places])


def _other_sheet(document: Document, outlines: Sequence[Array], place: Array) -> int:
    """The number of the sheet under a place.

    Raises
    ------
    UsageError
        If there is none, or it is the current one.
    """
    index = sheet_under(outlines, place)
    if index is None:
        raise UsageError("No sheet was found there: click elsewhere, or press ESC and draw the edge with Edit Outline.")
    if index + 1 == json.loads(document.collection.origami.find.settings)["sheet"]:
        raise UsageError("That sheet is already chosen: click on another one, or press ESC.")
    return index + 1


CLASSES = (ORIGAMI_OT_pick_sheet, ORIGAMI_OT_take_sheet)
