"""What operators need; if it is missing, the button is grey and says why."""

from __future__ import annotations

import bpy

from ..jobs import running
from ..scene.chosen import active_document
from ..scene.document import Document, find_document, some_are_linked
from ..scene.roles import OUTLINE, PAGE_FRAME, SHEET
from ..scene.sheet_materials import page_image

PICTURE = "picture of the page"
_NO_PAGE = "There is no page yet: rectify the photos first"
_LINKED = "The document is linked from another file: open that file to change it"
_MISSING = {
    "": "Add the photos of a sheet first",
    OUTLINE: "There is no outline yet: find the sheet first",
    SHEET: "There is no sheet yet: build its surface first",
    PAGE_FRAME: _NO_PAGE,
    PICTURE: _NO_PAGE,
}


class Operator:
    """A mix-in for operators, which say what is missing.

    Attributes
    ----------
    alone : bool
        Whether no job may be running: there is only one at a time.
    """

    alone = False

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether nothing is missing; otherwise the button says what."""
        at_work = cls.alone and running.current() is not None
        missing = "A job is running: wait for it, or press ESC" if at_work else cls.missing(context)
        if missing:
            cls.poll_message_set(missing)
        return not missing

    @classmethod
    def missing(cls, context: bpy.types.Context) -> str:
        """A sentence about what is missing; empty if nothing is."""
        return ""


class DocumentOperator(Operator):
    """A mix-in for operators on the document in the panels.

    Attributes
    ----------
    role : str
        Of the object on which they work, or `PICTURE`; empty if they only need a document.
    """

    role = ""
    _begun_on = ""

    @classmethod
    def missing(cls, context: bpy.types.Context) -> str:
        """The document, or the object on which they work."""
        document = active_document(context)
        if document is None and some_are_linked():
            return _LINKED
        if document is not None and cls.role == PICTURE:
            there = page_image(document) is not None
        else:
            there = document is not None and (not cls.role or document.object(cls.role) is not None)
        return "" if there else _MISSING[cls.role]

    @property
    def document(self) -> Document:
        """The document on which the operator was started, whatever the panels show by now.

        Raises
        ------
        StepFailed
            If it is gone.
        """
        if self._begun_on:
            return find_document(self._begun_on)
        document = active_document(bpy.context)
        assert document is not None  # `poll` has checked it
        return document

    @property
    def object(self) -> bpy.types.Object:
        """The object that the operator works on."""
        return self.document.object(self.role)
