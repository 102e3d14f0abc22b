"""Entries in Blender's own menus."""

from __future__ import annotations

from typing import Any

import bpy

from ..operators.unwrap_developable import menu as unwrap_entry


def _import(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    add_photos_button(self.layout, text="Document Photos (.jpg, .heic, .avif, .png, .tif, .webp)", new=True)
    self.layout.operator("origami.add_folders", text="Folders of Document Photos")


def add_photos_button(layout: Any, *, text: str, new: bool, icon: str = "NONE") -> None:
    """A button that asks for photos, for a new or the current document, without rectifying them at once."""
    button = layout.operator("origami.add_photos", text=text, icon=icon)
    button.new, button.rectify = new, False


def register() -> None:
    """Add the entries."""
    bpy.types.TOPBAR_MT_file_import.append(_import)
    # The UV menu of the 3D view shows the entries of the UV editor's menu.
    bpy.types.IMAGE_MT_uvs_unwrap.append(unwrap_entry)


def unregister() -> None:
    """Remove the entries."""
    bpy.types.IMAGE_MT_uvs_unwrap.remove(unwrap_entry)
    bpy.types.TOPBAR_MT_file_import.remove(_import)
