"""What operators need of the document that the panels show; where it is missing, the button is grey and says why."""

from __future__ import annotations

import bpy

from ..jobs import running
from ..scene.document import Document, document_of
from ..scene.show import OUTLINE, PAGE_FRAME, SHEET, page_image

_NO_PAGE = "There is no page yet: rectify the photos first"
_MISSING = {
    OUTLINE: "There is no outline yet: find the sheet first",
    SHEET: "There is no sheet yet: find its ridges first",
    PAGE_FRAME: _NO_PAGE,
}


def active_document(context: bpy.types.Context) -> Document | None:
    """The document that the panels show: that of the active object, or the one chosen last."""
    chosen = document_of(context.scene.origami.document)
    return document_of(context.active_object) or chosen


def no_job(operator: type) -> bool:
    """Whether no job is running: there is one at a time."""
    return _told(operator, running.current() is None, "A job is running: wait for it, or press ESC")


def has_document(operator: type, context: bpy.types.Context) -> bool:
    """Whether there is a document."""
    return _told(operator, active_document(context) is not None, "Add the photos of a sheet first")


def has(operator: type, context: bpy.types.Context, role: str) -> bool:
    """Whether the document has an object of a role."""
    document = active_document(context)
    return _told(operator, document is not None and document.object(role) is not None, _MISSING[role])


def has_page(operator: type, context: bpy.types.Context) -> bool:
    """Whether the document has the picture of a page."""
    document = active_document(context)
    return _told(operator, document is not None and page_image(document) is not None, _NO_PAGE)


def _told(operator: type, there: bool, otherwise: str) -> bool:
    if not there:
        operator.poll_message_set(otherwise)
    return there
