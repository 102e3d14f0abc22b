"""What is registered with Blender, in order; taken back the other way round."""

from __future__ import annotations

import bpy

from . import operators, properties
from .jobs import running

_CLASSES = operators.CLASSES


def register() -> None:
    """Make properties, operators and panels known to Blender."""
    properties.register()
    for each in _CLASSES:
        bpy.utils.register_class(each)


def unregister() -> None:
    """The counterpart of `register`; a job that runs is ended."""
    running.end()
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
    properties.unregister()
