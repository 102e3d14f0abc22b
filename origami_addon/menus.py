"""Entries in Blender's own menus."""

from __future__ import annotations

import bpy


def _import(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    self.layout.operator("origami.add_photos", text="Document Photos (.jpg, .png, .tif, .webp)").new = True


def register() -> None:
    """Add the entries."""
    bpy.types.TOPBAR_MT_file_import.append(_import)


def unregister() -> None:
    """Take them out."""
    bpy.types.TOPBAR_MT_file_import.remove(_import)
