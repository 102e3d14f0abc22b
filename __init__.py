"""Origami flattens photographed sheets of paper.

Blender asks for this file beside the manifest; the add-on is next door.
"""


def register() -> None:
    """Called by Blender when the extension is enabled."""
    from . import origami_addon

    origami_addon.register()


def unregister() -> None:
    """Called by Blender when the extension is disabled."""
    from . import origami_addon

    origami_addon.unregister()
