"""Operators that ask for a folder."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty


class AsksForFolder:
    """A mix-in for operators with a property ``directory``, for which the file browser asks."""

    filter_folder: BoolProperty(
        name="Folders", description="Show folders to choose from", default=True, options={"HIDDEN"}
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the folder."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}
