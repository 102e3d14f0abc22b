"""The list of folders that may become documents, in the dialog that asks which."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from ..scene.listed_photos import counted


class ORIGAMI_UL_folders(bpy.types.UIList):
    """The folders inside a folder, each with how many photos it holds"""

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
        """One folder."""
        row = layout.row()
        row.enabled = item.photos > 0
        row.prop(item, "use", text=Path(item.name).name)
        held = counted(range(item.photos)) if item.photos else "no photos"
        row.label(text=f"{held}, has a document" if item.known else held)
