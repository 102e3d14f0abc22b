"""The tab "Origami" in the sidebars of the 3D view, image editor and UV editor: one big button and the steps below."""

from __future__ import annotations

import bpy

from .document_list import ORIGAMI_UL_documents
from .folder_list import ORIGAMI_UL_folders
from .main_panel import MainPanel, ORIGAMI_MT_presets
from .photo_list import ORIGAMI_UL_photos
from .step_panels import STEP_PANELS

_SPACES = ("VIEW_3D", "IMAGE_EDITOR")


def _panels_of(space: str) -> list[type]:
    """The panels for one kind of editor; Blender needs separate classes for each."""
    short = space.partition("_")[0].lower()
    place = {"bl_space_type": space, "bl_region_type": "UI", "bl_category": "Origami"}
    main = type(f"ORIGAMI_PT_{short}", (MainPanel, bpy.types.Panel), place)
    steps = [
        type(
            f"ORIGAMI_PT_{short}_{step.__name__.strip('_').lower()}",
            (step, bpy.types.Panel),
            place | {"bl_parent_id": main.__name__, "bl_order": order},
        )
        for order, step in enumerate(STEP_PANELS)
    ]
    return [main, *steps]


CLASSES = (
    ORIGAMI_UL_documents,
    ORIGAMI_UL_folders,
    ORIGAMI_UL_photos,
    ORIGAMI_MT_presets,
    *(panel for space in _SPACES for panel in _panels_of(space)),
)
