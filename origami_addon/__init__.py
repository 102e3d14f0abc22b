"""The Blender side: adapters between the core's arrays and Blender's data, the steps of a run, operators and panels."""

from __future__ import annotations

from types import ModuleType

_registered: list[ModuleType] = []


def register() -> None:
    """Register the add-on with Blender; without scipy only its preferences, which say that it is missing."""
    from . import preferences
    from .dependencies import missing_scipy

    parts = [preferences]
    if missing_scipy() is None:
        from . import addon

        parts.append(addon)
    for part in parts:
        part.register()
        _registered.append(part)


def unregister() -> None:
    """Remove everything that `register` added."""
    while _registered:
        _registered.pop().unregister()
