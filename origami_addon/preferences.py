"""The add-on's page in Blender's preferences: whether anything is missing, and what is kept on disk.

It only needs Blender, and appears even if nothing else of the add-on can be loaded.
"""

from __future__ import annotations

import bpy

from .dependencies import PYCOLMAP, SCIPY, found_version, missing_pycolmap, missing_scipy
from .work_folder import kept_bytes, work_folder


class OrigamiPreferences(bpy.types.AddonPreferences):
    """What is installed, and what is kept on disk"""

    bl_idname = __package__.rpartition(".")[0]

    def draw(self, context: bpy.types.Context) -> None:
        """Versions, or what is missing; then the kept results."""
        layout = self.layout
        for package, missing in ((SCIPY, missing_scipy()), (PYCOLMAP, missing_pycolmap())):
            if missing is None:
                layout.label(text=f"{package} {found_version(package)}", icon="CHECKMARK")
            else:
                what, _, remedy = missing.partition(": ")
                layout.label(text=what, icon="ERROR")
                layout.label(text=f"{remedy[0].upper()}{remedy[1:]}", icon="BLANK1")
        if missing_scipy() is not None:
            return
        row = layout.row()
        row.label(text=f"Kept results: {kept_bytes() / 1e6:.0f} MB in {work_folder()}", icon="DISK_DRIVE")
        row.operator("origami.clear_work", text="Clear", icon="TRASH")


def register() -> None:
    """Register the preferences."""
    bpy.utils.register_class(OrigamiPreferences)


def unregister() -> None:
    """Undo `register`."""
    bpy.utils.unregister_class(OrigamiPreferences)
