"""Blender's properties for declared settings (`core/setting.py`)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ...core.setting import FOLDER, Setting, declarations

# How Blender shows a number with a unit.
_LOOKS: dict[str, dict[str, Any]] = {"pixels": {"subtype": "PIXEL"}, "dpi": {"precision": 0}}


def properties_of(settings: type, groups: Mapping[type, type] | None = None) -> dict[str, Any]:
    """The annotations of a property group for a settings dataclass.

    Parameters
    ----------
    settings : type
    groups : mapping of type to type, optional
        The property group of each settings dataclass in it.
    """
    return {
        each.name: PointerProperty(type=(groups or {})[each.kind], name=each.label, description=sentence(each.help))
        if each.is_group
        else declared_property(each)
        for each in shown_settings(settings)
    }


def shown_settings(settings: type) -> Iterator[Setting]:
    """The settings of a dataclass that have a single Blender property."""
    return (each for each in declarations(settings) if each.label and each.kind is not tuple)


def declared_property(declared: Setting) -> Any:
    """The property for a setting; 0 or an empty text means None, if the setting may be None."""
    common: dict[str, Any] = {"name": declared.label, "description": sentence(declared.help)}
    if declared.default is None:
        none = 0 if declared.kind in (int, float) else "empty"
        common["description"] += f"; {none}: {declared.without}" if declared.without else ""
    else:
        common["default"] = declared.default
    if declared.kind is bool:
        return BoolProperty(**common)
    if declared.kind is str and declared.choices:
        return EnumProperty(**common, items=choice_items(declared))
    if declared.kind is str:
        return StringProperty(**common, **({"subtype": "DIR_PATH"} if declared.value_name == FOLDER else {}))
    kind = IntProperty if declared.kind is int else FloatProperty
    ends = {
        "min": 0 if declared.default is None else declared.least,
        "max": declared.most,
        "soft_min": declared.usual[0],
        "soft_max": declared.usual[1],
    }
    ends = {name: declared.kind(end) for name, end in ends.items() if end is not None}
    return kind(**common, **ends, **_LOOKS.get(declared.unit, {}))


def choice_items(declared: Setting) -> list[tuple[str, str, str]]:
    """The choices of a setting for Blender."""
    return [(word, choice.label, sentence(choice.help)) for word, choice in declared.choices.items()]


def sentence(text: str) -> str:
    """A declared text with a capital letter, for Blender."""
    return text[:1].upper() + text[1:]
