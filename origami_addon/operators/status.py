"""The status line at the window's lower edge; each workspace has its own."""

from __future__ import annotations

from collections.abc import Iterable

import bpy


def clear_status(workspaces: Iterable[str]) -> None:
    """Clear the line of these workspaces, whichever one the user is in now."""
    for name in workspaces:
        workspace = bpy.data.workspaces.get(name)
        if workspace is not None:
            # Blender sets the line of the current workspace, whichever one the function is called on.
            with bpy.context.temp_override(workspace=workspace):
                workspace.status_text_set(None)
