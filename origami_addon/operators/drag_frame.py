"""Drags the page's frame: its corners and sides are handles in the 3D views, and Enter cuts the page there.

The frame is an ordinary mesh, which the handles move: each drag is an undo step, and **Apply Frame** also works later.
Cutting is a job, so another operator does it, for the reason given in `draw_crease.py`.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d, region_2d_to_origin_3d, region_2d_to_vector_3d
from mathutils import Vector

from ...core.arrays import Array
from ...core.errors import OrigamiError, StepFailed
from ...core.page.dragged_frame import cut_off, drag_handle, handles_of
from ...core.sheet import FlatMap
from ..jobs import running
from ..scene.document import Document, find_document
from ..scene.edits import own_changes
from ..scene.modes import in_edit_mode
from ..scene.page_object import corners_moved, framed_corners, move_corners, page_unit
from ..scene.roles import PAGE_FRAME
from ..scene.view import redraw_views
from ..state import LaidOut
from .clicks import view_under_mouse
from .look import make_active
from .needs import DocumentOperator
from .nested import start
from .status import clear_status

_HINT = "Drag the corners and sides   Enter: cut the page there   ESC: put them back"
_NEAR = 14.0  # pixels of an unscaled interface between mouse and handle
_FLAT_VIEW = 1e-3  # sine of the angle between a view and the page below which the mouse has no place on the page
_DIGITS = 4  # of lengths: no side is shown as -0.0
_drags = 0  # how many were started: a later one takes over from the one before


@dataclass
class Dragged:
    """The frame with handles.

    Attributes
    ----------
    document : str
        The name of its document.
    flat : FlatMap
        The page as it is cut now.
    handle : int or None
        The one under the mouse, or held by it.
    """

    document: str
    flat: FlatMap
    handle: int | None = None


_dragged: Dragged | None = None


def dragged() -> tuple[Dragged, bpy.types.Object] | None:
    """The frame with handles and its object, as long as that can be seen and moved; None if there is none."""
    if _dragged is None:
        return None
    try:
        return _dragged, _frame(find_document(_dragged.document))
    except StepFailed:
        return None


def handle_places(frame_object: bpy.types.Object, flat: FlatMap) -> list[Vector]:
    """Where the frame's handles are in the world, in the order of `handles_of`.

    Raises
    ------
    StepFailed
        If a corner was deleted.
    """
    places = handles_of(framed_corners(frame_object, flat)) * page_unit(flat)
    return [frame_object.matrix_world @ Vector((u, -v, 0)) for u, v in places]


def side_texts(frame_object: bpy.types.Object, flat: FlatMap) -> list[str]:
    """How far each side is from where the page ends now, outwards: top, right, bottom, left."""
    lengths = cut_off(framed_corners(frame_object, flat), flat.width, flat.height)
    return [_length_text(flat, round(-each, _DIGITS) + 0.0, "+") for each in lengths]


def _length_text(flat: FlatMap, length: float, sign: str = "") -> str:
    return f"{length:{sign}.1f} mm" if flat.unit == "mm" else f"{100 * length:{sign}.1f} %"


class ORIGAMI_OT_edit_page_frame(DocumentOperator, bpy.types.Operator):
    """Drag the page's corners and sides to where the page is to end; Enter cuts and straightens it to them"""

    bl_idname = "origami.edit_page_frame"
    bl_label = "Edit Frame"
    role = PAGE_FRAME

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Without a window there is nothing to drag."""
        self.report({"ERROR"}, "The frame is dragged in a 3D view: press Edit Frame in the sidebar of one")
        return {"CANCELLED"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Look at the page from above and show the handles."""
        global _drags, _dragged
        if bpy.app.background or context.area is None or context.area.type != "VIEW_3D":
            return self.execute(context)
        document = self.document
        try:
            if bpy.ops.origami.show_as.poll():
                bpy.ops.origami.show_as(way="PAGE")
            make_active(context, self.object)
            flat = document.reached(LaidOut).flat
            self._before = framed_corners(_frame(document), flat)
        except OrigamiError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        _drags += 1
        self._number = _drags
        self._title, self._state_digest = document.title, document.state_digest()
        self._held: Array | None = None  # the corners when the mouse took the handle
        self._workspace = context.workspace.name
        _dragged = Dragged(document.name, flat)
        self._tell(context)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Drag the handle under the mouse; pass all other events on."""
        if self._number != _drags or _dragged is None:  # the button was pressed again, or the file is another one
            return {"CANCELLED"}
        now = running.current()
        if now is not None and now.document == _dragged.document:
            self.cancel(context)
            return {"CANCELLED"}
        if event.type == "TIMER":
            return {"PASS_THROUGH"}
        try:
            return self._handle(context, event, _dragged)
        except OrigamiError as error:
            self.cancel(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Take the handles away; Blender also calls this, for example when its window closes."""
        global _dragged
        if self._number == _drags:
            _dragged = None
        clear_status([self._workspace])
        redraw_views()

    def _handle(self, context: bpy.types.Context, event: bpy.types.Event, shown: Dragged) -> set[str]:
        if event.type in ("ESC", "RIGHTMOUSE") and event.value == "PRESS":
            return self._put_back(context, shown)
        if event.type in ("RET", "NUMPAD_ENTER") and event.value == "PRESS" and self._held is None:
            return self._cut(context, shown)
        if event.type == "MOUSEMOVE":
            return self._move(context, event, shown)
        if event.type != "LEFTMOUSE":
            return {"PASS_THROUGH"} if self._held is None else {"RUNNING_MODAL"}
        if event.value == "RELEASE" and self._held is not None:
            self._let_go(context, shown)
            return {"RUNNING_MODAL"}
        view = view_under_mouse(context.window, event)
        if event.value != "PRESS" or view is None:
            return {"PASS_THROUGH"}
        frame_object = self._checked(shown)
        shown.handle = _handle_under(frame_object, shown.flat, view, event)
        if shown.handle is None:
            return {"PASS_THROUGH"}
        self._held = framed_corners(frame_object, shown.flat)
        return {"RUNNING_MODAL"}

    def _move(self, context: bpy.types.Context, event: bpy.types.Event, shown: Dragged) -> set[str]:
        """Move the handle that is held to the mouse, or mark the one under it."""
        view = view_under_mouse(context.window, event)
        if self._held is None:
            found = dragged()
            if found is None:  # the user has gone to Edit Mode, has hidden or deleted it
                self.cancel(context)
                return {"CANCELLED"}
            before = shown.handle
            shown.handle = None if view is None else _handle_under(found[1], shown.flat, view, event)
            if shown.handle != before:
                redraw_views()
            return {"PASS_THROUGH"}
        assert shown.handle is not None
        frame_object = _frame(find_document(shown.document))
        place = None if view is None else _on_page(frame_object, shown.flat, view, event)
        if place is not None:
            with own_changes():  # noted as the user's when the handle is let go
                move_corners(frame_object, shown.flat, drag_handle(self._held, shown.handle, place))
            self._tell(context)
        return {"RUNNING_MODAL"}

    def _let_go(self, context: bpy.types.Context, shown: Dragged) -> None:
        frame_object = _frame(find_document(shown.document))
        taken, self._held = self._held, None
        if taken is not None and not np.array_equal(framed_corners(frame_object, shown.flat), taken):
            frame_object.data.update_tag()
            context.view_layer.update()
            bpy.ops.ed.undo_push(message="Move Corner" if (shown.handle or 0) < len(self._before) else "Move Side")

    def _put_back(self, context: bpy.types.Context, shown: Dragged) -> set[str]:
        """Put the handle that is held back, or end and put all back."""
        frame_object = self._checked(shown)
        to = self._before if self._held is None else self._held
        moved = not np.array_equal(framed_corners(frame_object, shown.flat), to)
        if moved:
            move_corners(frame_object, shown.flat, to)
            context.view_layer.update()
        if self._held is not None:
            self._held = None
            self._tell(context)
            return {"RUNNING_MODAL"}
        if moved:
            bpy.ops.ed.undo_push(message="Put Frame Back")
        self.cancel(context)
        return {"CANCELLED"}

    def _cut(self, context: bpy.types.Context, shown: Dragged) -> set[str]:
        """Cut the page; if that cannot begin, the handles stay."""
        if not corners_moved(self._checked(shown), shown.flat):
            self.report({"INFO"}, "The frame is where the page ends: nothing is cut")
        elif not start(self, bpy.ops.origami.apply_page_frame):
            return {"RUNNING_MODAL"}
        self.cancel(context)
        return {"FINISHED"}

    def _checked(self, shown: Dragged) -> bpy.types.Object:
        """The frame's object; raises StepFailed if its page is not the one with which the operator was started."""
        document = find_document(shown.document)
        if document.state_digest() != self._state_digest:
            raise StepFailed(
                f"{self._title} has changed since Edit Frame was pressed, perhaps by Undo: press Edit Frame again."
            )
        return _frame(document)

    def _tell(self, context: bpy.types.Context) -> None:
        """Show the size that the page will have, and what the keys do."""
        assert _dragged is not None
        flat = _dragged.flat
        corners = framed_corners(_frame(find_document(_dragged.document)), flat)
        top, right, bottom, left = cut_off(corners, flat.width, flat.height)
        size = f"{_length_text(flat, flat.width - left - right)} x {_length_text(flat, flat.height - top - bottom)}"
        context.workspace.status_text_set(f"Page: {size}   {_HINT}")
        redraw_views()


