"""The list of all documents: which one the tab shows, their titles, and how far each is."""

from __future__ import annotations

from typing import Any

import bpy

from ..jobs import running
from ..jobs.queue import queue, seconds_left
from ..scene.document import Document, document_of, documents
from ..stages import STAGES

_TITLE_SHARE = 0.6  # of a line's width, where it says more than the title


class ORIGAMI_UL_documents(bpy.types.UIList):
    """The documents of the file, each with what it waits for"""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: Any,
        data: Any,
        item: Any,
        icon: int,
        active_data: Any,
        active_property: str,
    ) -> None:
        """One document."""
        document = document_of(item)
        if document is None:
            return
        shown, text = progress_of(document)
        row = layout.split(factor=_TITLE_SHARE, align=True) if text else layout.row(align=True)
        row.prop(item.origami, "title", text="", emboss=False, icon=shown)
        row = row.row(align=True)
        if document.scene != context.scene:
            row.label(text="in no scene" if document.scene is None else f"in {document.scene.name}")
        if text:
            row.label(text=text)
        if document.name in queue.waiting:
            row.operator("origami.leave_queue", text="", icon="X", emboss=False).document = document.name

    def filter_items(self, context: bpy.types.Context, data: Any, name: str) -> tuple[list[int], list[int]]:
        """Only documents among the file's collections, and those whose title has the text that the user looks for."""
        wanted = self.filter_name.lower()
        shown = [document_of(each) is not None and wanted in each.name.lower() for each in getattr(data, name)]
        return [self.bitflag_filter_item if each else 0 for each in shown], []


def progress_of(document: Document) -> tuple[str, str]:
    """How far a document is: Blender's name of an icon, and a word or two."""
    now = running.current()
    if now is not None and now.document == document.name:
        return "PLAY", f"{100 * now.fraction:.0f} %"
    if document.name in queue.waiting:
        return "TIME", "waiting"
    if running.failure_of(document.name) is not None:
        return "ERROR", "failed"
    done = getattr(document.collection.origami, STAGES[-1]).done
    return ("CHECKMARK" if done else "RADIOBUT_OFF"), ""


def waiting() -> int:
    """How many documents wait; one that the user has deleted may come back by Undo, and does not count until then."""
    return sum(document.name in queue.waiting for document in documents())


def draw_time_left(layout: Any, now: running.Running) -> None:
    """How long the running job and the documents that wait will take, as far as that is known."""
    left = seconds_left(now)
    if left is not None:
        layout.label(text=f"{duration(left)} left".capitalize(), icon="TIME")
    if count := waiting():
        more = queue.seconds_left(now, count)
        then = f"Then {count} more" if count > 1 else "Then one more"
        layout.label(text=then if more is None else f"{then}: {duration(more)}", icon="BLANK1")


def duration(seconds: float) -> str:
    """A time to wait, as a person says it."""
    minutes = round(seconds / 60)
    if minutes < 1:
        return "less than a minute"
    hours, minutes = divmod(minutes, 60)
    return f"about {hours} h {minutes} min" if hours else f"about {minutes} min"
