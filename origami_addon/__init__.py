"""The Blender side: adapters between the core's arrays and Blender's data, and the steps of a run."""


def register() -> None:
    """Nothing to register yet: the command line is the only way in."""


def unregister() -> None:
    """The counterpart of `register`."""
