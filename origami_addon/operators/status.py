"""The line at the window's lower edge, which each workspace has for itself."""

from __future__ import annotations

from collections.abc import Iterable

import bpy


def clear_status(workspaces: Iterable[str]) -> None:
    """Clear the line of these workspaces, wherever the user has gone since it was set."""
    for name in workspaces:
        workspace = bpy.data.workspaces.get(name)
        if workspace is not None:
            # Blender sets the line of the workspace that it is in, whichever one the function is called on.
            with bpy.context.temp_override(workspace=workspace):
                workspace.status_text_set(None)
