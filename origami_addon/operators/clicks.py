"""Finds where the user clicks."""

from __future__ import annotations

import bpy


def view_under_mouse(window: bpy.types.Window, event: bpy.types.Event) -> bpy.types.Region | None:
    """The main region of the 3D view under the mouse; None over a sidebar, a header or another editor."""
    for area in window.screen.areas:
        if area.type != "VIEW_3D":
            continue
        # Regions that overlap the view, such as sidebars, are on top.
        under = [each for each in area.regions if _is_in(each, event)]
        if under and all(each.type == "WINDOW" for each in under):
            return under[0]
    return None


def _is_in(region: bpy.types.Region, event: bpy.types.Event) -> bool:
    x, y = event.mouse_x - region.x, event.mouse_y - region.y
    return 0 <= x < region.width and 0 <= y < region.height
