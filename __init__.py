"""Origami flattens photographed sheets of paper.

Blender needs this file beside the manifest; the add-on itself is in `origami_addon/`.
"""


def register() -> None:
    """Called by Blender when the extension is enabled."""
    from . import origami_addon

    origami_addon.register()


def unregister() -> None:
    """Called by Blender when the extension is disabled."""
    from . import origami_addon

    origami_addon.unregister()
