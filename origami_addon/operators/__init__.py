"""Thin operators: each reads the scene, has a step done, and shows the result."""

from __future__ import annotations

from . import (
    clear_work,
    compare,
    control,
    draw_crease,
    export,
    look,
    mend_creases,
    mend_outline,
    mend_page,
    photos,
    pick_sheet,
    run_stages,
    unwrap_developable,
)

CLASSES = (
    *run_stages.CLASSES,
    *control.CLASSES,
    *photos.CLASSES,
    *look.CLASSES,
    *mend_outline.CLASSES,
    *pick_sheet.CLASSES,
    *mend_page.CLASSES,
    *draw_crease.CLASSES,
    *mend_creases.CLASSES,
    *compare.CLASSES,
    *export.CLASSES,
    *unwrap_developable.CLASSES,
    *clear_work.CLASSES,
)