def _frame(document: Document) -> bpy.types.Object:
    """A document's frame, as long as it can be dragged; raises StepFailed otherwise."""
    frame_object = document.object(PAGE_FRAME)
    if frame_object is None or not frame_object.visible_get() or in_edit_mode(frame_object):
        raise StepFailed(
            "The frame cannot be dragged, because it is hidden, deleted or in Edit Mode: show it in Object Mode, or "
            "run Make Page, then press Edit Frame again."
        )
    return frame_object


def _handle_under(
    frame_object: bpy.types.Object, flat: FlatMap, view: bpy.types.Region, event: bpy.types.Event
) -> int | None:
    """The handle nearest to the mouse, a corner rather than a side."""
    mouse = Vector((event.mouse_x - view.x, event.mouse_y - view.y))
    near = _NEAR * bpy.context.preferences.system.ui_scale
    found = None
    for number, place in enumerate(handle_places(frame_object, flat)):
        shown = location_3d_to_region_2d(view, view.data, place)
        if shown is not None and (shown - mouse).length < near:
            found, near = number, (shown - mouse).length
    return found


def _on_page(
    frame_object: bpy.types.Object, flat: FlatMap, view: bpy.types.Region, event: bpy.types.Event
) -> Array | None:
    """The place on the page (2,) under the mouse; None where the view looks along the page."""
    mouse = (event.mouse_x - view.x, event.mouse_y - view.y)
    to_local = frame_object.matrix_world.inverted_safe()
    origin = to_local @ region_2d_to_origin_3d(view, view.data, mouse)
    direction = (to_local.to_3x3() @ region_2d_to_vector_3d(view, view.data, mouse)).normalized()
    if abs(direction.z) < _FLAT_VIEW:
        return None
    place = origin - direction * (origin.z / direction.z)
    return np.array([place.x, -place.y]) / page_unit(flat)


CLASSES = (ORIGAMI_OT_edit_page_frame,)
