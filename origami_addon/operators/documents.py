"""The buttons beside the list of documents: a copy of one, or its removal."""

from __future__ import annotations

import bpy

from ..jobs import running
from ..jobs.queue import queue
from ..scene.chosen import active_document, choose
from ..scene.document import documents, remove_document
from ..scene.document_acts import duplicate_document
from ..scene.modes import whole_step
from .needs import DocumentOperator


class ORIGAMI_OT_duplicate_document(DocumentOperator, bpy.types.Operator):
    """Copy the document with its photos, settings and results, to try something else with the copy"""

    bl_idname = "origami.duplicate_document"
    bl_label = "Duplicate Document"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Copy it, and choose the copy."""
        with whole_step(context, self.bl_label):
            choose(context, duplicate_document(self.document))
        return {"FINISHED"}


class ORIGAMI_OT_delete_document(DocumentOperator, bpy.types.Operator):
    """Delete the document and everything that was made for it; the photos' files and your own objects stay"""

    bl_idname = "origami.delete_document"
    bl_label = "Delete Document"

    @classmethod
    def missing(cls, context: bpy.types.Context) -> str:
        """A document on which no job works."""
        document, now = active_document(context), running.current()
        if document is not None and now is not None and now.document == document.name:
            return "A job works on this document: wait for it, or press ESC"
        return super().missing(context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask first."""
        return context.window_manager.invoke_confirm(
            self, event, title=f"Delete {self.document.title}?", message="Ctrl-Z brings it back", confirm_text="Delete"
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Delete it, and choose the next one of the list."""
        document = self.document
        name, title = document.name, document.title
        with whole_step(context, self.bl_label):
            names = [each.name for each in documents()]
            place = names.index(name)
            remove_document(name)
            queue.leave(name)
            left = documents()
            if left:
                choose(context, left[min(place, len(left) - 1)])
        self.report({"INFO"}, f"{title} is deleted")
        return {"FINISHED"}


CLASSES = (ORIGAMI_OT_duplicate_document, ORIGAMI_OT_delete_document)
