"""Thin operators: each reads the scene, runs a step and shows the result."""

from __future__ import annotations

from . import (
    clear_work,
    compare,
    control,
    documents,
    drag_frame,
    draw_crease,
    edit_creases,
    edit_outline,
    edit_page,
    export,
    look,
    other_light,
    photos,
    pick_sheet,
    queue,
    run_stages,
    show_as,
    unwrap_developable,
)

CLASSES = (
    *run_stages.CLASSES,
    *control.CLASSES,
    *photos.CLASSES,
    *documents.CLASSES,
    *queue.CLASSES,
    *look.CLASSES,
    *show_as.CLASSES,
    *other_light.CLASSES,
    *edit_outline.CLASSES,
    *pick_sheet.CLASSES,
    *edit_page.CLASSES,
    *drag_frame.CLASSES,
    *draw_crease.CLASSES,
    *edit_creases.CLASSES,
    *compare.CLASSES,
    *export.CLASSES,
    *unwrap_developable.CLASSES,
    *clear_work.CLASSES,
)
