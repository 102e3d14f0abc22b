"""The panels below the main one: a panel for each step, and those for the photos, the quality and the export."""

from __future__ import annotations

import json
from collections.abc import Container
from typing import Any

import bpy

from ...core.flat.flatten import FlattenSettings
from ...core.placing.result import SfmSettings
from ...core.surface.surface_settings import SurfaceSettings
from ..operators.photos import lost_photos
from ..scene.chosen import active_document
from ..scene.declared import shown_settings
from ..scene.document import Document
from ..scene.settings_group import OTHER_PAPER
from ..settings import ImageSettings, PageSettings
from ..stages import STAGES, WITHIN, about
from .crease_list import listed_creases
from .menus import add_photos_button
from .photo_list import draw_selected
from .quality import confidence, measures
from .sentences import draw_sentence
from .stage_text import state_of

_VERDICT_ICONS = {"good": "CHECKMARK", "fair": "QUESTION", "poor": "ERROR"}
_PHOTO_ROWS = 6  # of the list of photos: as many as most documents have


class _Step:
    """One step: its settings, its button and its result in one line; shown once there is a document."""

    bl_options = {"DEFAULT_CLOSED"}
    stages: tuple[str, ...] = ()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return active_document(context) is not None

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        document = active_document(context)
        if document is not None and self.stages:
            icons = [state_of(document, stage).icon for stage in self.stages]
            self.layout.label(text="", icon=next((icon for icon in icons if icon != "CHECKMARK"), icons[-1]))

    def draw(self, context: bpy.types.Context) -> None:
        document = active_document(context)
        assert document is not None
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        self.draw_step(context, layout, document, document.collection.origami.settings)
        for stage in self.stages:
            _draw_result(layout, document, stage, named=len(self.stages) > 1)

    def draw_step(self, context: bpy.types.Context, layout: Any, document: Document, settings: Any) -> None:
        raise NotImplementedError


class _Photos(_Step):
    bl_label = "Photos"

    def draw_step(self, context: bpy.types.Context, layout: Any, document: Document, settings: Any) -> None:
        group = document.collection.origami
        row = layout.row()
        row.template_list("ORIGAMI_UL_photos", "", group, "photos", group, "active_photo", rows=_PHOTO_ROWS)
        column = row.column(align=True)
        add_photos_button(column, text="", icon="ADD", new=False)
        column.operator("origami.remove_photo", text="", icon="REMOVE")
        column.operator("origami.look_through", text="", icon="OUTLINER_OB_CAMERA")
        draw_selected(layout, group)
        if lost := lost_photos(document):
            layout.operator("origami.find_photos", text=f"Find Photos: {lost} Are Missing", icon="ERROR")


class _Placing(_Step):
    bl_label = about("place").title
    stages = ("place",)

    def draw_step(self, context: bpy.types.Context, layout: Any, document: Document, settings: Any) -> None:
        column = layout.column()
        _draw_settings(column, settings.sfm, SfmSettings)
        column.prop(settings, "colmap_model")
        _stage_button(layout, "place")
        layout.prop(context.scene.origami, "show_errors")


class _Sheet(_Step):
    bl_label = about("find").title
    stages = ("find",)

    def draw_step(self, context: bpy.types.Context, layout: Any, document: Document, settings: Any) -> None:
        layout.prop_search(settings, "reference", document.collection.origami, "photos", text="Reference")
        row = layout.row(align=True)
        row.prop(settings, "sheet")
        row.operator("origami.pick_sheet", text="", icon="EYEDROPPER")
        _stage_button(layout, "find")
        layout.operator("origami.edit_outline", icon="EDITMODE_HLT")


class _Surface(_Step):
    bl_label = about("surface").title
    stages = ("surface",)

    def draw_step(self, context: bpy.types.Context, layout: Any, document: Document, settings: Any) -> None:
        _draw_settings(layout.column(), settings.surface, SurfaceSettings)
        _stage_button(layout, "surface")
        layout.prop(context.scene.origami, "show_creases")
        row = layout.row(align=True)
        row.operator("origami.draw_crease", icon="GREASEPENCIL")
        row.operator("origami.paint_ridges", icon="BRUSH_DATA")
        layout.operator("origami.rebuild_sheet", icon="FILE_REFRESH")
        column = layout.column(align=True)
        for crease in listed_creases(document):
            row, text = column.row(align=True), f"Crease {crease.number + 1}: {crease.text}"
            if not crease.there:
                row.label(text=text, icon="MOD_SIMPLEDEFORM")
                continue
            chosen = crease.number == document.collection.origami.crease
            choose = row.operator("origami.choose_crease", text=text, icon="MOD_SIMPLEDEFORM", depress=chosen)
            choose.index = crease.number
            row.operator("origami.drop_crease", text="", icon="X").index = crease.number


