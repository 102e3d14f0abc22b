"""The main panel: one big button, the list of documents, and what its document shows."""

from __future__ import annotations

from typing import Any

import bpy

from ..jobs import running
from ..jobs.queue import queue
from ..operators.show_as import WAYS
from ..presets import PRESETS
from ..scene.chosen import active_document
from ..scene.document import Document, documents
from ..scene.document_copies import part_copies_soon
from ..scene.roles import SHEET
from ..scene.shape_keys import unfold_slider
from ..scene.sheet_materials import page_image
from ..scene.view import shown_way
from .document_list import draw_time_left, waiting
from .menus import add_photos_button
from .sentences import draw_sentence

_BIG = 1.6  # height of the button that most users press, in usual ones


class MainPanel:
    """The button, the documents and the failure; Blender gets a class for each kind of editor from `panels.py`."""

    bl_label = "Origami"

    def draw(self, context: bpy.types.Context) -> None:
        part_copies_soon()  # Blender does not report a copied scene before it is changed
        layout = self.layout
        now, document = running.current(), active_document(context)
        if now is not None:
            _draw_running(layout, now)
        elif document is not None:
            big = layout.column()
            big.scale_y = _BIG
            big.operator("origami.rectify", icon="PLAY")
        if documents():
            _draw_documents(layout, context.scene.origami)
        elif now is None:
            _draw_start(layout)
        if document is None or (now is not None and now.document == document.name):
            return
        _draw_ways(layout, context, document)
        sheet_object = document.object(SHEET)
        slider = None if sheet_object is None else unfold_slider(sheet_object)
        if slider is not None:
            layout.prop(slider, "value", text="Unfold", slider=True)
        failure = running.failure_of(document.name)
        if failure is not None:
            draw_sentence(layout, failure.sentence, "CANCEL")
            for warning in failure.warnings:
                draw_sentence(layout, warning, "ERROR")


def _draw_start(layout: Any) -> None:
    """What to do first."""
    big = layout.column()
    big.scale_y = _BIG
    add_photos_button(big, text="Add Photos of a Sheet", icon="FILE_IMAGE", new=True)
    draw_sentence(layout, "5 to 10 photos of one sheet from several sides, each of the whole sheet", "INFO")
    layout.operator("origami.add_folders", icon="NEWFOLDER")
    draw_sentence(layout, "Several sheets: a folder with the photos of each", "INFO")


def _draw_running(layout: Any, now: running.Running) -> None:
    layout.progress(factor=now.fraction, text=f"{now.label}: {100 * now.fraction:.0f} %")
    layout.label(text=now.text)
    draw_time_left(layout, now)
    row = layout.row(align=True)
    row.operator("origami.stop", icon="PAUSE")
    row.operator("origami.cancel", icon="X")


def _draw_documents(layout: Any, shown: Any) -> None:
    """The list of documents, and what can be done with them."""
    row = layout.row()
    row.template_list("ORIGAMI_UL_documents", "", bpy.data, "collections", shown, "place", rows=4)
    column = row.column(align=True)
    add_photos_button(column, text="", icon="ADD", new=True)
    column.operator("origami.add_folders", text="", icon="NEWFOLDER")
    column.operator("origami.duplicate_document", text="", icon="DUPLICATE")
    column.operator("origami.delete_document", text="", icon="TRASH")
    column.menu("ORIGAMI_MT_presets", text="", icon="PRESET")
    if queue.paused and (count := waiting()):
        layout.operator("origami.resume_queue", text=f"Resume: {count} Waiting", icon="PLAY")
    elif len(documents()) > 1:
        layout.operator("origami.rectify_all", icon="PLAY")


def _draw_ways(layout: Any, context: bpy.types.Context, document: Document) -> None:
    """Photo, sheet or page, once there is a page; in a 3D view, the one that it shows is pressed."""
    if page_image(document) is None:
        return
    space = context.space_data
    shown = shown_way(document, context.scene, space) if space.type == "VIEW_3D" else None
    row = layout.row(align=True)
    for way, name, _ in WAYS:
        row.operator("origami.show_as", text=name, depress=way == shown).way = way


class ORIGAMI_MT_presets(bpy.types.Menu):
    """Settings for a kind of document"""

    bl_label = "Settings For"

    def draw(self, context: bpy.types.Context) -> None:
        """One entry for each kind."""
        for name, preset in PRESETS.items():
            self.layout.operator("origami.apply_preset", text=preset.label).preset = name
