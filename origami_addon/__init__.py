"""The Blender side: adapters between the core's arrays and Blender's data, the steps of a run, operators and panels."""


def register() -> None:
    """Make the add-on known to Blender."""
    from . import addon

    addon.register()


def unregister() -> None:
    """Leave nothing of the add-on behind."""
    from . import addon

    addon.unregister()
