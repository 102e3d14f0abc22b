"""Operators that start a document and ask for its kind."""

from __future__ import annotations

from bpy.props import EnumProperty

from ..presets import PRESETS, UNKNOWN


class AsksForKind:
    """A mix-in for operators with a property ``preset``, whose settings a new document starts with."""

    preset: EnumProperty(
        name="Kind",
        description="Settings to start with",
        items=[(name, preset.label, preset.description) for name, preset in PRESETS.items()],
        default=UNKNOWN,
    )