class _Unwrap(_Step):
    bl_label = about("unwrap").title
    stages = ("unwrap",)

    def draw_step(self, context: bpy.types.Context, layout: Any, document: Document, settings: Any) -> None:
        straightened = {"ridge_rows": "Creases", "boundary_rows": "Sides"}
        _draw_settings(layout, settings.flatten, FlattenSettings, but=straightened)
        column = layout.column(heading="Straighten")
        for name, text in straightened.items():
            column.prop(settings.flatten, name, text=text)
        _stage_button(layout, "unwrap")
        row = layout.row(align=True)
        row.operator("origami.show_sheet", text="Show Picture").by = "TEXTURE"
        row.operator("origami.show_sheet", text="Show Stretch").by = "VERTEX"
        layout.operator("origami.compare_methods", icon="UV_DATA")


class _Page(_Step):
    bl_label = about("page").title
    stages = ("lay_out", "page")

    def draw_step(self, context: bpy.types.Context, layout: Any, document: Document, settings: Any) -> None:
        column = layout.column()
        column.prop(settings.page, "paper")
        if settings.page.paper == OTHER_PAPER:
            column.prop(settings.page, "width")
            column.prop(settings.page, "height")
        _draw_settings(column, settings.page, PageSettings)
        _draw_settings(column, settings.image, ImageSettings)
        _stage_button(layout, "page")
        row = layout.row(align=True)
        row.operator("origami.turn_page", text="Turn Left", icon="LOOP_BACK").clockwise = False
        row.operator("origami.turn_page", text="Turn Right", icon="LOOP_FORWARDS").clockwise = True
        row = layout.row(align=True)
        row.operator("origami.edit_page_frame")
        row.operator("origami.apply_page_frame")
        layout.operator("origami.add_other_light", icon="LIGHT_SUN")


class _Quality(_Step):
    bl_label = "Quality"

    def draw_step(self, context: bpy.types.Context, layout: Any, document: Document, settings: Any) -> None:
        group = document.collection.origami
        figures: dict[str, Any] = {}
        for stage in STAGES:
            if getattr(group, stage).done:
                figures |= json.loads(getattr(group, stage).figures)
        found = measures(figures)
        if not found:
            layout.label(text="Nothing has been measured yet", icon="RADIOBUT_OFF")
            return
        layout.label(text=f"Confidence: {confidence(found)}", icon=_VERDICT_ICONS[confidence(found)])
        column = layout.column(align=True)
        for measure in found:
            draw_sentence(column, measure.text, _VERDICT_ICONS[measure.verdict])
        if figures.get(WITHIN) is not None:
            row = layout.row(align=True)
            row.operator("origami.show_sheet", text="Show Picture").by = "TEXTURE"
            row.operator("origami.show_sheet", text="Show Accuracy").by = "BOUND"


class _Export(_Step):
    bl_label = "Export"

    def draw_step(self, context: bpy.types.Context, layout: Any, document: Document, settings: Any) -> None:
        layout.operator("origami.export", icon="EXPORT")
        layout.operator("origami.export_settings", icon="PREFERENCES")


STEP_PANELS = (_Photos, _Placing, _Sheet, _Surface, _Unwrap, _Page, _Quality, _Export)


def _draw_settings(layout: Any, group: Any, settings: type, but: Container[str] = ()) -> None:
    """The active settings of a group, except ``but``, which are drawn elsewhere."""
    for each in shown_settings(settings):
        counts = each.only_with is None or getattr(group, each.only_with[0]) == each.only_with[1]
        if each.in_panel and counts and each.name not in but:
            layout.prop(group, each.name)


def _stage_button(layout: Any, stage: str) -> None:
    layout.operator("origami.run_stage", text=about(stage).verb, icon="PLAY").stage = stage


def _draw_result(layout: Any, document: Document, stage: str, *, named: bool) -> None:
    state = state_of(document, stage)
    layout.label(text=f"{about(stage).verb}: {state.text}" if named else state.text, icon=state.icon)
    figures = json.loads(getattr(document.collection.origami, stage).figures)
    for line in about(stage).summary(figures) if figures else ():
        draw_sentence(layout, line, "BLANK1")
    for warning in json.loads(getattr(document.collection.origami, stage).warnings):
        draw_sentence(layout, warning, "ERROR")
