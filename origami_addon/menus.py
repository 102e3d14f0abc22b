"""Entries in Blender's own menus."""

from __future__ import annotations

import bpy

from .operators.unwrap_developable import menu as unwrap_entry

# The UV menus of the 3D view and of the UV editor.
_UV_MENUS = ("VIEW3D_MT_uv_map", "IMAGE_MT_uvs_unwrap")


def _import(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    self.layout.operator("origami.add_photos", text="Document Photos (.jpg, .png, .tif, .webp)").new = True


def register() -> None:
    """Add the entries."""
    bpy.types.TOPBAR_MT_file_import.append(_import)
    for name in _UV_MENUS:
        getattr(bpy.types, name).append(unwrap_entry)


def unregister() -> None:
    """Take them out."""
    for name in _UV_MENUS:
        getattr(bpy.types, name).remove(unwrap_entry)
    bpy.types.TOPBAR_MT_file_import.remove(_import)
