"""Shows a document in one of three ways, and turns from one to the other: its photo, its sheet in space, its page."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty

from ...core.errors import OrigamiError
from ..scene.camera_object import draw_photo
from ..scene.document import Document, document_of
from ..scene.roles import CAMERA, SHEET
from ..scene.show import find_camera
from ..scene.view import Way, show_way
from ..state import Found
from .look import Restore, look_through, make_active, views_to_restore
from .needs import PICTURE, DocumentOperator

WAYS: tuple[tuple[Way, str, str], ...] = (
    ("PHOTO", "Photo", "The reference photo, through its camera, without the sheet before it"),
    ("SHEET", "Sheet", "The sheet in space, from the side"),
    ("PAGE", "Page", "The flat page, straight from above"),
)
_before: Restore | None = None  # restores the scene's camera and the views to their state before the photo


class ORIGAMI_OT_show_as(DocumentOperator, bpy.types.Operator):
    """Show the photo, the sheet in space or the flat page in the 3D views, filling them"""

    bl_idname = "origami.show_as"
    bl_label = "Show As"
    bl_options = {"REGISTER", "UNDO"}
    role = PICTURE

    way: EnumProperty(name="As", description="What to show", items=WAYS)

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        """That of the way."""
        return next(text for way, _, text in WAYS if way == properties.way)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Turn the window's 3D views there; an open image editor gets the page."""
        global _before
        document = self.document
        if self.way != "PHOTO":
            shown = document_of(context.scene.camera)
            for each in () if shown is None else shown.objects(CAMERA):
                draw_photo(each, "BACK")
            if _before is not None and shown is not None:
                _before()
            _before = None
            return self._show(context, document)
        try:
            camera_object = find_camera(document, document.reached(Found).reference)
        except OrigamiError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        _before = _before or views_to_restore(context)
        look_through(context, camera_object)
        draw_photo(camera_object, "FRONT")  # transparent objects would stay so when the user turns the view
        return {"FINISHED"}

    def _show(self, context: bpy.types.Context, document: Document) -> set[str]:
        sheet_object, screen = document.object(SHEET), context.screen
        editors = screen is not None and any(area.type == "IMAGE_EDITOR" for area in screen.areas)
        shown = sheet_object is not None and sheet_object.visible_get()
        if self.way == "PAGE" and editors and shown and sheet_object != context.active_object:
            make_active(context, sheet_object)  # UV editors show its map
        if screen is None or not show_way(document, self.way, screen):
            self.report({"INFO"}, "Open a 3D view to see it there")
        return {"FINISHED"}


def forget_views() -> None:
    """Forget the views before the photo, because another file is opened."""
    global _before
    _before = None


CLASSES = (ORIGAMI_OT_show_as,)
